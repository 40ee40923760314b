// What runs over time, plotted by uPlot: speeds, torque and current, the terms of the reward.

import uPlot from "./parts/uPlot.js";
import { apart, shown } from "./canvas.js";
import { colour, font, typeSize } from "./theme.js";

/** @typedef {import("./history.js").History} History */
/** @typedef {import("./history.js").Column} Column */
/** @typedef {{column: Column, label: string, colour: string, width: number, dash?: number[], scale?: string}} Curve */
/** @typedef {{label: string, curves: Curve[], right?: string, floor?: number, least?: number, stepped?: boolean}} Kind */

const MOST_POINTS = 8000;
const POINTS_PER_PIXEL = 2;
const LEAST = 0.1; // of the largest value of the run so far, over which an axis reaches at least
const SAMPLES = 16; // a control step, in which a reward does not change

/** Steps of ticks: 1, 2 and 5 times a power of ten, so that few digits tell them. */
const STEPS = Array.from({ length: 16 }, (_, k) => [1, 2, 5].map((m) => m * 10 ** (k - 6))).flat();

/**
 * The plots of a lane; `own` is the name of its colour.
 * @param {string} own
 * @returns {Record<"speeds" | "torques" | "rewards", Kind>}
 */
export function kinds(own) {
  return {
    speeds: {
      label: "rad/s",
      floor: 0,
      curves: [
        { column: "target", label: "target", colour: "hatch", width: 3 },
        { column: "collar", label: "collars", colour: "collar", width: 1.2, dash: [5, 3] },
        { column: "bit", label: "bit", colour: own, width: 2.2 },
        { column: "top", label: "top drive", colour: "top", width: 1.4 },
        { column: "reference", label: "reference", colour: "ink", width: 1.4, dash: [2, 3] },
      ],
    },
    torques: {
      label: "N m",
      right: "A",
      curves: [
        { column: "torque", label: "torque into the string, N m", colour: own, width: 2.2 },
        { column: "current", label: "current, A", colour: "ink", width: 1, dash: [5, 4], scale: "right" },
      ],
    },
    rewards: {
      label: "",
      least: 0.02,
      stepped: true,
      curves: [
        { column: "effort", label: "action", colour: "top", width: 1.2, dash: [2, 3] },
        { column: "tracking", label: "tracking", colour: "collar", width: 1.3, dash: [5, 3] },
        { column: "variance", label: "variance", colour: "ink", width: 1.5 },
      ],
    },
  };
}

/** One plot in its place; it is made anew when size or colours change. */
export class Lines {
  /**
   * @param {HTMLElement} place
   * @param {Kind} kind
   * @param {HTMLElement} caption
   * @param {string} title
   */
  constructor(place, kind, caption, title) {
    this.place = place;
    this.kind = kind;
    this.caption = caption;
    this.title = title;
    this.last = false; // whether time is written below
    /** @type {uPlot | null} */
    this.plot = null;
    /** @type {Record<string, [number, number]>} */
    this.spans = {};
    /** @type {Record<string, number>} */
    this.largest = {};
    this.made = "";
    /** Time, and a buffer for each curve. */
    this.buffers = Array.from({ length: kind.curves.length + 1 }, () => new Float64Array(MOST_POINTS));
  }

  /** Forget how far the axes reached. */
  reset() {
    this.spans = {};
    this.largest = {};
  }

