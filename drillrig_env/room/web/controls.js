// The controls at the left, and the clock: what they ask of the server, and how they show what it says.

import { ChoiceField, NumberField, number } from "./fields.js";

/** @typedef {import("./types.js").Welcome} Welcome */
/** @typedef {import("./types.js").State} State */
/** @typedef {(message: Record<string, unknown>) => void} Send */

const TIMES = [0.1, 0.2, 0.5, 1, 2, 5, 10];

/** @type {[string, string, string][]} */
const GIVEN = [
  ["speed_target", "Target speed", "rad/s"],
  ["normal_force", "Normal force N₁", "N"],
  ["mu_s", "Static friction μₛ", ""],
  ["mu_k", "Kinetic friction μₖ", ""],
  ["v_b", "Friction decay v_b", "s/rad"],
];

/** @param {string} id */
export function byId(id) {
  return /** @type {HTMLElement} */ (document.getElementById(id));
}

/** All controls that are not a lane's own. */
export class Controls {
  /**
   * @param {Welcome} welcome
   * @param {Send} send
   */
  constructor(welcome, send) {
    this.send = send;
    this.paused = false;
    this.atEnd = false;
    this.times = 1;
    /** @type {string | number | null} */
    this.rig = null; // that the step and the ramp are offered for
    /** @param {string} name @param {number | string | null} value */
    const give = (name, value) => send({ do: "give", values: { [name]: value } });
    /** @param {string} name @param {number | string | null} value */
    const choose = (name, value) => send({ do: "set", setting: { [name]: value === "" ? null : value } });
    const operate = byId("operate");
    const into = byId("choose");
    /** @type {(NumberField | ChoiceField)[]} */
    this.fields = GIVEN.map(([name, label, unit]) => new NumberField(operate, name, label, unit, give, true));
    /** @type {Record<string, string>} */
    const called = { field_2500m: "field, 2.5 km", own: "your own" };
    /** @param {string[]} names @returns {[string, string][]} */
    const named = (names) => names.map((name) => [name, called[name] ?? name]);
    this.fields.push(
      new ChoiceField(into, "rig", "Rig", named(welcome.rigs), choose),
      new ChoiceField(into, "sensors", "Sensors", named(welcome.sensors), choose),
      new ChoiceField(into, "start", "Starts in", [
        ["stick_slip", "stick-slip"], ["steady", "steady rotation"], ["rest", "rest"],
      ], choose),
      new NumberField(into, "noise", "Noise, of the standard", "", choose, false),
      new NumberField(into, "delay", "Delay", "control steps", choose, false),
      new NumberField(into, "k_p", "Drive k_p", "V s/rad", choose, false),
      new NumberField(into, "k_i", "Drive k_i", "V/rad", choose, false),
      new NumberField(into, "seed", "Seed", "", choose, false),
    );
    byId("controls").addEventListener("submit", (event) => event.preventDefault());
    this.#clock();
    this.#load();
  }

  #clock() {
    const times = /** @type {HTMLSelectElement} */ (byId("times"));
    for (const value of TIMES) times.add(new Option(`${value} ×`, String(value)));
    times.addEventListener("change", () => this.send({ do: "speed", times: Number(times.value) }));
    byId("pause").addEventListener("click", () => this.togglePause());
    byId("step").addEventListener("click", () => this.send({ do: "step" }));
    byId("restart").addEventListener("click", () => this.send({ do: "restart", new_seed: false }));
    byId("new-seed").addEventListener("click", () => this.send({ do: "restart", new_seed: true }));
  }

  #load() {
    const to = /** @type {HTMLInputElement} */ (byId("load-to"));
    const seconds = /** @type {HTMLInputElement} */ (byId("load-time"));
    byId("load-step").addEventListener("click", () => {
      this.send({ do: "give", values: { normal_force: number(to.value) } });
    });
    byId("load-ramp").addEventListener("click", () => {
      this.send({ do: "ramp", name: "normal_force", to: number(to.value), seconds: number(seconds.value) });
    });
  }

  /**
   * Offer a step and a ramp that are something on this rig.
   * @param {State} state
   */
  #offer(state) {
    const [to, within] = [0.625 * state.sliders.normal_force[1], 10 * state.time_scale];
    /** @type {HTMLInputElement} */ (byId("load-to")).value = String(Number(to.toPrecision(2)));
    /** @type {HTMLInputElement} */ (byId("load-time")).value = String(Number(within.toPrecision(2)));
  }

  togglePause() {
    if (this.atEnd) return; // and the sentence that says why stays
    this.send({ do: "pause", paused: !this.paused });
  }

  /** @param {1 | -1} way */
  faster(way) {
    const at = TIMES.findIndex((value) => value >= this.times - 1e-9) + way;
    if (at < 0 || at >= TIMES.length) return;
    this.times = TIMES[at]; // the next key may come before the server's answer
    this.send({ do: "speed", times: this.times });
  }

  /** @param {State} state */
  show(state) {
    if (state.setting.rig !== this.rig) {
      this.rig = state.setting.rig;
      this.#offer(state);
    }
    this.paused = state.paused;
    this.atEnd = state.at_end;
    this.times = state.times;
    byId("pause").textContent = state.at_end ? "At the end" : state.paused ? "Go on" : "Pause";
    byId("pause").setAttribute("aria-pressed", String(state.paused));
    /** @type {HTMLSelectElement} */ (byId("times")).value = String(state.times);
    for (const field of this.fields) {
      const ends = state.sliders[field.name];
      if (ends && field instanceof NumberField) field.reach(ends);
      field.show(state.setting[field.name]);
      if (field.input) field.input.disabled = state.replay;
    }
    const ramps = Object.entries(state.ramps).map(([name, to]) => `${name.replaceAll("_", " ")} on its way to ${to}`);
    byId("ramps").textContent = ramps.join("; ");
  }

  /**
   * Show values that change by themselves, by a ramp.
   * @param {Record<string, number>} values
   */
  follow(values) {
    for (const field of this.fields) {
      if (field.name in values && field instanceof NumberField) field.show(values[field.name]);
    }
  }

  /** Take all sentences away. */
  clearRefusals() {
    for (const field of this.fields) field.refuse("");
    for (const id of ["refusal-ramp", "refusal-speed", "refusal-keep", "refusal-other"]) say(id, "");
  }

  /**
   * Put a sentence beside the field that it is about; false where there is no such field.
   * @param {string} name
   * @param {string} sentence
   */
  refuse(name, sentence) {
    const [first, second] = name.split(" ");
    const field = this.fields.find((one) => one.name === name);
    if (field) field.refuse(sentence);
    else if (first === "ramp" && second) say("refusal-ramp", sentence);
    else if (name === "speed") say("refusal-speed", sentence);
    else if (name === "keep" || name === "replay") say("refusal-keep", sentence);
    else return false;
    return true;
  }
}

/**
 * @param {string} id
 * @param {string} sentence
 */
export function say(id, sentence) {
  const place = byId(id);
  place.textContent = sentence;
  place.hidden = !sentence;
}
