// Fields of the controls: a slider with a number, a number alone, a choice; each with a place for the rig's sentence.

/** @typedef {(name: string, value: number | string | null) => void} OnChange */

const PAUSE = 40;
const DECIMAL = /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i;

/**
 * A number as a person writes it, with a point or a comma, in wide digits too; what is none stays text, and the rig says
 * what is wrong.
 * @param {string} text
 * @returns {number | string}
 */
export function number(text) {
  const plain = text.normalize("NFKC").trim().replace("−", "-").replace(/^([-+]?\d*),(\d+)$/, "$1.$2");
  const value = DECIMAL.test(plain) ? Number(plain) : Number.NaN;
  return Number.isFinite(value) ? value : text.trim();
}

/** One field. */
export class Field {
  /**
   * @param {HTMLElement} into
   * @param {string} name
   * @param {string} label
   * @param {string} unit
   */
  constructor(into, name, label, unit) {
    this.name = name;
    this.place = document.createElement("div");
    this.place.className = "field";
    this.label = document.createElement("label");
    this.label.htmlFor = `field-${name}`;
    this.label.append(label);
    if (unit) {
      const shown = document.createElement("span");
      shown.className = "unit";
      shown.textContent = ` ${unit}`;
      this.label.append(shown);
    }
    this.refusal = document.createElement("p");
    this.refusal.className = "refusal";
    this.refusal.id = `refusal-${name}`;
    this.refusal.setAttribute("role", "alert");
    this.refusal.hidden = true;
    this.place.append(this.label);
    into.append(this.place);
    /** @type {HTMLInputElement | HTMLSelectElement | null} */
    this.input = null;
  }

  /** @param {string} sentence beside the field; an empty one takes it away */
  refuse(sentence) {
    this.refusal.textContent = sentence;
    this.refusal.hidden = !sentence;
    this.input?.setAttribute("aria-invalid", String(Boolean(sentence)));
  }

  /** @param {string | number | null} _value */
  show(_value) {}
}

/** A number that is typed, with a slider where it has one. */
export class NumberField extends Field {
  /**
   * @param {HTMLElement} into
   * @param {string} name
   * @param {string} label
   * @param {string} unit
   * @param {OnChange} onChange
   * @param {boolean} sliding
   */
  constructor(into, name, label, unit, onChange, sliding) {
    super(into, name, label, unit);
    const input = document.createElement("input");
    input.id = `field-${name}`;
    input.inputMode = "decimal";
    input.setAttribute("aria-describedby", `refusal-${name}`);
    this.input = input;
    this.typed = input;
    this.place.append(input);
    /** @type {HTMLInputElement | null} */
    this.slider = null;
    this.typing = false;
    this.asked = "";
    input.addEventListener("input", () => {
      this.typing = true;
    });
    input.addEventListener("change", () => {
      this.typing = false;
      this.asked = input.value;
      onChange(name, number(input.value));
    });
    if (sliding) {
      const slider = document.createElement("input");
      slider.type = "range";
      slider.setAttribute("aria-label", `${label}, slider`);
      this.slider = slider;
      let timer = 0;
      slider.addEventListener("input", () => {
        input.value = String(Number(slider.value));
        clearTimeout(timer);
        timer = setTimeout(() => onChange(name, Number(slider.value)), PAUSE);
      });
      this.place.append(slider);
    }
    this.place.append(this.refusal);
  }

  /** @param {string} sentence beside what was asked for, which stays to be mended */
  refuse(sentence) {
    super.refuse(sentence);
    if (sentence) this.typed.value = this.asked;
  }

  /** @param {[number, number, number]} ends */
  reach([low, high, step]) {
    if (!this.slider) return;
    this.slider.min = String(low);
    this.slider.max = String(high);
    this.slider.step = String(step);
  }

  /**
   * Show a value, but not over what is being typed or was refused.
   * @param {string | number | null} value
   */
  show(value) {
    if (!this.refusal.hidden || this.typing) return;
    const text = typeof value === "number" ? String(Number(value.toPrecision(6))) : "";
    this.typed.value = text;
    if (this.slider && document.activeElement !== this.slider) this.slider.value = text;
  }
}

/** A choice among names. */
export class ChoiceField extends Field {
  /**
   * @param {HTMLElement} into
   * @param {string} name
   * @param {string} label
   * @param {[string, string][]} choices values and what they are called
   * @param {OnChange} onChange
   */
  constructor(into, name, label, choices, onChange) {
    super(into, name, label, "");
    this.place.classList.add("wide");
    const select = document.createElement("select");
    select.id = `field-${name}`;
    for (const [value, called] of choices) select.add(new Option(called, value));
    select.addEventListener("change", () => onChange(name, select.value));
    this.select = select;
    this.input = select;
    this.place.append(select, this.refusal);
  }

  /** @param {string | number | null} value */
  show(value) {
    this.select.value = String(value);
  }
}