  /** Make the plot for its place as that is now. */
  #make() {
    const width = this.place.clientWidth;
    const height = this.place.clientHeight;
    const made = [width, height, document.documentElement.dataset.theme, typeSize(), this.last].join();
    if (made === this.made) return;
    this.made = made;
    this.plot?.destroy();
    this.plot = null;
    this.place.replaceChildren();
    if (width < 80 || height < 30) return;
    this.#legend();
    const size = typeSize();
    const axis = {
      stroke: colour("quiet"),
      font: font(0.8),
      grid: { stroke: colour("grid"), width: 1 },
      ticks: { show: false },
      incrs: STEPS,
    };
    /** @param {uPlot} _ @param {number[]} values */
    const values = (_, values) => values.map((v) => shown(v, values.length > 1 ? values[1] - values[0] : 1));
    const label = { labelSize: 1.2 * size, labelFont: font(0.8), labelGap: 0 };
    // Two numbers at least on an axis, as long as there is room for them.
    /** @param {uPlot} _ @param {number} _axis @param {number} _low @param {number} _high @param {number} tall */
    const space = (_, _axis, _low, _high, tall) => Math.max(1.1 * size, Math.min(1.9 * size, tall / 5));
    /** @type {uPlot.Axis[]} */
    const axes = [
      { ...axis, show: true, size: this.last ? 1.4 * size : 0.5 * size, gap: 3, values: this.last ? values : () => [],
        label: this.last ? "time, s" : undefined, ...(this.last ? label : {}) },
      { ...axis, scale: "y", size: 2.7 * size, gap: 3, space, values, label: this.kind.label, ...label },
    ];
    if (this.kind.right) {
      axes.push({ ...axis, scale: "right", side: 1, size: 2.5 * size, gap: 3, space, values,
        label: this.kind.right, ...label, grid: { show: false } });
    }
    /** @param {string} scale @returns {uPlot.Range.Function} */
    const range = (scale) => () => this.spans[scale] ?? [0, 1];
    this.plot = new uPlot(
      {
        width,
        height,
        padding: [4, this.kind.right ? 0 : 2.5 * size + 1.2 * size, 0, 0],
        legend: { show: false },
        cursor: { show: false },
        scales: { x: { time: false }, y: { range: range("y") }, right: { range: range("right") } },
        axes,
        series: [
          {},
          ...this.kind.curves.map((curve) => ({
            scale: curve.scale ?? "y",
            stroke: colour(curve.colour),
            width: (curve.width * size) / 14,
            dash: curve.dash?.map((long) => (long * size) / 14),
            points: { show: false },
            spanGaps: false,
          })),
        ],
      },
      [[0, 1], ...this.kind.curves.map(() => [0, 0])],
      this.place,
    );
  }

  #legend() {
    const title = document.createElement("span");
    title.textContent = this.title;
    const keys = [...this.kind.curves].map((curve) => {
      const key = document.createElement("span");
      key.className = "key";
      const sample = document.createElement("i");
      sample.style.borderTopColor = colour(curve.colour);
      sample.style.borderTopWidth = `${Math.max(2, Math.round(curve.width))}px`;
      if (curve.dash) sample.className = curve.dash[0] > 2 ? "dashed" : "dotted";
      key.append(sample, curve.label);
      return key;
    });
    this.caption.replaceChildren(title, ...keys);
  }

  /**
   * Draw the window of `span` s that ends at `time`.
   * @param {History} history
   * @param {number} time
   * @param {number} span
   */
  draw(history, time, span) {
    this.#make();
    if (!this.plot) return;
    const last = history.before(time);
    const first = Math.max(history.before(time - span), 0);
    const points = Math.min(POINTS_PER_PIXEL * this.plot.width, MOST_POINTS - 2);
    const stride = Math.max(this.kind.stepped ? SAMPLES : 1, Math.ceil((last - first) / points));
    const start = Math.ceil(first / stride) * stride;
    let count = 0;
    for (let k = start; k <= last; k += stride) this.buffers[0][count++] = history.time[k];
    /** @type {Record<string, [number, number]>} */
    const reached = {};
    this.kind.curves.forEach((curve, place) => {
      const from = history.columns[curve.column];
      const into = this.buffers[place + 1];
      const scale = curve.scale ?? "y";
      let [low, high] = reached[scale] ?? [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
      for (let k = start, n = 0; k <= last; k += stride, n++) {
        const value = from[k];
        into[n] = value;
        if (value < low) low = value;
        if (value > high) high = value;
      }
      reached[scale] = [low, high];
    });
    for (const [scale, [low, high]] of Object.entries(reached)) this.#reach(scale, low, high);
    const data = this.buffers.map((buffer) => buffer.subarray(0, count));
    this.plot.setData(/** @type {uPlot.AlignedData} */ (/** @type {unknown} */ (data)), false);
    const from = Math.max(time, span) - span;
    this.plot.setScale("x", { min: from, max: from + span });
  }

  /**
   * Let an axis reach what is shown, and not breathe with every sample.
   * @param {string} scale
   * @param {number} low
   * @param {number} high
   */
  #reach(scale, low, high) {
    if (!Number.isFinite(low + high)) return;
    if (scale === "y" && this.kind.floor !== undefined) low = Math.min(low, this.kind.floor);
    const largest = Math.max(this.largest[scale] ?? 0, Math.abs(low), Math.abs(high));
    this.largest[scale] = largest;
    [low, high] = apart(low, high, Math.max(LEAST * largest, this.kind.least ?? 0));
    const room = 0.08 * (high - low || 1);
    const [was, will] = this.spans[scale] ?? [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
    const fits = low >= was && high <= will && high - low > 0.45 * (will - was);
    if (!fits) this.spans[scale] = [low - (low === this.kind.floor ? 0.3 * room : room), high + room];
  }
}
