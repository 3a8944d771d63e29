// The spec as a form: program, follower, sizes, limits, objective.

import { byId, element, figure } from "./dom.js";
import { showFieldErrors } from "./field_errors.js";
import { field, fields } from "./fields.js";
import { words } from "./names.js";
import { newMember } from "./schema.js";

const LIFTS = ["lift_mm", "lift_deg"];
const IN_ROW = ["kind", "angle_deg", ...LIFTS, "law"];

export class Form {
  /** `sized`: the fields of the follower, or machine, and its sizes. */
  constructor(store, schemas, titles, sized) {
    Object.assign(this, { store, schemas, titles, sized });
    this.open = new Set();
    store.addEventListener("change", (event) => {
      if (event.detail.structural) this.show();
      else this.#sums();
    });
  }

  /** Makes the form anew from the spec, the focus kept where it was. */
  show() {
    const focus = document.activeElement?.id;
    const { properties } = this.schemas.spec;
    byId("form-program").replaceChildren(...this.#program());
    byId("form-follower").replaceChildren(...this.#some(this.sized));
    byId("form-limits").replaceChildren(...this.#limits());
    byId("form-objective").replaceChildren(...this.#objectives(properties));
    byId("form-machine").replaceChildren(...this.#some(["name", "speed_rpm", "rotation", "load", "body"]));
    if (focus) byId(focus)?.focus();
    this.#sums();
  }

  /** The fields of these that the spec has. */
  #some(names) {
    const { properties } = this.schemas.spec;
    return names.filter((name) => name in properties).map((name) => field(this, `/${name}`, properties[name]));
  }

  // -- the program --------------------------------------------------------------------------

  #program() {
    const kinds = this.#kindsOf("program");
    const rows = (this.store.spec.program ?? []).map((segment, i) => this.#row(kinds, segment, i));
    const head = ["", "", "angle [°]", "lift", "law", ""].map((text) => element("th", { scope: "col" }, text));
    const table = element(
      "table",
      { class: "program" },
      element("thead", {}, element("tr", {}, ...head)),
      element("tbody", {}, ...rows.flat()),
      element("tfoot", {}, element("tr", {}, element("td", { colspan: 6, id: "program-sum", "aria-live": "polite" }))),
    );
    const add = (kind) =>
      element("button", { type: "button", class: "small", onclick: () => this.#add(kinds, kind) }, `+ ${words(kind)}`);
    return [
      element("div", { class: "scroll" }, table),
      element("p", { class: "buttons" }, ...kinds.map(([kind]) => add(kind))),
      element("p", { class: "error", "data-error": "/program" }),
    ];
  }

  #kindsOf(name) {
    const { items } = this.schemas.spec.properties[name];
    return this.schemas.described(items).kinds;
  }

  #row(kinds, segment, i) {
    const at = `/program/${i}`;
    const schema = kinds.find(([kind]) => kind === segment.kind)?.[1] ?? { properties: {} };
    const select = element(
      "select",
      { "aria-label": `segment ${i + 1}, kind`, "data-pointer": `${at}/kind`,
        onchange: () => this.#changeKind(kinds, i, select.value) },
      ...kinds.map(([kind]) => element("option", { value: kind }, words(kind))),
    );
    select.value = segment.kind;
    const more = Object.keys(schema.properties).some((name) => !IN_ROW.includes(name)) || segment.law;
    const cells = [
      element("td", {}, `${i + 1}`),
      element("td", {}, select),
      element("td", {}, this.#number(`${at}/angle_deg`, segment.angle_deg, `segment ${i + 1}, angle [°]`)),
      element("td", {}, ...this.#lift(at, segment, schema, i)),
      element("td", {}, this.#law(at, segment, schema, i)),
      element("td", { class: "row-buttons" }, ...this.#rowButtons(i, more)),
    ];
    const places = ["", "/angle_deg", "/lift_mm", "/lift_deg", "/law", "/kind"];
    const note = element(
      "tr",
      { class: "row-errors" },
      element("td", { colspan: 6 }, ...places.map((name) => element("p", { class: "error", "data-error": at + name }))),
    );
    const inside = this.open.has(i) ? [this.#details(at, segment, schema)] : [];
    return [element("tr", {}, ...cells), note, ...inside];
  }

  #number(pointer, value, label) {
    const free = value !== null && typeof value === "object";
    const input = element("input", {
      type: "number", step: "any", value: free ? "" : (value ?? ""), "aria-label": label,
      id: `field${pointer.replaceAll("/", "-")}`, "data-pointer": pointer,
      placeholder: free ? "range" : "", disabled: free,
      title: free ? "Left free in a range: see JSON." : "",
      oninput: () => this.store.set(pointer, input.value === "" ? undefined : Number(input.value)),
    });
    return input;
  }

  #lift(at, segment, schema, i) {
    if (!LIFTS.some((name) => name in schema.properties)) return [];
    const name = "lift_deg" in segment ? "lift_deg" : "lift_mm";
    const unit = element(
      "select",
      { "aria-label": `segment ${i + 1}, unit of lift`, class: "unit",
        onchange: () => {
          const value = segment[name];
          this.store.set(`${at}/${name}`, undefined);
          this.store.set(`${at}/${unit.value}`, value, true);
        } },
      element("option", { value: "lift_mm" }, "mm"),
      element("option", { value: "lift_deg" }, "°"),
    );
    unit.value = name;
    return [this.#number(`${at}/${name}`, segment[name], `segment ${i + 1}, lift`), unit];
  }

  #law(at, segment, schema, i) {
    if (!schema.properties.law) return null;
    const { kinds } = this.schemas.described(schema.properties.law);
    const select = element(
      "select",
      { "aria-label": `segment ${i + 1}, law`, "data-pointer": `${at}/law`,
        onchange: () => {
          const kind = kinds.find(([each]) => each === select.value);
          this.store.set(`${at}/law`, kind ? newMember(this.schemas, ...kind) : undefined, true);
        } },
      ...kinds.map(([kind]) => element("option", { value: kind }, this.titles[kind] ?? words(kind))),
    );
    select.value = segment.law?.kind ?? "spline";
    return select;
  }

  #rowButtons(i, more) {
    const count = this.store.spec.program.length;
    const button = (text, label, onclick, disabled = false) =>
      element("button", { type: "button", class: "icon", "aria-label": `segment ${i + 1}: ${label}`, title: label, disabled, onclick }, text);
    const toggle = () => {
      if (!this.open.delete(i)) this.open.add(i);
      this.show();
    };
    return [
      more ? button("…", this.open.has(i) ? "less" : "more: ends, windows, points", toggle) : null,
      button("⇥", "take what is left of 360°", () => this.#fill(i)),
      button("↑", "up", () => this.#exchange(i, i - 1), i === 0),
      button("✕", "remove", () => this.store.set(`/program/${i}`, undefined, true), count === 1),
    ];
  }

  #details(at, segment, schema) {
    const rest = fields(this, at, schema, { without: IN_ROW });
    const law = schema.properties.law && segment.law;
    const kind = law && this.schemas.described(schema.properties.law).kinds.find(([each]) => each === law.kind);
    const ofLaw = kind ? fields(this, `${at}/law`, kind[1]) : [];
    return element("tr", {}, element("td", { colspan: 6, class: "inside" }, ...ofLaw, ...rest));
  }

  #add(kinds, kind) {
    const { program = [] } = this.store.spec;
    const made = newMember(this.schemas, ...kinds.find(([each]) => each === kind));
    const like = program.find((each) => LIFTS.some((name) => name in each)) ?? { lift_mm: 20 };
    const schema = kinds.find(([each]) => each === kind)[1];
    const lift = LIFTS.find((name) => name in like && name in schema.properties);
    if (lift) made[lift] = like[lift];
    this.store.set(`/program/${program.length}`, made, true);
  }

  /** Another kind of segment, with all that both have. */
  #changeKind(kinds, i, kind) {
    const schema = kinds.find(([each]) => each === kind)[1];
    const before = this.store.spec.program[i];
    const kept = Object.entries(before).filter(([name]) => name in schema.properties);
    const like = this.store.spec.program.find((each) => LIFTS.some((name) => name in each)) ?? {};
    const lift = LIFTS.find((name) => name in like && name in schema.properties);
    const made = { ...newMember(this.schemas, kind, schema), ...(lift ? { [lift]: like[lift] } : {}) };
    this.store.set(`/program/${i}`, { ...made, ...Object.fromEntries(kept), kind }, true);
  }

  #exchange(i, k) {
    const { program } = this.store.spec;
    [program[i], program[k]] = [program[k], program[i]];
    this.store.set("/program", program, true);
  }

  /** The angle that the others leave. */
  #fill(i) {
    const { program } = this.store.spec;
    const others = program.reduce((sum, each, k) => sum + (k === i ? 0 : Number(each.angle_deg) || 0), 0);
    this.store.set(`/program/${i}/angle_deg`, Number((360 - others).toFixed(9)), true);
  }

  #sums() {
    const { program = [] } = this.store.spec;
    const free = program.some((each) => typeof each.angle_deg === "object");
    const sum = program.reduce((total, each) => total + (Number(each.angle_deg) || 0), 0);
    const text = free ? "Some angles are left free." : `Angles sum to ${figure(sum, 9)}° of 360°.`;
    const note = byId("program-sum");
    note.textContent = text;
    note.classList.toggle("wrong", !free && Math.abs(sum - 360) > 1e-6);
  }

  // -- limits and aim -----------------------------------------------------------------------

  #limits() {
    if (!this.schemas.spec.properties.limits) return [];
    const kinds = this.#kindsOf("limits");
    const shown = (this.store.spec.limits ?? []).map((limit, i) => {
      const schema = kinds.find(([kind]) => kind === limit.kind)?.[1] ?? {};
      return element(
        "fieldset",
        { class: "group" },
        element("legend", {}, this.titles[limit.kind] ?? words(limit.kind ?? "")),
        ...fields(this, `/limits/${i}`, schema, { slider: true }),
        element("p", { class: "error", "data-error": `/limits/${i}` }),
        element("button", { type: "button", class: "small", onclick: () => this.store.set(`/limits/${i}`, undefined, true) },
          `Remove ${words(limit.kind ?? "limit")}`),
      );
    });
    const add = element(
      "select",
      { id: "add-limit", "aria-label": "add a limit",
        onchange: () => {
          const made = newMember(this.schemas, ...kinds.find(([kind]) => kind === add.value));
          const limits = this.store.spec.limits ?? [];
          this.store.set("/limits", [...limits, made], true);
        } },
      element("option", { value: "" }, "Add a limit …"),
      ...kinds.map(([kind, schema]) =>
        element("option", { value: kind, title: schema.description }, this.titles[kind] ?? words(kind))),
    );
    return [...shown, add];
  }

  #objectives(properties) {
    const objective = Array.isArray(this.store.spec.objective)
      ? field(this, "/objective", {}, { label: "objectives, in order" })
      : properties.objective && field(this, "/objective", properties.objective);
    const rest = this.#some(["tolerance", "proof", "continuity", "report_smoothness_cost", "time_budget_s"]);
    return [objective, ...rest].filter(Boolean);
  }

  /** Puts the errors of a problem document at their fields; returns those that have no place. */
  showErrors(errors) {
    return showFieldErrors(errors);
  }
}
