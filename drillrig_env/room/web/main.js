// The page: a connection, two panels, the controls, and the loop that draws them.

import { Clock } from "./clock.js";
import { Connection } from "./connection.js";
import { byId, Controls, say } from "./controls.js";
import { GIVEN_AT, readFrame } from "./frames.js";
import { linkOf, picture, replay, save, settingOf } from "./keep.js";
import { listen } from "./keys.js";
import { Looks, toggleFullScreen } from "./looks.js";
import { Panel } from "./panel.js";
import { Tale } from "./stories.js";

/** @typedef {import("./types.js").Welcome} Welcome */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").LaneChart} LaneChart */
/** @typedef {import("./types.js").Setting} Setting */

const VERSION = 1;
const FRAME_TIME = 1000 / 30; // ms
const EARLY = 8; // ms, by which a frame may come before it is due: half of a screen's own
const SETTING_UP = "The rigs are being set up …; the first time on a machine this takes half a minute.";
const TOLD = 10_000; // ms for which it is said that a run began anew

/** @type {State | null} */
let state = null;
let told = 0; // the timer that takes away what is said of the connection
let begins = true; // whether the server is at setting a run up, of which nothing was heard yet
/** @type {Setting} */
let wanted = {}; // what was asked for and not answered yet: a server that comes back is asked again
/** @type {Controls | null} */
let controls = null;
/** @type {Tale | null} */
let tale = null;
/** @type {Panel[]} */
let panels = [];
let due = 0; // when the next frame is to be drawn, ms
let toDraw = true;
const clock = new Clock();

const connection = new Connection(onText, onFrame, (sentence) => {
  clearTimeout(told);
  say("connection", sentence);
});

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
  say("connection", SETTING_UP);
  if (!controls) {
    controls = new Controls(welcome, send);
    tale = new Tale(welcome.stories, send);
    panels = ["A", "B"].map((name) => new Panel(name, welcome.policies, send));
    byId("lanes").replaceChildren(...panels.map((panel) => panel.element));
    if (welcome.begin.full_screen) looks.lecture(true);
  }
  const held = state ? { ...state.setting, ...wanted } : settingOf(location.hash);
  connection.send({ do: "begin", version: VERSION, setting: held });
  if (state?.story) connection.send({ do: "story", name: state.story.name, part: 0 });
  begins = true;
}

/** @param {State} now */
function show(now) {
  if (begins) say("connection", state ? anew(state) : "");
  if (begins || !state || now.run !== state.run || now.step < state.step) {
    for (const panel of panels) panel.clear();
    clock.reset();
  }
  begins = false;
  state = now;
  for (const [name, value] of Object.entries(wanted)) if (now.setting[name] === value) delete wanted[name];
  controls?.show(now);
  tale?.show(now);
  looks.showSpans(now.time_scale);
  panels.forEach((panel, place) => {
    panel.show(now, place);
  });
  toDraw = true;
}

/**
 * What to say when the connection is there again: the server has forgotten the run.
 * @param {State} was
 */
function anew(was) {
  const what = was.story ? "the story" : "a run with the same setting";
  clearTimeout(told);
  told = setTimeout(() => say("connection", ""), TOLD);
  return `The server is there again, and ${what} begins anew; what was before is lost.`;
}

/** @param {ArrayBuffer} buffer */
function onFrame(buffer) {
  const frame = readFrame(buffer);
  if (!frame || !state || begins || frame.run !== state.run) return;
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
  const span = looks.span(state.time_scale);
  for (const panel of panels) panel.draw(clock.shown, span, state);
  byId("time").textContent = `${clock.shown.toFixed(1)} s`;
  document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1);
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

const looks = new Looks(drawAll, () => {
  toDraw = true;
});
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
  l: () => looks.lecture(),
  f: toggleFullScreen,
  "?": () => /** @type {HTMLDialogElement} */ (byId("keys")).showModal(),
});
connection.open();
requestAnimationFrame(draw);
