// What stands over something else, or is cut off, on the page: a list of sentences, empty where all is well.
() => {
  const found = [];
  const texts = "button, label, legend, h1, h2, p, figcaption, summary, .key, .verdict span, .verdict strong";
  const groups = [".transport > *", ".looks > *", ".lane-head > *", ".lane-body > *", ".lines > figure", ".row > *",
    ".verdict > *", "figcaption > *", ".field > *", ".top > *", ".room > *"];
  const seen = (e) => e.offsetParent !== null && !e.closest(".visually-hidden, .skip");
  const named = (e) => e.outerHTML.slice(0, 80);
  for (const e of [...document.querySelectorAll(texts)].filter(seen)) {
    const box = e.getBoundingClientRect();
    if (e.scrollWidth > e.clientWidth + 2 && e.clientWidth > 0) found.push(`cut off: ${named(e)}`);
    if (box.left < -1 || box.right > innerWidth + 1) found.push(`outside: ${named(e)}`);
  }
  for (const group of groups) {
    const all = [...document.querySelectorAll(group)].filter(seen);
    all.forEach((one, k) => {
      for (const other of all.slice(k + 1)) {
        if (one.parentElement !== other.parentElement) continue;
        const [a, b] = [one.getBoundingClientRect(), other.getBoundingClientRect()];
        const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
        const tall = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        if (wide > 1.5 && tall > 1.5) found.push(`over each other: ${named(one)} and ${named(other)}`);
      }
    });
  }
  for (const inner of [...document.querySelectorAll("fieldset *, .lane *, .tale *")].filter(seen)) {
    const [a, b] = [inner.getBoundingClientRect(), inner.closest("fieldset, .lane, .tale").getBoundingClientRect()];
    if (a.width > 0 && (a.left < b.left - 1 || a.right > b.right + 1)) found.push(`out of its frame: ${named(inner)}`);
  }
  if (document.documentElement.scrollWidth > innerWidth) found.push("the page is wider than its window");
  return found;
}
