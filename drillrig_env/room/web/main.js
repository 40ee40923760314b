// The page: a connection, two panels, the controls, and the loop that draws them.

import { Clock } from "./clock.js";
import { Connection } from "./connection.js";
import { byId, Controls, say } from "./controls.js";
import { GIVEN_AT, readFrame } from "./frames.js";
import { linkOf, picture, replay, save, settingOf } from "./keep.js";
import { listen } from "./keys.js";
import { Panel } from "./panel.js";
import { Tale } from "./stories.js";
import { forgetStyle, isDark, onWish, setPrinting, toggleTheme } from "./theme.js";

/** @typedef {import("./types.js").Welcome} Welcome */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").LaneChart} LaneChart */
/** @typedef {import("./types.js").Setting} Setting */

const VERSION = 1;
const FRAME_TIME = 1000 / 30; // ms
const EARLY = 8; // ms, by which a frame may come before it is due: half of a screen's own
const SPANS = [10, 30, 60, 120];

/** @type {State | null} */
let state = null;
/** @type {Setting} */
let wanted = {}; // what was asked for and not answered yet: a server that comes back is asked again
/** @type {Controls | null} */
let controls = null;
/** @type {Tale | null} */
let tale = null;
/** @type {Panel[]} */
let panels = [];
let lecturing = false;
let due = 0; // when the next frame is to be drawn, ms
let toDraw = true;
const clock = new Clock();
const params = new URLSearchParams(location.search);

const connection = new Connection(onText, onFrame, (sentence) => say("connection", sentence));

/** @param {Record<string, unknown>} message */
function send(message) {
  controls?.clearRefusals();
  for (const panel of panels) {
    panel.refuse("hand", "");
    panel.refuse("policy", "");
  }
  if (message.do === "set") Object.assign(wanted, message.setting);
  else if (message.do === "give") Object.assign(wanted, message.values);
  else if (message.do === "story" || message.do === "replay") wanted = {};
  connection.send(message);
}

/** @param {{is: string} & Record<string, unknown>} message */
function onText(message) {
  if (message.is === "welcome") greet(/** @type {Welcome} */ (/** @type {unknown} */ (message)));
  else if (message.is === "state") show(/** @type {State} */ (/** @type {unknown} */ (message)));
  else if (message.is === "charts") {
    for (const chart of /** @type {LaneChart[]} */ (message.lanes)) {
      panels.find((panel) => panel.name === chart.name)?.chart(chart);
    }
    toDraw = true;
  } else if (message.is === "refused") refuse(String(message.field), String(message.sentence));
  else if (message.is === "file") {
    const name = String(message.name);
    save(name, new Blob([String(message.text)], { type: name.endsWith(".csv") ? "text/csv" : "application/json" }));
  }
}

/** @param {Welcome} welcome */
function greet(welcome) {
  if (!controls) {
    controls = new Controls(welcome, send);
    tale = new Tale(welcome.stories, send);
    panels = ["A", "B"].map((name) => new Panel(name, welcome.policies, send));
    byId("lanes").replaceChildren(...panels.map((panel) => panel.element));
    if (welcome.begin.full_screen || params.has("lecture")) setLecture(true);
  }
  const held = state ? { ...state.setting, ...wanted } : settingOf(location.hash);
  connection.send({ do: "begin", version: VERSION, setting: held });
}

/** @param {State} now */
function show(now) {
  if (!state || now.run !== state.run || now.step < state.step) {
    for (const panel of panels) panel.clear();
    clock.reset();
  }
  state = now;
  for (const [name, value] of Object.entries(wanted)) if (now.setting[name] === value) delete wanted[name];
  controls?.show(now);
  tale?.show(now);
  panels.forEach((panel, place) => {
    panel.show(now, place);
  });
  toDraw = true;
}

/** @param {ArrayBuffer} buffer */
function onFrame(buffer) {
  const frame = readFrame(buffer);
  if (!frame || !state || frame.run !== state.run) return;
  frame.lanes.forEach((_, lane) => {
    panels[lane]?.add(frame, lane);
  });
  const last = 5 * (frame.steps - 1);
  if (Object.keys(state.ramps).length || state.replay) {
    controls?.follow({
      normal_force: frame.given[last + GIVEN_AT.normalForce],
      mu_s: frame.given[last + GIVEN_AT.muS],
      mu_k: frame.given[last + GIVEN_AT.muK],
      v_b: frame.given[last + GIVEN_AT.vB],
      speed_target: frame.given[last + GIVEN_AT.target],
    });
  }
  toDraw = true;
}

/**
 * @param {string} field
 * @param {string} sentence
 */
