// The rig as it turns: motor, collars and bit on a shaft that twists.

import { context } from "./canvas.js";
import { colour, font, typeSize } from "./theme.js";

/** @typedef {{bit: number, angle: number, twist12: number, twist23: number, force: number}} Pose */

const FLAT = 0.3;
const STRANDS = 6;
const MARKS = 4;
const PIECES = 24;

/**
 * Draw a rig. `stuckBelow` is the speed (rad/s) below which the bit counts as standing.
 * @param {HTMLCanvasElement} canvas
 * @param {Pose} pose
 * @param {string} own colour of the lane
 * @param {number} stuckBelow
 * @param {number} largestForce
 */
export function drawDiscs(canvas, pose, own, stuckBelow, largestForce) {
  const found = context(canvas);
  if (!found) return;
  const { c, width, height } = found;
  c.clearRect(0, 0, width, height);
  const size = typeSize();
  const radius = Math.min(0.34 * width, 0.16 * height);
  const middle = 0.5 * width;
  const top = FLAT * radius + 1.7 * size;
  const bottom = height - FLAT * radius - 2.2 * size;
  const collars = top + 0.5 * (bottom - top);
  const [bit, collar, drive] = [pose.angle, pose.angle - pose.twist12, pose.angle - pose.twist12 - pose.twist23];
  shaft(c, middle, top, collars, 0.2 * radius, drive, collar);
  shaft(c, middle, collars, bottom, 0.2 * radius, collar, bit);
  disc(c, middle, bottom, radius, bit, own);
  disc(c, middle, collars, 0.86 * radius, collar, colour("collar"));
  disc(c, middle, top, 0.72 * radius, drive, colour("top"));
  press(c, middle + radius, bottom, radius, pose.force / largestForce);
  c.font = font(0.82);
  c.fillStyle = colour("quiet");
  c.textAlign = "left";
  c.textBaseline = "middle";
  c.fillText("drive", 2, top - FLAT * radius - 0.8 * size);
  c.fillText("collars", 2, collars - FLAT * radius - 1.1 * size);
  const stuck = Math.abs(pose.bit) < stuckBelow;
  c.fillText("bit", 2, bottom - FLAT * radius - 1.1 * size);
  c.textAlign = "center";
  c.fillStyle = stuck ? colour("wrong") : colour("ink");
  c.font = font(0.9);
  c.fillText(stuck ? "stuck" : `${pose.bit.toFixed(2).replace("-", "−")} rad/s`, middle, height - 0.7 * size);
}

/**
 * A disc with marks on its rim that turn with it.
 * @param {CanvasRenderingContext2D} c
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 * @param {number} angle
 * @param {string} fill
 */
function disc(c, x, y, radius, angle, fill) {
  const thick = 0.22 * radius;
  c.fillStyle = fill;
  c.globalAlpha = 0.55;
  c.beginPath();
  c.ellipse(x, y + thick, radius, FLAT * radius, 0, 0, Math.PI);
  c.lineTo(x - radius, y);
  c.ellipse(x, y, radius, FLAT * radius, 0, Math.PI, 0, true);
  c.fill();
  c.globalAlpha = 1;
  c.beginPath();
  c.ellipse(x, y, radius, FLAT * radius, 0, 0, 2 * Math.PI);
  c.fill();
  c.strokeStyle = colour("card");
  c.lineWidth = Math.max(1.5, 0.06 * radius);
  for (let k = 0; k < MARKS; k++) {
    const at = angle + (2 * Math.PI * k) / MARKS;
    const inner = k === 0 ? 0.25 : 0.72;
    c.beginPath();
    c.moveTo(x + inner * radius * Math.cos(at), y + inner * FLAT * radius * Math.sin(at));
    c.lineTo(x + 0.96 * radius * Math.cos(at), y + 0.96 * FLAT * radius * Math.sin(at));
    c.stroke();
  }
}

/**
 * A shaft between two discs, whose strands wind as it twists.
 * @param {CanvasRenderingContext2D} c
 * @param {number} x
 * @param {number} from
 * @param {number} to
 * @param {number} radius
 * @param {number} upper
 * @param {number} lower
 */
function shaft(c, x, from, to, radius, upper, lower) {
  c.fillStyle = colour("metal");
  c.fillRect(x - radius, from, 2 * radius, to - from);
  c.strokeStyle = colour("metal-dark");
  c.lineWidth = Math.max(1, 0.16 * radius);
  for (let strand = 0; strand < STRANDS; strand++) {
    c.beginPath();
    let drawing = false;
    for (let k = 0; k <= PIECES; k++) {
      const share = k / PIECES;
      const at = upper + (lower - upper) * share + (2 * Math.PI * strand) / STRANDS;
      const [px, py] = [x + radius * Math.cos(at), from + (to - from) * share];
      if (Math.sin(at) < 0) {
        drawing = false; // behind the shaft
      } else if (drawing) {
        c.lineTo(px, py);
      } else {
        c.moveTo(px, py);
        drawing = true;
      }
    }
    c.stroke();
  }
}

/**
 * The pin that presses on the bit, with an arrow as long as the force.
 * @param {CanvasRenderingContext2D} c
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 * @param {number} share
 */
function press(c, x, y, radius, share) {
  const long = Math.min(share, 1.2) * 0.8 * radius;
  c.fillStyle = colour("ink");
  c.fillRect(x + 1, y - 0.08 * radius, 0.16 * radius, 0.34 * radius);
  if (long < 2) return;
  c.beginPath();
  c.moveTo(x + 0.2 * radius, y + 0.09 * radius);
  c.lineTo(x + 0.38 * radius, y - 0.06 * radius);
  c.lineTo(x + 0.38 * radius, y + 0.24 * radius);
  c.fill();
  c.fillRect(x + 0.36 * radius, y + 0.05 * radius, Math.min(long, 0.5 * radius), 0.08 * radius);
}
