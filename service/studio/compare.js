// Two designs side by side: A is kept, B is the present one.

import { byId, element, figure } from "./dom.js";
import { nameAndUnit, words } from "./names.js";

/** The table of differences; empty without a design to compare with. */
export function showDifferences(kept, present) {
  const box = byId("differences");
  if (!kept || !present) {
    box.replaceChildren(element("p", { class: "note" }, "Keep a design as A, then change something: both are drawn, and their differences are listed here."));
    return;
  }
  const all = [...values(kept.design, present.design)];
  const differ = all.filter(([, , a, b]) => !(Math.abs(b - a) <= 1e-9 * Math.abs(a)));
  const rows = differ.map(([name, unit, a, b]) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, unit ? `${name} [${unit}]` : name),
      ...[a, b, a !== null && b !== null ? b - a : null].map((value) => element("td", {}, figure(value, 6))),
      element("td", {}, a && b !== null ? `${figure((100 * (b - a)) / Math.abs(a), 3)} %` : "–"),
    ),
  );
  const head = ["", "A (kept)", "B (now)", "B − A", ""].map((text) => element("th", { scope: "col" }, text));
  const same = element("p", { class: "note" }, `${all.length - differ.length} of ${all.length} values are the same in both.`);
  box.replaceChildren(
    element("div", { class: "scroll" },
      element("table", {}, element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows))),
    same,
  );
}

function* values(a, b) {
  const flat = (design) => ({
    ...Object.fromEntries(Object.entries({ ...design.dimensions, ...design.objectives }).map(([name, value]) => [name, [...nameAndUnit(name), value]])),
    ...Object.fromEntries(design.extremes.filter((each) => each.unit && Math.abs(each.value) > 1e-9 && each.limit !== "displacement_join")
      .map((each) => [`extreme ${each.limit}`, [`extreme of ${words(each.limit)}`, each.unit, each.value]])),
  });
  const [left, right] = [flat(a), flat(b)];
  for (const name of new Set([...Object.keys(left), ...Object.keys(right)])) {
    const [text, unit] = left[name] ?? right[name];
    yield [text, unit, left[name]?.[2] ?? null, right[name]?.[2] ?? null];
  }
}
