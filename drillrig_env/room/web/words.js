// What a lane is said to do, in words and numbers: its verdict, and what its controller sees and says.

/** @typedef {import("./frames.js").LaneFrame} LaneFrame */
/** @typedef {import("./types.js").LaneState["channels"]} Channels */

const PAUSE = 200; // ms between two that can be read

/** The words of a lane. */
export class Words {
  /** @param {(selector: string) => HTMLElement} part of the lane's panel */
  constructor(part) {
    this.part = part;
    this.last = 0;
    this.word = "";
  }

  clear() {
    for (const name of [".index", ".mean", ".stuck", ".since"]) this.part(name).textContent = "–";
    this.part(".word").textContent = this.word = "";
  }

  /**
   * Say what the newest control step tells, unless that was just done.
   * @param {LaneFrame} newest
   * @param {Channels | undefined} channels
   */
  say({ verdict, seen, values }, channels) {
    if (performance.now() - this.last <= PAUSE) return;
    this.last = performance.now();
    this.part(".index").textContent = Number.isFinite(verdict.index) ? verdict.index.toFixed(2) : "∞";
    this.part(".mean").textContent = `${verdict.mean.toFixed(2)} rad/s`;
    this.part(".stuck").textContent = `${(100 * verdict.stuck).toFixed(0)} %`;
    this.part(".since").textContent = Number.isNaN(verdict.calmSince) ? "–" : `${verdict.calmSince.toFixed(1)} s`;
    const shakes = verdict.full && !verdict.calm;
    const word = !verdict.full ? "watching …" : verdict.mitigated ? "mitigated" : verdict.calm ? "calm, off target" : verdict.stuck > 0 ? "stick-slip" : "shaking";
    if (word !== this.word) {
      this.word = word;
      const place = this.part(".word");
      place.textContent = word;
      place.dataset.word = shakes ? "shakes" : verdict.calm ? "calm" : "";
    }
    const details = /** @type {HTMLDetailsElement} */ (this.part(".sees"));
    if (!details.open || !channels) return;
    const action = values[values.length - 6];
    const shown = [...channels.map(([name, unit], k) => entry(name.replaceAll("_", " "), seen[k], unit))];
    shown.push(entry("says: rate of the speed reference, of the largest", action, ""));
    this.part(".seen").replaceChildren(...shown);
  }
}

/**
 * @param {string} name
 * @param {number} value
 * @param {string} unit
 */
function entry(name, value, unit) {
  const place = document.createElement("span");
  const digits = document.createElement("b");
  digits.textContent = Number.isFinite(value) ? value.toFixed(3).replace("-", "−") : "–";
  place.append(`${name} `, digits, unit ? ` ${unit}` : "");
  return place;
}
