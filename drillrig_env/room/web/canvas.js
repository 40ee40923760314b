// A canvas as sharp as the screen, and axes with ticks and units on it.

import { colour, font, typeSize } from "./theme.js";

/** @typedef {{left: number, top: number, right: number, bottom: number}} Box */
/** @typedef {{x: [number, number], y: [number, number]}} Span */

/**
 * Size a canvas to where it stands; its context in CSS pixels, or null where it has no place.
 * @param {HTMLCanvasElement} canvas
 */
export function context(canvas) {
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (width < 20 || height < 20) return null;
  const scale = window.devicePixelRatio || 1;
  const [w, h] = [Math.round(width * scale), Math.round(height * scale)];
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
  }
  const c = canvas.getContext("2d");
  if (!c) return null;
  c.setTransform(scale, 0, 0, scale, 0, 0);
  return { c, width, height };
}

/**
 * Ends that lie at least so far apart, about the same middle: what hardly changes is drawn as a line at rest.
 * @param {number} low
 * @param {number} high
 * @param {number} least
 * @returns {[number, number]}
 */
export function apart(low, high, least) {
  const short = Math.max(least - (high - low), 0) / 2;
  return [low - short, high + short];
}

/**
 * Round steps for an axis: about `count` of them.
 * @param {number} low
 * @param {number} high
 * @param {number} count
 */
export function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough) ?? rough;
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return { step, values: found };
}

/**
 * A number as an axis shows it.
 * @param {number} value
 * @param {number} step
 */
export function shown(value, step) {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return (Math.abs(value) < 1e-12 ? 0 : value).toFixed(Math.min(digits, 6)).replace("-", "−");
}

/** Axes that map numbers to pixels inside a box. */
export class Axes {
  /**
   * @param {number} width
   * @param {number} height
   * @param {Span} span
   */
  constructor(width, height, span) {
    const size = typeSize();
    this.box = { left: 3.2 * size, top: 0.6 * size, right: width - 0.6 * size, bottom: height - 2.9 * size };
    this.span = span;
  }

  /** @param {number} value */
  x(value) {
    const { left, right } = this.box;
    return left + ((value - this.span.x[0]) / (this.span.x[1] - this.span.x[0])) * (right - left);
  }

  /** @param {number} value */
  y(value) {
    const { top, bottom } = this.box;
    return bottom - ((value - this.span.y[0]) / (this.span.y[1] - this.span.y[0])) * (bottom - top);
  }

  /**
   * @param {CanvasRenderingContext2D} c
   * @param {string} xLabel
   * @param {string} yLabel
   * @param {string} short what stands at the upright axis where there is little room
   */
  draw(c, xLabel, yLabel, short = yLabel) {
    const { left, top, right, bottom } = this.box;
    const size = typeSize();
    c.font = font(0.8);
    c.lineWidth = 1;
    c.fillStyle = colour("quiet");
    c.textAlign = "center";
    c.textBaseline = "top";
    const across = ticks(...this.span.x, (right - left) / (4.2 * size));
    for (const value of across.values) {
      c.strokeStyle = colour("grid");
      line(c, this.x(value), top, this.x(value), bottom);
      c.fillText(shown(value, across.step), this.x(value), bottom + 0.25 * size);
    }
    c.textAlign = "right";
    c.textBaseline = "middle";
    const up = ticks(...this.span.y, (bottom - top) / (2.6 * size));
    for (const value of up.values) {
      c.strokeStyle = colour("grid");
      line(c, left, this.y(value), right, this.y(value));
      c.fillText(shown(value, up.step), left - 0.35 * size, this.y(value));
    }
    c.fillStyle = colour("ink");
    c.textAlign = "center";
    c.textBaseline = "bottom";
    c.fillText(xLabel, (left + right) / 2, bottom + 2.75 * size);
    c.save();
    c.translate(0.25 * size, (top + bottom) / 2);
    c.rotate(-Math.PI / 2);
    c.textBaseline = "top";
    c.fillText(c.measureText(yLabel).width < bottom - top + 1.5 * size ? yLabel : short, 0, 0);
    c.restore();
    c.strokeStyle = colour("line");
    c.strokeRect(left, top, right - left, bottom - top);
  }

  /**
   * Draw inside the box alone.
   * @param {CanvasRenderingContext2D} c
   * @param {() => void} draw
   */
  inside(c, draw) {
    const { left, top, right, bottom } = this.box;
    c.save();
    c.beginPath();
    c.rect(left, top, right - left, bottom - top);
    c.clip();
    draw();
    c.restore();
  }
}

/**
 * @param {CanvasRenderingContext2D} c
 * @param {number} x0
 * @param {number} y0
 * @param {number} x1
 * @param {number} y1
 */
export function line(c, x0, y0, x1, y1) {
  c.beginPath();
  c.moveTo(x0, y0);
  c.lineTo(x1, y1);
  c.stroke();
}

/**
 * The mark of a lane: a disc for A, a square for B.
 * @param {CanvasRenderingContext2D} c
 * @param {string} lane
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 */
export function mark(c, lane, x, y, radius) {
  c.beginPath();
  if (lane === "B") c.rect(x - 0.9 * radius, y - 0.9 * radius, 1.8 * radius, 1.8 * radius);
  else c.arc(x, y, radius, 0, 2 * Math.PI);
}
