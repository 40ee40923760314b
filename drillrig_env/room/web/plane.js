// The plane of twist and bit speed: where the rig is, where it came from, the stable cycle and the calm point.

import { apart, Axes, context, mark } from "./canvas.js";
import { colour, font, typeSize } from "./theme.js";

/** @typedef {import("./history.js").History} History */
/** @typedef {import("./types.js").Orbit} Orbit */

const TRAIL = 3;
const LEAST_TWIST = 0.02; // rad, over which the plane reaches at least

/** The plane of a lane; its span grows with what is in it, and is made anew with each run. */
export class Plane {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {string} lane
   */
  constructor(canvas, lane) {
    this.canvas = canvas;
    this.lane = lane;
    /** @type {Orbit | null} */
    this.orbit = null;
    /** Axes, cycle and calm point, which are drawn anew only where they change. */
    this.ground = document.createElement("canvas");
    this.grounded = "";
    this.reset();
  }

  reset() {
    this.low = [Number.POSITIVE_INFINITY, 0];
    this.high = [Number.NEGATIVE_INFINITY, 0];
  }

  /** @param {Orbit} orbit */
  show(orbit) {
    this.orbit = orbit;
    this.grounded = "";
    this.reset();
    for (let k = 0; k < orbit.twist.length; k++) this.#reach(orbit.twist[k], orbit.bit_speed[k]);
    this.#reach(orbit.calm_twist, 2 * orbit.calm_speed);
    this.#reach(0, 0);
  }

  /**
   * @param {number} twist
   * @param {number} speed
   */
  #reach(twist, speed) {
    if (!Number.isFinite(twist + speed)) return;
    this.low = [Math.min(this.low[0], twist), Math.min(this.low[1], speed)];
    this.high = [Math.max(this.high[0], twist), Math.max(this.high[1], speed)];
  }

  /**
   * @param {History} history
   * @param {number} time
   * @param {number} timeScale
   */
  draw(history, time, timeScale) {
    const found = context(this.canvas);
    if (!found) return;
    const { c, width, height } = found;
    c.clearRect(0, 0, width, height);
    const { twist12, bit } = history.columns;
    const last = history.before(time);
    const first = Math.max(history.before(time - TRAIL * timeScale), 0);
    for (let k = first; k <= last; k++) this.#reach(twist12[k], bit[k]);
    if (!Number.isFinite(this.low[0])) return;
    const [left, right] = apart(this.low[0], this.high[0], LEAST_TWIST);
    const [wide, tall] = [right - left, this.high[1] - this.low[1] || 1];
    const axes = new Axes(width, height, {
      x: [left - 0.06 * wide, right + 0.06 * wide],
      y: [this.low[1] - 0.06 * tall, this.high[1] + 0.06 * tall],
    });
    this.#drawGround(axes, width, height);
    c.drawImage(this.ground, 0, 0, width, height);
    const own = colour(this.lane.toLowerCase());
    axes.inside(c, () => {
      c.lineWidth = typeSize() / 7;
      c.strokeStyle = own;
      c.beginPath();
      let pen = false;
      for (let k = first; k <= last; k++) {
        if (Number.isNaN(bit[k])) {
          pen = false;
          continue;
        }
        if (pen) c.lineTo(axes.x(twist12[k]), axes.y(bit[k]));
        else c.moveTo(axes.x(twist12[k]), axes.y(bit[k]));
        pen = true;
      }
      c.stroke();
      if (last >= 0) {
        mark(c, this.lane, axes.x(twist12[last]), axes.y(bit[last]), 0.45 * typeSize());
        c.fillStyle = own;
        c.fill();
        c.lineWidth = 1.5;
        c.strokeStyle = colour("card");
        c.stroke();
      }
    });
  }

  /**
   * @param {Axes} axes
   * @param {number} width
   * @param {number} height
   */
  #drawGround(axes, width, height) {
    const now = [...axes.span.x, ...axes.span.y, this.canvas.width, this.canvas.height, colour("ink"), typeSize()].join();
    if (now === this.grounded) return;
    this.grounded = now;
    this.ground.width = this.canvas.width;
    this.ground.height = this.canvas.height;
    const c = this.ground.getContext("2d");
    if (!c) return;
    c.scale(this.canvas.width / width, this.canvas.height / height);
    axes.draw(c, "twist of bit against collars, rad", "bit speed, rad/s", "bit, rad/s");
    const orbit = this.orbit;
    if (orbit) axes.inside(c, () => this.#drawOrbit(c, axes, orbit));
  }

  /**
   * @param {CanvasRenderingContext2D} c
   * @param {Axes} axes
   * @param {Orbit} orbit
   */
  #drawOrbit(c, axes, orbit) {
    const size = typeSize();
    c.strokeStyle = colour("hatch");
    c.lineWidth = 0.45 * size;
    c.globalAlpha = 0.45;
    c.beginPath();
    for (let k = 0; k < orbit.twist.length; k++) c.lineTo(axes.x(orbit.twist[k]), axes.y(orbit.bit_speed[k]));
    c.stroke();
    c.globalAlpha = 1;
    const [x, y] = [axes.x(orbit.calm_twist), axes.y(orbit.calm_speed)];
    c.strokeStyle = colour("ink");
    c.lineWidth = 2;
    const arm = 0.45 * size;
    c.beginPath();
    c.moveTo(x - arm, y);
    c.lineTo(x + arm, y);
    c.moveTo(x, y - arm);
    c.lineTo(x, y + arm);
    c.stroke();
    c.font = font(0.78);
    c.fillStyle = colour("ink");
    c.textBaseline = "bottom";
    c.textAlign = x > (axes.box.left + axes.box.right) / 2 ? "right" : "left";
    c.fillText("calm", x + (c.textAlign === "left" ? 1 : -1) * 0.6 * size, y - 0.25 * size);
  }
}
