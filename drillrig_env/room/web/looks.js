// How the page is looked at: which lanes, over what time, light or dark, as a lecture, on paper.

import { byId } from "./controls.js";
import { forgetStyle, isDark, onWish, setPrinting, toggleTheme } from "./theme.js";

const SPANS = [10, 30, 60, 120]; // s on the chapter's rig

export function toggleFullScreen() {
  if (document.fullscreenElement) document.exitFullscreen();
  else document.documentElement.requestFullscreen().catch(() => {});
}

/** The controls of the view. */
export class Looks {
  #lecturing = false;
  #asked = false;
  #again;

  /**
   * @param {() => void} drawNow
   * @param {() => void} drawAgain called where something looks another way from now on
   */
  constructor(drawNow, drawAgain) {
    this.#again = () => {
      forgetStyle();
      drawAgain();
    };
    const span = this.spans;
    for (const seconds of SPANS) span.add(new Option("", String(seconds), seconds === 30, seconds === 30));
    this.showSpans(1);
    const view = /** @type {HTMLSelectElement} */ (byId("view"));
    span.addEventListener("change", this.#again);
    view.addEventListener("change", () => {
      document.body.dataset.view = view.value;
      this.#again();
    });
    this.#theme();
    byId("lecture").addEventListener("click", () => this.lecture());
    byId("help").addEventListener("click", () => /** @type {HTMLDialogElement} */ (byId("keys")).showModal());
    addEventListener("resize", this.#again);
    addEventListener("beforeprint", () => {
      setPrinting(true);
      forgetStyle();
      drawNow();
    });
    addEventListener("afterprint", () => {
      setPrinting(false);
      this.#again();
    });
    document.addEventListener("click", () => {
      if (this.#lecturing && !document.fullscreenElement) this.#wantFullScreen();
    });
  }

  get spans() {
    return /** @type {HTMLSelectElement} */ (byId("span"));
  }

  /**
   * Over how much time lines are drawn (s), on a rig that is slower than the chapter's by a factor.
   * @param {number} slower
   */
  span(slower) {
    return Number(this.spans.value) * slower;
  }

  /**
   * Say the times that there are to choose from, in seconds of the rig.
   * @param {number} slower
   */
  showSpans(slower) {
    for (const choice of this.spans.options) {
      choice.text = `${Number((Number(choice.value) * slower).toPrecision(3))} s`;
    }
  }

  /** @param {boolean} on */
  lecture(on = !this.#lecturing) {
    this.#lecturing = on;
    document.body.classList.toggle("lecture", on);
    byId("lecture").setAttribute("aria-pressed", String(on));
    this.#again();
  }

  #theme() {
    const theme = byId("theme");
    const named = () => {
      theme.textContent = isDark() ? "Light" : "Dark";
      this.#again();
    };
    theme.addEventListener("click", () => {
      toggleTheme();
      named();
    });
    onWish(named);
    named();
  }

  /** A browser lets a page fill the screen only when somebody has pressed something: once is enough. */
  #wantFullScreen() {
    if (this.#asked) return;
    this.#asked = true;
    toggleFullScreen();
  }
}
