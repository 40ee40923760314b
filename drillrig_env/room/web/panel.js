// A lane's panel: who controls it, the hand on it, its verdict, and everything that is drawn of it.

import { drawDiscs } from "./discs.js";
import { History } from "./history.js";
import { kinds, Lines } from "./lines.js";
import { RigMap } from "./map.js";
import { Plane } from "./plane.js";
import { colour } from "./theme.js";
import { number } from "./fields.js";
import { Words } from "./words.js";

/** @typedef {import("./frames.js").Frame} Frame */
/** @typedef {import("./frames.js").LaneFrame} LaneFrame */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").LaneChart} LaneChart */
/** @typedef {(message: Record<string, unknown>) => void} Send */

const STUCK = 0.01;

/** The panel of lane A or B. */
export class Panel {
  /**
   * @param {string} name
   * @param {string[]} policies
   * @param {Send} send
   */
  constructor(name, policies, send) {
    this.name = name;
    this.send = send;
    this.history = new History();
    /** @type {LaneFrame | null} */
    this.newest = null;
    const template = /** @type {HTMLTemplateElement} */ (document.getElementById("lane"));
    this.element = /** @type {HTMLElement} */ (
      /** @type {DocumentFragment} */ (template.content.cloneNode(true)).firstElementChild
    );
    this.element.dataset.lane = name;
    this.element.setAttribute("aria-label", `Lane ${name}`);
    this.part(".badge").textContent = name;
    const lane = `lane ${name}`;
    this.plane = new Plane(this.canvas(".plane canvas", `${lane}: twist and bit speed, with the stable cycle`), name);
    this.map = new RigMap(this.canvas(".map canvas", `${lane}: operating point on the map of this rig`), name);
    this.discs = this.canvas(".discs canvas", `${lane}: the rig as it turns`);
    const own = kinds(name.toLowerCase());
    const titles = { speeds: "speeds, rad/s", torques: "torque and current", rewards: "reward a control step" };
    this.lines = /** @type {("speeds" | "torques" | "rewards")[]} */ (["speeds", "torques", "rewards"]).map((kind) => {
      const place = this.part(`.${kind} .plot`);
      place.setAttribute("aria-label", `${lane}: ${titles[kind]} over time`);
      return new Lines(place, own[kind], this.part(`.${kind} figcaption`), titles[kind]);
    });
    this.policy = /** @type {HTMLSelectElement} */ (this.part(".policy"));
    this.policy.setAttribute("aria-label", `Controller of lane ${name}`);
    for (const policy of policies) this.policy.add(new Option(policy, policy));
    this.policy.addEventListener("change", () => {
      send({ do: "set", setting: { [name.toLowerCase()]: this.policy.value } });
    });
    this.part(".hand").setAttribute("aria-label", `Hand on lane ${name}`);
    this.take = /** @type {HTMLButtonElement} */ (this.part(".take"));
    this.take.setAttribute("aria-label", `Take over lane ${name}`);
    this.take.setAttribute("aria-keyshortcuts", name.toLowerCase());
    this.take.addEventListener("click", () => this.toggleHand());
    this.slider = /** @type {HTMLInputElement} */ (this.part(".reference-slider"));
    this.number = /** @type {HTMLInputElement} */ (this.part(".reference-number"));
    this.slider.setAttribute("aria-label", `Speed reference of lane ${name}, slider`);
    this.number.setAttribute("aria-label", `Speed reference of lane ${name}, rad/s`);
    this.slider.addEventListener("input", () => this.#ask(Number(this.slider.value)));
    this.number.addEventListener("input", () => {
      this.typing = true;
    });
    this.number.addEventListener("change", () => {
      this.typing = false;
      this.asked = this.number.value;
      this.#ask(number(this.number.value));
    });
    this.typing = false;
    this.asked = "";
    this.byHand = false;
    this.words = new Words((selector) => this.part(selector));
  }

  /** @param {string} selector */
  part(selector) {
    return /** @type {HTMLElement} */ (this.element.querySelector(selector));
  }

  /**
   * @param {string} selector
   * @param {string} label
   */
  canvas(selector, label) {
    const found = /** @type {HTMLCanvasElement} */ (this.part(selector));
    found.setAttribute("aria-label", label);
    return found;
  }

  toggleHand() {
    this.send(this.byHand ? { do: "give_back", lane: this.name } : { do: "take", lane: this.name, reference: null });
  }

  /** @param {number | string} reference */
  #ask(reference) {
    this.send({ do: "take", lane: this.name, reference });
  }

