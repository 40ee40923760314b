// Single keys, where nobody is typing; they can be switched off.

import { byId } from "./controls.js";

/**
 * @param {Record<string, () => void>} actions by key
 */
export function listen(actions) {
  const on = /** @type {HTMLInputElement} */ (byId("keys-on"));
  const dialog = /** @type {HTMLDialogElement} */ (byId("keys"));
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || dialog.open) return;
    const target = /** @type {HTMLElement} */ (event.target);
    if (target.closest("input:not([type='checkbox']), select, textarea, [contenteditable]")) return;
    if (event.key === " " && target.closest("button, summary, a, label")) return; // which it presses
    const action = actions[event.key];
    if (!action || !(on.checked || event.key === "?")) return;
    event.preventDefault();
    action();
  });
}
