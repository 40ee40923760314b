// The map of this rig and friction: where only stick-slip is, where either, where only calm; and the operating point.

import { Axes, context, mark } from "./canvas.js";
import { colour, font, typeSize } from "./theme.js";

/** @typedef {import("./types.js").Chart} Chart */

/** The map of a lane. */
export class RigMap {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {string} lane
   */
  constructor(canvas, lane) {
    this.canvas = canvas;
    this.lane = lane;
    /** @type {Chart | null} */
    this.chart = null;
    this.drawn = "";
  }

  /** Have it drawn anew. */
  forget() {
    this.drawn = "";
  }

  /**
   * @param {number} target
   * @param {number} force
   * @param {number} reference
   * @param {number} fastest
   * @param {number} largest
   */
  draw(target, force, reference, fastest, largest) {
    const size = [this.canvas.clientWidth, this.canvas.clientHeight, typeSize(), colour("ink")];
    const now = [target, force, reference.toFixed(3), fastest, largest, ...size].join();
    if (now === this.drawn) return;
    this.drawn = now;
    const found = context(this.canvas);
    if (!found) return;
    const { c, width, height } = found;
    c.clearRect(0, 0, width, height);
    const x = /** @type {[number, number]} */ ([0, Math.max(fastest, 1.05 * target, 1.05 * reference)]);
    const axes = new Axes(width, height, { x, y: [0, Math.max(largest, 1.05 * force)] });
    axes.inside(c, () => this.#regions(c, axes));
    axes.draw(c, "speed, rad/s", "normal force N₁, N", "N₁, N");
    const chart = this.chart;
    if (!chart) return;
    axes.inside(c, () => {
      this.#border(c, axes, chart.end_forces, chart.end, [7, 4]);
      this.#border(c, axes, chart.forces, chart.critical, []);
      this.#words(c, axes, chart);
      const size = typeSize();
      const own = colour(this.lane.toLowerCase());
      c.strokeStyle = own;
      c.lineWidth = 2;
      mark(c, this.lane, axes.x(target), axes.y(force), 0.62 * size);
      c.stroke();
      mark(c, this.lane, axes.x(reference), axes.y(force), 0.36 * size);
      c.fillStyle = own;
      c.fill();
      c.lineWidth = 1.5;
      c.strokeStyle = colour("card");
      c.stroke();
    });
  }

  /**
   * @param {CanvasRenderingContext2D} c
   * @param {Axes} axes
   */
  #regions(c, axes) {
    const chart = this.chart;
    if (!chart || !chart.forces.length) return;
    c.fillStyle = colour("region");
    this.#area(c, axes, chart.forces, chart.critical);
    c.fill();
    c.save();
    this.#area(c, axes, chart.end_forces, chart.end);
    c.clip();
    c.strokeStyle = colour("hatch");
    c.lineWidth = 1;
    c.globalAlpha = 0.6;
    const { left, right, top, bottom } = axes.box;
    const apart = 0.6 * typeSize();
    c.beginPath();
    for (let start = left - (bottom - top); start < right; start += apart) {
      c.moveTo(start, bottom);
      c.lineTo(start + (bottom - top), top);
    }
    c.stroke();
    c.restore();
    c.fillStyle = colour("region");
    this.#area(c, axes, chart.forces, chart.critical);
    c.fill();
  }

  /**
   * The area from standstill to a border.
   * @param {CanvasRenderingContext2D} c
   * @param {Axes} axes
   * @param {number[]} forces
   * @param {(number | null)[]} border
   */
  #area(c, axes, forces, border) {
    c.beginPath();
    c.moveTo(axes.x(0), axes.y(0));
    forces.forEach((force, k) => {
      c.lineTo(axes.x(Math.min(border[k] ?? 0, 2 * axes.span.x[1])), axes.y(force));
    });
    c.lineTo(axes.x(0), axes.y(forces[forces.length - 1] ?? 0));
    c.closePath();
  }

  /**
   * @param {CanvasRenderingContext2D} c
   * @param {Axes} axes
   * @param {number[]} forces
   * @param {(number | null)[]} speeds
   * @param {number[]} dash
   */
  #border(c, axes, forces, speeds, dash) {
    c.strokeStyle = colour("ink");
    c.lineWidth = 0.115 * typeSize();
    c.setLineDash(dash);
    c.beginPath();
    let pen = false;
    forces.forEach((force, k) => {
      const speed = speeds[k];
      if (speed === null || speed <= 0) {
        pen = false;
        return;
      }
      if (pen) c.lineTo(axes.x(speed), axes.y(force));
      else c.moveTo(axes.x(speed), axes.y(force));
      pen = true;
    });
    c.stroke();
    c.setLineDash([]);
  }

  /**
   * The names of the regions, each where it has room.
   * @param {CanvasRenderingContext2D} c
   * @param {Axes} axes
   * @param {Chart} chart
   */
  #words(c, axes, chart) {
    c.font = font(0.78);
    c.textBaseline = "middle";
    c.textAlign = "center";
    const [high, low] = [0.86 * axes.span.y[1], 0.13 * axes.span.y[1]];
    if (!chart.forces.length) {
      c.fillStyle = colour("quiet");
      c.textAlign = "left";
      c.fillText("no map of this rig", axes.box.left + 8, axes.box.top + 16);
      return;
    }
    const critical = at(chart.forces, chart.critical, high) ?? axes.span.x[1];
    const end = at(chart.end_forces, chart.end, high) ?? critical;
    this.#word(c, axes, "stick-slip", 0, Math.min(critical, axes.span.x[1]), high);
    this.#word(c, axes, "either", critical, Math.min(end, axes.span.x[1]), high);
    const calm = at(chart.end_forces, chart.end, low) ?? at(chart.forces, chart.critical, low) ?? 0;
    this.#word(c, axes, "calm", calm, axes.span.x[1], low);
  }

  /**
   * @param {CanvasRenderingContext2D} c
   * @param {Axes} axes
   * @param {string} word
   * @param {number} from
   * @param {number} to
   * @param {number} force
   */
  #word(c, axes, word, from, to, force) {
    const [left, right] = [axes.x(from), axes.x(to)];
    const wide = c.measureText(word).width + 8;
    if (right - left < wide) return;
    const x = (left + right) / 2;
    const tall = 1.1 * typeSize();
    c.fillStyle = colour("card");
    c.globalAlpha = 0.85;
    c.fillRect(x - wide / 2, axes.y(force) - tall / 2, wide, tall);
    c.globalAlpha = 1;
    c.fillStyle = colour("ink");
    c.fillText(word, x, axes.y(force));
  }
}

/**
 * A border at a force, from the nearest force for which it is known.
 * @param {number[]} forces
 * @param {(number | null)[]} speeds
 * @param {number} force
 */
function at(forces, speeds, force) {
  let best = 0;
  for (let k = 0; k < forces.length; k++) if (Math.abs(forces[k] - force) < Math.abs(forces[best] - force)) best = k;
  return speeds[best] ?? null;
}