function refuse(field, sentence) {
  wanted = {};
  const [first, lane] = field.split(" ");
  const panel = panels.find((one) => one.name === (lane ?? field.toUpperCase()));
  if (first === "hand" && panel) panel.refuse("hand", sentence);
  else if ((field === "a" || field === "b") && panel) panel.refuse("policy", sentence);
  else if (!controls?.refuse(field, sentence)) say("refusal-other", sentence);
}

/** @param {boolean} on */
function setLecture(on) {
  lecturing = on;
  document.body.classList.toggle("lecture", on);
  byId("lecture").setAttribute("aria-pressed", String(on));
  forgetStyle();
  toDraw = true;
}

function toggleFullScreen() {
  if (document.fullscreenElement) document.exitFullscreen();
  else document.documentElement.requestFullscreen().catch(() => {});
}

/** @param {number} now */
function draw(now) {
  requestAnimationFrame(draw);
  if (now < due - EARLY) return;
  if (!state) return;
  const newest = panels[0]?.history.end ?? 0;
  const before = clock.shown;
  clock.tick(now, newest, state.paused || state.at_end, state.times, state.period);
  if (clock.shown === before && !toDraw) return;
  due = Math.max(due + FRAME_TIME, now); // one that came late does not make the next one late
  toDraw = false;
  drawAll();
}

function drawAll() {
  if (!state) return;
  const chosen = Number(/** @type {HTMLSelectElement} */ (byId("span")).value);
  for (const panel of panels) panel.draw(clock.shown, chosen * state.time_scale, state);
  byId("time").textContent = `${clock.shown.toFixed(1)} s`;
  document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1);
}

function looks() {
  const span = /** @type {HTMLSelectElement} */ (byId("span"));
  for (const seconds of SPANS) span.add(new Option(`${seconds} s`, String(seconds), seconds === 30, seconds === 30));
  const view = /** @type {HTMLSelectElement} */ (byId("view"));
  const again = () => {
    forgetStyle();
    toDraw = true;
  };
  span.addEventListener("change", again);
  view.addEventListener("change", () => {
    document.body.dataset.view = view.value;
    again();
  });
  const theme = byId("theme");
  const named = () => {
    theme.textContent = isDark() ? "Light" : "Dark";
    again();
  };
  theme.addEventListener("click", () => {
    toggleTheme();
    named();
  });
  onWish(named);
  named();
  byId("lecture").addEventListener("click", () => setLecture(!lecturing));
  byId("help").addEventListener("click", () => /** @type {HTMLDialogElement} */ (byId("keys")).showModal());
  addEventListener("resize", again);
  addEventListener("beforeprint", () => {
    setPrinting(true);
    forgetStyle();
    drawAll();
  });
  addEventListener("afterprint", () => {
    setPrinting(false);
    again();
  });
  document.addEventListener("click", () => {
    if (lecturing && !document.fullscreenElement && !params.has("lecture")) wantFullScreen();
  });
}

let asked = false;

/** A browser lets a page fill the screen only when somebody has pressed something: once is enough. */
function wantFullScreen() {
  if (asked) return;
  asked = true;
  toggleFullScreen();
}

function keeping() {
  byId("keep-csv").addEventListener("click", () => send({ do: "keep", what: "csv" }));
  byId("keep-run").addEventListener("click", () => send({ do: "keep", what: "run" }));
  byId("keep-png").addEventListener("click", () => {
    picture(panels).toBlob((blob) => {
      if (blob) save("drillrig_room.png", blob);
    });
  });
  byId("keep-link").addEventListener("click", () => {
    if (!state) return;
    const link = linkOf(state);
    history.replaceState(null, "", link);
    const told = byId("kept");
    const done = () => {
      told.textContent = "the link is copied, and is the page's address now";
    };
    const shown = () => {
      told.textContent = link;
    };
    if (navigator.clipboard) navigator.clipboard.writeText(link).then(done, shown);
    else shown();
  });
  const file = /** @type {HTMLInputElement} */ (byId("replay"));
  file.addEventListener("change", () => {
    const chosen = file.files?.[0];
    if (chosen) replay(chosen, send);
    file.value = "";
  });
}

looks();
keeping();
listen({
  " ": () => controls?.togglePause(),
  ".": () => send({ do: "step" }),
  "+": () => controls?.faster(1),
  "-": () => controls?.faster(-1),
  r: () => send({ do: "restart", new_seed: false }),
  n: () => send({ do: "restart", new_seed: true }),
  a: () => panels[0]?.toggleHand(),
  b: () => panels[1]?.toggleHand(),
  "[": () => tale?.move(-1),
  "]": () => tale?.move(1),
  l: () => setLecture(!lecturing),
  f: toggleFullScreen,
  "?": () => /** @type {HTMLDialogElement} */ (byId("keys")).showModal(),
});
connection.open();
requestAnimationFrame(draw);