  /**
   * Show a sentence of the server beside the hand or the controller; an empty one takes it away.
   * @param {"hand" | "policy"} where
   * @param {string} sentence
   */
  refuse(where, sentence) {
    const place = this.part(`.refusal-${where}`);
    place.textContent = sentence;
    place.hidden = !sentence;
    if (where !== "hand") return;
    this.number.setAttribute("aria-invalid", String(Boolean(sentence)));
    if (sentence) this.number.value = this.asked;
  }

  /** Forget the run that was. */
  clear() {
    this.history.clear();
    this.newest = null;
    for (const lines of this.lines) lines.reset();
    this.words.clear();
  }

  /**
   * @param {Frame} frame
   * @param {number} place
   */
  add(frame, place) {
    this.newest = frame.lanes[place];
    this.history.add(frame, place);
  }

  /**
   * Set all controls to how they are.
   * @param {State} state
   * @param {number} place
   */
  show(state, place) {
    const lane = state.lanes[place];
    this.element.hidden = !lane;
    if (!lane) return;
    this.channels = lane.channels;
    if (![...this.policy.options].some((option) => option.value === lane.policy)) {
      this.policy.add(new Option(lane.policy, lane.policy));
    }
    this.policy.value = lane.policy;
    this.policy.disabled = state.replay;
    this.take.disabled = state.replay;
    this.byHand = lane.hand !== null;
    this.part(".hand").classList.toggle("taken", this.byHand);
    this.take.setAttribute("aria-pressed", String(this.byHand));
    this.take.textContent = this.byHand ? "Give back" : "Take over";
    this.slider.min = "0";
    this.slider.max = String(Number((1.2 * state.sliders.speed_target[1]).toPrecision(3)));
    this.slider.step = "any";
    if (lane.hand !== null) {
      if (document.activeElement !== this.slider) this.slider.value = String(lane.hand);
      const settled = !this.typing && this.part(".refusal-hand").hidden;
      if (settled) this.number.value = String(Number(lane.hand.toPrecision(4)));
    }
  }

  /** @param {LaneChart} chart */
  chart(chart) {
    this.map.chart = chart.map;
    this.map.forget();
    if (chart.orbit) this.plane.show(chart.orbit);
    /** @param {number | null} value */
    const speed = (value) => (value === null ? "none" : value.toFixed(2));
    const { note, critical_now: critical, end_now: end } = chart.map;
    this.part(".borders").textContent =
      note || `— critical ${speed(critical)} ╌ ${chart.map.followed ? "end" : "fold"} ${speed(end)}${end === null ? "" : " rad/s"}`;
  }

  /**
   * Draw everything at a time of the run.
   * @param {number} time
   * @param {number} span
   * @param {State} state
   */
  draw(time, span, state) {
    if (this.element.offsetParent === null) return;
    const { history } = this;
    const visible = this.lines.filter((lines) => lines.place.offsetParent !== null);
    for (const lines of visible) {
      lines.last = lines === visible[visible.length - 1];
      lines.draw(history, time, span);
    }
    this.plane.draw(history, time, state.time_scale);
    const at = history.before(time);
    const c = history.columns;
    const own = colour(this.name.toLowerCase());
    const pose =
      at < 0
        ? { bit: 0, angle: 0, twist12: 0, twist23: 0, force: Number(state.setting.normal_force) }
        : { bit: c.bit[at], angle: c.angle[at], twist12: c.twist12[at], twist23: c.twist23[at], force: c.force[at] };
    if (!Number.isNaN(pose.bit)) {
      drawDiscs(this.discs, pose, own, STUCK / state.time_scale, state.largest_force);
    }
    const target = at < 0 ? Number(state.setting.speed_target) : c.target[at];
    const reference = at < 0 ? (state.lanes.find((lane) => lane.name === this.name)?.reference ?? 0) : c.reference[at];
    if (!Number.isNaN(target)) {
      this.map.draw(target, pose.force, reference, state.sliders.speed_target[1], state.largest_force);
    }
    if (this.newest) this.words.say(this.newest, this.channels);
  }
}
