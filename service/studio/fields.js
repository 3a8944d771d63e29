// Inputs for the fields of a spec, by the shape that their schema has.

import { element } from "./dom.js";
import { labelOf, words } from "./names.js";
import { newMember } from "./schema.js";

/**
 * The input of one field, with its label and the place for its error.
 *
 * @param form {store, schemas}
 * @param pointer where the field stands in the spec
 * @param options {label, slider: give numbers a slider, required: it may not be left out}
 */
export function field(form, pointer, schema, options = {}) {
  const found = form.schemas.described(schema);
  if (found.shape === "const") return null;
  const name = pointer.split("/").at(-1);
  const settings = {
    label: options.label ?? labelOf(name),
    title: form.schemas.resolved(schema).description ?? "",
    slider: options.slider ?? false,
    required: options.required ?? false,
  };
  return SHAPES[found.shape](form, pointer, found, settings);
}

/** The inputs of all fields of an object, const ones left out. */
export function fields(form, pointer, schema, options = {}) {
  const names = Object.entries(schema.properties ?? {});
  const wanted = names.filter(([name]) => !options.without?.includes(name));
  return wanted.map(([name, each]) => {
    const required = schema.required?.includes(name) ?? false;
    return field(form, `${pointer}/${name}`, each, { slider: options.slider, required });
  });
}

function labelledInput(pointer, settings, control, more = []) {
  const id = control.id || `field${pointer.replaceAll("/", "-")}`;
  control.id = id;
  control.dataset.pointer = pointer;
  return element(
    "div",
    { class: "field", title: settings.title },
    element("label", { for: id }, settings.label),
    control,
    ...more,
    element("p", { class: "error", "data-error": pointer, id: `${id}-error` }),
  );
}

function number(form, pointer, found, settings) {
  const value = form.store.at(pointer);
  const input = element("input", { type: "number", step: "any", value: value ?? "" });
  const put = (text) => form.store.set(pointer, text === "" ? undefined : Number(text));
  input.addEventListener("input", () => input.validity.badInput || put(input.value));
  const slider = settings.slider && typeof value === "number" ? sliderFor(value, found) : null;
  if (slider === null) return labelledInput(pointer, settings, input);
  slider.setAttribute("aria-label", `${settings.label}, slider`);
  slider.addEventListener("input", () => {
    input.value = slider.toValue();
    put(input.value);
  });
  input.addEventListener("input", () => slider.show(Number(input.value)));
  return labelledInput(pointer, settings, input, [slider]);
}

/** From a fourth to four times the value, evenly in its logarithm; angles evenly in degrees. */
function sliderFor(value, { least, most }) {
  const slider = element("input", { type: "range" });
  if (least === -180 && most === 180) return angleSlider(slider, value, most);
  const angle = most !== undefined && most <= 90;
  if (!angle && value === 0) return null;
  const [low, high] = angle ? [1, most - 1] : [0.25 * value, 4 * value];
  const top = !angle && most !== undefined ? Math.min(high, most) : high;
  const scale = angle ? (x) => x : Math.log;
  const back = angle ? (x) => x : Math.exp;
  const [from, to] = low < top ? [low, top] : [top, low];
  slider.min = 0;
  slider.max = 400;
  slider.show = (shown) => {
    if (shown * Math.sign(from || 1) > 0) {
      const part = (scale(Math.abs(shown)) - scale(Math.abs(low))) / (scale(Math.abs(top)) - scale(Math.abs(low)));
      slider.value = 400 * part;
    }
  };
  slider.toValue = () => {
    const part = slider.value / 400;
    const sized = back(scale(Math.abs(low)) + part * (scale(Math.abs(top)) - scale(Math.abs(low))));
    const shown = Math.sign(value || 1) * Number(sized.toPrecision(3));
    return Math.max(shown, least ?? -Infinity);
  };
  slider.show(value);
  return slider;
}

/** An angle either way, evenly in degrees. */
function angleSlider(slider, value, most) {
  Object.assign(slider, { min: -most, max: most, step: 0.5 });
  slider.show = (shown) => (slider.value = shown);
  slider.toValue = () => Number(slider.value);
  slider.show(value);
  return slider;
}

/** A dimension: left free, fixed, or free between two ends. */
function dimension(form, pointer, found, settings) {
  const value = form.store.at(pointer);
  const state = value === undefined || value === null ? "free" : typeof value === "number" ? "fixed" : "range";
  const select = element(
    "select",
    { onchange: () => form.store.set(pointer, turned(select.value, value), true) },
    ...(settings.required && state !== "free" ? ["fixed", "range"] : ["free", "fixed", "range"]).map((each) => element("option", { value: each }, each)),
  );
  select.value = state;
  const inputs = [];
  if (state === "fixed") {
    const inner = number(form, pointer, found, { ...settings, label: `${settings.label}, value` });
    inner.classList.add("inner");
    inner.querySelector("input").id += "-value";
    inner.querySelector("label").htmlFor = inner.querySelector("input").id;
    inner.querySelector(".error").remove();
    inputs.push(inner);
  }
  if (state === "range") inputs.push(...ends(form, pointer, settings));
  const box = labelledInput(pointer, settings, select, [element("span", { class: "ends" }, ...inputs)]);
  box.classList.add("dimension");
  return box;
}

