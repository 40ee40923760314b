// The story that is told: its text, and the way back and on.

import { byId } from "./controls.js";

/** @typedef {import("./types.js").Story} Story */
/** @typedef {import("./types.js").State} State */

/** The panel of a story. */
export class Tale {
  /**
   * @param {Story[]} stories
   * @param {(message: Record<string, unknown>) => void} send
   */
  constructor(stories, send) {
    this.stories = stories;
    this.send = send;
    this.name = "";
    this.part = 0;
    this.choice = /** @type {HTMLSelectElement} */ (byId("story"));
    this.choice.add(new Option("none", ""));
    for (const story of stories) this.choice.add(new Option(story.title, story.name));
    this.choice.addEventListener("change", () => this.#go(this.choice.value, 0));
    byId("tale-back").addEventListener("click", () => this.move(-1));
    byId("tale-next").addEventListener("click", () => this.move(1));
    byId("tale-end").addEventListener("click", () => this.#go("", 0));
  }

  /** @param {1 | -1} way */
  move(way) {
    const story = this.stories.find((one) => one.name === this.name);
    const part = this.part + way;
    if (story && part >= 0 && part < story.parts.length) this.#go(this.name, part);
  }

  /**
   * @param {string} name
   * @param {number} part
   */
  #go(name, part) {
    this.send({ do: "story", name, part });
  }

  /** @param {State} state */
  show(state) {
    const told = state.story;
    const story = this.stories.find((one) => one.name === told?.name);
    byId("tale").hidden = !story;
    document.body.classList.toggle("telling", Boolean(story));
    this.choice.value = story?.name ?? "";
    this.name = story?.name ?? "";
    this.part = told?.part ?? 0;
    if (!story) return;
    const part = story.parts[this.part];
    byId("tale-title").textContent = story.title;
    byId("tale-part").textContent = `· ${this.part + 1} of ${story.parts.length}`;
    byId("tale-heading").textContent = part.heading;
    if (byId("tale-text").textContent !== part.text) byId("tale-text").textContent = part.text;
    /** @type {HTMLButtonElement} */ (byId("tale-back")).disabled = this.part === 0;
    /** @type {HTMLButtonElement} */ (byId("tale-next")).disabled = this.part === story.parts.length - 1;
  }
}
