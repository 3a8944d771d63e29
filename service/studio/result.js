// What came out: status, sizes, limits with their margins, or why nothing fits and what would help.

import { byId, element, figure } from "./dom.js";
import { sentences } from "./field_errors.js";
import { nameAndUnit, words } from "./names.js";

const STATUS_TEXT = {
  optimal: "Optimal: every limit is proven at every cam angle, and the gap is within the tolerance.",
  feasible: "Feasible: every limit is proven at every cam angle; how far the best may be is the gap.",
  unsolved: "Unsolved: no cam was found, and that there is none is not proven.",
  infeasible: "Infeasible: proven that nothing fits these limits together.",
};

/** One line about a design or a problem, also read aloud. */
export function showStatus(text, kind = "") {
  const status = byId("status");
  status.textContent = text;
  status.className = kind;
}

export function showDesign(design, apply) {
  const stop = design.severity === "stop";
  const text = [STATUS_TEXT[design.status], proven(design.certificate), ...design.assumptions].join(" ");
  showStatus(stop ? `STOP, this cam cannot work. ${text}` : text, stop ? "stop" : design.status);
  byId("warnings").replaceChildren(...warnings(design.warnings));
  byId("sizes").replaceChildren(...sizes(design));
  byId("margins").replaceChildren(...margins(design));
  byId("conflict").replaceChildren(...(design.conflict ? conflict(design.conflict, apply) : []));
}

export function showProblem(problem, loose) {
  const { title, detail, status } = problem.document;
  showStatus(status ? `${title}: ${detail}` : detail, "problem");
  byId("warnings")?.replaceChildren(); // not on every page
  byId("conflict").replaceChildren(
    ...loose.map(({ pointer, rule, remedy }) => element("p", { class: "error" }, `${pointer ?? ""} ${sentences(rule, remedy)}`)),
  );
}

/** A list of what an engineer would say of the cam, the most severe first. */
export function warnings(found) {
  if (!found.length) return [];
  const lines = found.map(({ code, severity, field, sentence, remedy, source }) => element(
    "li",
    { title: `${code}: ${source}` },
    element("strong", { class: `severity ${severity}` }, severity), ` ${sentence} `,
    element("span", { class: "note" }, `${remedy} (${field})`),
  ));
  return [element("ul", { "aria-label": "Warnings" }, ...lines)];
}

function proven({ gap, bound_valid_for: over, lower_bound: bound, objective, infimum, value }) {
  if (gap === null || bound === null) return "";
  const [name, unit] = nameAndUnit(objective);
  if (infimum) return `No cam has the least ${name}: its infimum lies between ${figure(bound, 3)} and ${figure(value, 3)} ${unit}.`;
  if (gap < 1e-6) return `No smaller ${name} exists, to a millionth, over ${over}.`;
  return `No ${name} is more than ${figure(100 * gap, 2)} % smaller, over ${over}.`;
}

/** Terms and figures of a design's dimensions, and of what else is known of it. */
export function sizes(design) {
  return terms({ ...design.dimensions, ...design.objectives, ...design.free_parameters, ...forces(design.forces) });
}

/** A term and its figure for each {name_unit: value}. */
export function terms(values) {
  return Object.entries(values).flatMap(([name, value]) => {
    const [text, unit] = nameAndUnit(name);
    return [element("dt", {}, text), element("dd", {}, `${figure(value, 6)} ${unit}`.trim())];
  });
}

/** Head and body of a table: its columns' names, and rows of elements. */
export function tableParts(names, rows) {
  const head = names.map((text) => element("th", { scope: "col" }, text));
  return [element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows)];
}

/** The forces in a few numbers; nothing where no load is given. */
function forces(found) {
  if (!found) return {};
  const figures = { camshaft_torque_rms_n_m: found.torque.rms_n_m, camshaft_power_w: found.torque.power_w };
  for (const { flank, largest_n: force, largest_pressure_mpa: pressure } of found.flanks) {
    const name = flank ? `_${flank}` : "";
    if (force) figures[`contact_force${name}_at_most_n`] = force.value;
    if (pressure) figures[`hertz_pressure${name}_at_most_mpa`] = pressure.value;
  }
  if (found.float_onset_rpm !== null) figures.float_onset_rpm = found.float_onset_rpm;
  return figures;
}