/** The inputs of a range. */
function ends(form, pointer, settings) {
  return ["min", "max"].map((end) => {
    const input = element("input", {
      type: "number", step: "any", value: form.store.at(`${pointer}/${end}`) ?? "",
      placeholder: end === "min" ? "least" : "largest",
      "aria-label": `${settings.label}, ${end === "min" ? "least" : "largest"}`,
      "data-pointer": `${pointer}/${end}`, id: `field${pointer.replaceAll("/", "-")}-${end}`,
      oninput: () => {
        form.store.set(`${pointer}/${end}`, input.value === "" ? undefined : Number(input.value));
        if (Object.keys(form.store.at(pointer)).length === 0) form.store.set(pointer, undefined);
      },
    });
    return input;
  });
}

/** From where to where something goes. */
function range(form, pointer, found, settings) {
  const [least, largest] = ends(form, pointer, settings);
  const box = labelledInput(pointer, settings, least, [largest]);
  box.classList.add("range");
  least.dataset.pointer = `${pointer}/min`;
  return box;
}

function turned(state, value) {
  if (state === "free") return undefined;
  const known = typeof value === "number" ? value : (value?.max ?? value?.min ?? 40);
  if (state === "fixed") return known;
  return known > 0 ? { min: known / 2, max: 2 * known } : { min: known - 20, max: known + 20 };
}

function choice(form, pointer, found, settings) {
  const value = form.store.at(pointer);
  const select = element(
    "select",
    { onchange: () => form.store.set(pointer, found.values.find((each) => String(each) === select.value)) },
    element("option", { value: "" }, "default"),
    ...found.values.map((each) => element("option", { value: String(each) }, words(String(each)))),
  );
  select.value = value === undefined || value === null ? "" : String(value);
  return labelledInput(pointer, settings, select);
}

function text(form, pointer, found, settings) {
  const input = element("input", { type: "text", value: form.store.at(pointer) ?? "" });
  input.addEventListener("input", () => form.store.set(pointer, input.value || undefined));
  return labelledInput(pointer, settings, input);
}

function flag(form, pointer, found, settings) {
  const input = element("input", { type: "checkbox", checked: form.store.at(pointer) === true });
  input.addEventListener("change", () => form.store.set(pointer, input.checked));
  return labelledInput(pointer, settings, input);
}

/** One of several kinds, with the fields of the one that is chosen. */
function union(form, pointer, found, settings) {
  const value = form.store.at(pointer);
  const titles = form.titles ?? {};
  const select = element(
    "select",
    {
      onchange: () => {
        const kind = found.kinds.find(([each]) => each === select.value);
        form.store.set(pointer, kind ? newMember(form.schemas, ...kind) : undefined, true);
      },
    },
    settings.required ? null : element("option", { value: "" }, "default"),
    ...found.kinds.map(([kind]) => element("option", { value: kind }, titles[kind] ?? words(kind))),
  );
  select.value = value?.kind ?? "";
  const chosen = found.kinds.find(([kind]) => kind === value?.kind);
  const inside = chosen ? fields(form, pointer, chosen[1], { slider: settings.slider }) : [];
  const box = labelledInput(pointer, settings, select, [element("div", { class: "inside" }, ...inside)]);
  box.classList.add("union");
  return box;
}

function group(form, pointer, found, settings) {
  const present = form.store.at(pointer) !== undefined && form.store.at(pointer) !== null;
  const box = element(
    "fieldset",
    { class: "group" },
    element("legend", {}, settings.label),
    ...(present ? fields(form, pointer, found.schema) : []),
  );
  const button = element(
    "button",
    { type: "button", class: "small", onclick: () => form.store.set(pointer, present ? undefined : {}, true) },
    present ? `Remove ${settings.label}` : `Add ${settings.label}`,
  );
  box.append(button, element("p", { class: "error", "data-error": pointer }));
  return box;
}

/** Whatever has no input of its own: as JSON. */
function raw(form, pointer, found, settings) {
  const value = form.store.at(pointer);
  const area = element("textarea", { rows: 2, spellcheck: "false", placeholder: "JSON" });
  area.value = value === undefined || value === null ? "" : JSON.stringify(value);
  area.addEventListener("change", () => {
    try {
      form.store.set(pointer, area.value.trim() === "" ? undefined : JSON.parse(area.value));
      area.setCustomValidity("");
    } catch {
      area.setCustomValidity("This is not JSON.");
      area.reportValidity();
    }
  });
  return labelledInput(pointer, settings, area);
}

const SHAPES = { number, dimension, range, choice, text, flag, union, group, raw };
