// What is kept: files that the server makes, a picture of what is drawn, a link that holds the whole setting.

import { byId, say } from "./controls.js";
import { colour, font } from "./theme.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Setting} Setting */
/** @typedef {import("./panel.js").Panel} Panel */

/**
 * Let the browser save something under a name.
 * @param {string} name
 * @param {Blob} content
 */
export function save(name, content) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  byId("kept").textContent = `${name} is saved`;
}

/**
 * The setting that a link holds, from what stands behind its #.
 * @param {string} hash
 * @returns {Setting}
 */
export function settingOf(hash) {
  /** @type {Setting} */
  const setting = {};
  for (const [name, text] of new URLSearchParams(hash.replace(/^#/, ""))) {
    const value = Number(text);
    setting[name] = text !== "" && Number.isFinite(value) ? value : text;
  }
  return setting;
}

/** @param {State} state */
export function linkOf(state) {
  const parts = new URLSearchParams();
  for (const [name, value] of Object.entries(state.setting)) {
    if (value !== null) parts.set(name, String(value));
  }
  return `${location.origin}${location.pathname}#${parts}`;
}

/**
 * All that is drawn, as one picture.
 * @param {Panel[]} panels
 * @returns {HTMLCanvasElement}
 */
export function picture(panels) {
  const shown = panels.filter((panel) => panel.element.offsetParent !== null);
  const scale = window.devicePixelRatio || 1;
  const boxes = shown.map((panel) => panel.element.getBoundingClientRect());
  const [left, top] = [Math.min(...boxes.map((b) => b.left)), Math.min(...boxes.map((b) => b.top))];
  const [right, bottom] = [Math.max(...boxes.map((b) => b.right)), Math.max(...boxes.map((b) => b.bottom))];
  const whole = document.createElement("canvas");
  whole.width = Math.round((right - left) * scale);
  whole.height = Math.round((bottom - top) * scale);
  const c = /** @type {CanvasRenderingContext2D} */ (whole.getContext("2d"));
  c.scale(scale, scale);
  c.fillStyle = colour("card");
  c.fillRect(0, 0, right - left, bottom - top);
  for (const panel of shown) {
    for (const canvas of panel.element.querySelectorAll("canvas")) {
      const box = canvas.getBoundingClientRect();
      c.drawImage(canvas, box.left - left, box.top - top, box.width, box.height);
    }
    c.textBaseline = "top";
    const words = [panel.part(".badge"), panel.part(".verdict"), ...panel.element.querySelectorAll("figcaption .key, figcaption.borders, .lines figcaption > span:first-child")];
    for (const place of words) {
      const box = place.getBoundingClientRect();
      const text = /** @type {HTMLElement} */ (place).innerText.replace(/\s+/g, " ");
      c.fillStyle = place.classList.contains("badge") ? colour(panel.name.toLowerCase()) : colour("ink");
      c.font = font(place.classList.contains("badge") ? 1.4 : 0.86);
      const sample = place.querySelector("i");
      if (sample) {
        c.strokeStyle = getComputedStyle(sample).borderTopColor;
        c.lineWidth = 2;
        c.setLineDash(sample.className ? [4, 2] : []);
        const at = sample.getBoundingClientRect();
        c.beginPath();
        c.moveTo(at.left - left, at.top - top + 1);
        c.lineTo(at.right - left, at.top - top + 1);
        c.stroke();
        c.setLineDash([]);
      }
      c.fillText(text, box.left - left + (sample ? 23 : 0), box.top - top);
    }
  }
  return whole;
}

/**
 * Read a run from a file, and have it played again.
 * @param {File} file
 * @param {(message: Record<string, unknown>) => void} send
 */
export async function replay(file, send) {
  try {
    if (file.size > 4_000_000) throw new Error(`${file.name} is larger than 4 MB`);
    const run = JSON.parse(await file.text());
    if (Object.prototype.toString.call(run) !== "[object Object]") throw new Error("it holds no JSON object");
    send({ do: "replay", run });
    say("refusal-keep", "");
  } catch (error) {
    say("refusal-keep", `${file.name} is no run that was kept here: ${error instanceof Error ? error.message : error}`);
  }
}
