// Colours as the style sheet has them, for what is drawn on canvases; light, dark, or light for print.

const KEY = "drillrig-theme";
const wishes = matchMedia("(prefers-color-scheme: dark)");
/** @type {string | null} */
let chosen = null;
try {
  chosen = localStorage.getItem(KEY);
} catch {
  chosen = null; // storage may be forbidden
}
let printing = false;

/** Whether the page is dark now. */
export function isDark() {
  return !printing && (chosen ? chosen === "dark" : wishes.matches);
}

/** What has been read of the style sheet: asking a browser for it takes longer than drawing with it. */
const read = new Map();

/** Read everything anew: colours or sizes may have changed. */
export function forgetStyle() {
  read.clear();
}

/**
 * @template T
 * @param {string} key
 * @param {() => T} find
 * @returns {T}
 */
function once(key, find) {
  if (!read.has(key)) read.set(key, find());
  return read.get(key);
}

/** Show the page in the colours that are wished for. */
function apply() {
  document.documentElement.dataset.theme = isDark() ? "dark" : "light";
  forgetStyle();
}

/** Change between light and dark, and remember it. */
export function toggleTheme() {
  chosen = isDark() ? "light" : "dark";
  try {
    localStorage.setItem(KEY, chosen);
  } catch {
    // then it is forgotten with the page
  }
  apply();
}

/** @param {boolean} on whether the page is about to be printed, and so on white */
export function setPrinting(on) {
  printing = on;
  apply();
}

/**
 * A colour of the style sheet by name, without its dashes.
 * @param {string} name
 */
export function colour(name) {
  return once(name, () => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
}

/**
 * The type that plots are labelled in, at a size relative to the page's.
 * @param {number} size
 */
export function font(size) {
  return once(`font ${size}`, () => {
    const style = getComputedStyle(document.body);
    return `${(Number.parseFloat(style.fontSize) * size).toFixed(1)}px ${style.fontFamily}`;
  });
}

/** The size of type of the page, px. */
export function typeSize() {
  return once("size", () => Number.parseFloat(getComputedStyle(document.body).fontSize));
}

/** @param {() => void} listener called when the system's wish changes */
export function onWish(listener) {
  wishes.addEventListener("change", () => {
    apply();
    listener();
  });
}

apply();
