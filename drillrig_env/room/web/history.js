// What a lane has shown: the newest minutes, in arrays that plots take as they are.

import { GIVEN_AT, SIGNAL, VALUE } from "./frames.js";

/** @typedef {import("./frames.js").Frame} Frame */

const MOST = 40_000;

/** What is kept of every sample, besides its time. */
const COLUMNS = /** @type {const} */ ([
  "bit", "collar", "top", "twist12", "twist23", "torque", "current", "reference", "target", "force",
  "variance", "tracking", "effort", "angle",
]);
/** @typedef {typeof COLUMNS[number]} Column */

/** Samples of one lane, oldest first; where it is full, the older half goes. */
export class History {
  constructor() {
    this.time = new Float64Array(MOST);
    /** @type {Record<Column, Float64Array>} */
    this.columns = /** @type {Record<Column, Float64Array>} */ (
      Object.fromEntries(COLUMNS.map((name) => [name, new Float64Array(MOST)]))
    );
    this.length = 0;
  }

  clear() {
    this.length = 0;
  }

  get end() {
    return this.length ? this.time[this.length - 1] : 0;
  }

  /**
   * @param {Frame} frame
   * @param {number} lane
   */
  add(frame, lane) {
    const { steps, samples, period } = frame;
    const { values, signals } = frame.lanes[lane];
    const c = this.columns;
    const width = steps * samples;
    if (this.length + width + 1 > MOST) this.#halve();
    if (frame.gap && this.length) this.#addGap(frame.first * period);
    const h = period / samples;
    for (let k = 0; k < width; k++) {
      const step = Math.floor(k / samples);
      const at = this.length;
      const value = 7 * step;
      const given = 5 * step;
      this.time[at] = frame.first * period + (k + 1) * h;
      c.bit[at] = signals[SIGNAL.bit * width + k];
      c.collar[at] = signals[SIGNAL.collar * width + k];
      c.top[at] = signals[SIGNAL.top * width + k];
      c.twist12[at] = signals[SIGNAL.twist12 * width + k];
      c.twist23[at] = signals[SIGNAL.twist23 * width + k];
      c.torque[at] = signals[SIGNAL.torque * width + k];
      c.current[at] = signals[SIGNAL.current * width + k];
      c.reference[at] = values[value + VALUE.reference];
      c.variance[at] = values[value + VALUE.variance];
      c.tracking[at] = values[value + VALUE.tracking];
      c.effort[at] = values[value + VALUE.effort];
      c.target[at] = frame.given[given + GIVEN_AT.target];
      c.force[at] = frame.given[given + GIVEN_AT.normalForce];
      const before = at ? c.angle[at - 1] : 0;
      c.angle[at] = (Number.isNaN(before) ? 0 : before) + c.bit[at] * h;
      this.length = at + 1;
    }
  }

  /**
   * The index of the last sample at or before a time.
   * @param {number} time
   */
  before(time) {
    let low = 0;
    let high = this.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time[middle] <= time) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }

  /** @param {number} time */
  #addGap(time) {
    this.time[this.length] = time;
    for (const name of COLUMNS) {
      this.columns[name][this.length] = name === "angle" ? this.columns.angle[this.length - 1] : Number.NaN;
    }
    this.length += 1;
  }

  #halve() {
    const from = this.length >> 1;
    this.time.copyWithin(0, from, this.length);
    for (const name of COLUMNS) this.columns[name].copyWithin(0, from, this.length);
    this.length -= from;
  }
}