/** A row for every limit that has a bound, with how much of it is used. */
function margins(design) {
  const asked = design.extremes.filter((each) => each.bound !== null && each.unit !== "" && !IMPLIED_LIMITS.has(each.limit));
  const rows = asked.map((each) => {
    const used = each.bound ? Math.abs(each.value / each.bound) : null;
    return element(
      "tr",
      { class: each.holds ? "" : "broken", title: each.evidence },
      element("th", { scope: "row" }, words(each.limit)),
      element("td", {}, `${figure(each.value, 5)} ${each.unit}`),
      element("td", {}, `${figure(each.angle_deg, 4)}°`),
      element("td", {}, figure(each.bound, 5)),
      element("td", {}, each.holds ? meter(used) : "broken"),
    );
  });
  return tableParts(["limit", "value", "at", "bound", "used"], rows);
}

// What every cam keeps and nobody asks for.
const IMPLIED_LIMITS = new Set([
  "displacement_join", "velocity_join", "acceleration_join", "self_crossing", "base_radius_positive",
  "prime_circle_angle",
]);

function meter(used) {
  if (used === null || used > 1.0005) return "holds";
  return element("meter", { min: 0, max: 1, value: used, title: `${figure(100 * used, 3)} %` }, `${figure(100 * used, 3)} %`);
}

// How notes begin: of limits that only help together, and of a value that is no number of its field but a deviation from it.
const TOGETHER = "all limits of this name together", DEVIATION = "deviation allowed";

/** What cannot hold together, and what would help; `apply` is given the changes that are taken. */
export function conflict({ limits, relaxations, program_changes: changes = [], evidence }, apply) {
  const known = relaxations.filter(({ needed }) => needed !== null);
  const helps = grouped(known, (each) => (each.note?.startsWith(TOGETHER) ? each.limit : each)).map((group) => {
    const name = nameAndUnit(group[0].limit)[0];
    const text = `${name}: ${group.map(changeOf).join(" and ")} `;
    if (group[0].note?.startsWith(DEVIATION)) return element("li", {}, `${text}(${group[0].note})`);
    const label = `apply ${name} ${group.map((each) => figure(each.needed, 6)).join(" and ")}`;
    const button = element("button", { type: "button", class: "small", "aria-label": label, onclick: () => apply(group) }, "Apply");
    return element("li", {}, text, button);
  });
  const unhelpful = relaxations.filter((each) => each.needed === null)
    .map((each) => `${nameAndUnit(each.limit)[0]}${boundOf(each)}: ${each.note || "alone cannot help"}`);
  const others = [...new Set(unhelpful)].map((text) => element("li", {}, text));
  return [
    element("p", {}, `What cannot hold together: ${limits.map((each) => nameAndUnit(each)[0]).join(", ")}.`),
    ...(helps.length ? [element("p", {}, "Any one of these changes would help:"), element("ul", {}, ...helps)] : []),
    ...(others.length ? [element("p", {}, "No change of these alone is known to help:"), element("ul", {}, ...others)] : []),
    ...(changes.length ? programChanges(changes) : []),
    element("p", { class: "note" }, evidence),
  ];
}

/** Lists of the items that have one key, in the order of their first ones. */
function grouped(items, keyOf) {
  const groups = new Map();
  for (const each of items) groups.set(keyOf(each), [...(groups.get(keyOf(each)) ?? []), each]);
  return [...groups.values()];
}

function changeOf(each) {
  return `${figure(each.requested, 5)} → ${figure(each.needed, 6)} ${each.unit}${boundOf(each)}`;
}

function boundOf({ at_least: bound, unit }) {
  return bound === null || bound === undefined ? "" : `, ${figure(bound, 6)} ${unit} proven impossible`;
}

// Numbers of the program whose change helps with all limits kept; those of one name change together.
function programChanges(changes) {
  const lines = grouped(changes, (each) => each.limit).map((group) => {
    const parts = group.filter((each) => each.needed !== null)
      .map((each) => `${each.field} ${figure(each.requested, 5)} → ${figure(each.needed, 6)} ${each.unit}`);
    return element("li", {}, `${nameAndUnit(group[0].limit)[0]}: ${parts.join(", ")}`);
  });
  return [element("p", {}, "Or one of these changes of the motion, with all limits kept:"), element("ul", {}, ...lines)];
}
