// A six-bar shaper: its form, the machine turning, its ram's motion, and that motion for a cam.

import { toAddress } from "./address.js";
import { Cam } from "./cam.js";
import { Charts } from "./charts.js";
import { byId, element, figure } from "./dom.js";
import { nameAndUnit, words } from "./names.js";
import { showStatus, tableParts, terms } from "./result.js";

const LENGTHS = ["crank_mm", "guide_mm", "coupler_mm", "pivot_distance_mm", "ram_line_mm"];
const REQUIREMENTS = ["stroke_mm", "quick_return_ratio", "least_transmission_angle_deg"];
const ROOM = 1.5; // how many times longer or shorter a length that is left free may become
const CURVES = [
  { stem: "ram_mm", name: "ram", from: "motion" },
  { stem: "ram_mm_per_s", name: "its velocity", from: "motion" },
  { stem: "ram_mm_per_s2", name: "its acceleration", from: "motion" },
  { stem: "guide_deg", name: "guide’s angle", from: "motion" },
];

export class Shaper {
  constructor(api, store, ask) {
    Object.assign(this, { api, store, ask, box: byId("shaper") });
    this.charts = new Charts((angle) => this.cam.turnTo(angle), CURVES, "crank_travel_");
    this.cam = new Cam((angle) => this.charts.point(angle));
    byId("to-cam").addEventListener("click", () => this.#toCam());
  }

  sections(form) {
    const button = (text, onclick) => element("button", { type: "button", class: "small", onclick }, text);
    const free = button("Leave every length free", () => this.#free());
    const take = button("Take the lengths that came out", () => this.#fix());
    return [
      ["Lengths", [element("p", { class: "buttons" }, free, take), ...form.some(LENGTHS, { slider: true })]],
      ["What is wanted", form.some(REQUIREMENTS, { slider: true })],
      ["Aim, where lengths are free", form.some(["objective", "tolerance"])],
      ["Branch and drive", form.some(["ram_side", "rotation", "speed_rpm", "acceleration_rad_per_s2", "start_deg", "name"])],
    ];
  }

  /** Ranges about the lengths of now, and the stroke and ratio that they have as requirements. */
  #free() {
    const known = (name) => this.found?.dimensions[name] ?? this.store.at(`/${name}`);
    const ranges = LENGTHS.map((name) => [name, known(name)]).filter(([, value]) => typeof value === "number");
    this.store.assign({
      ...Object.fromEntries(ranges.map(([name, value]) => [`/${name}`, about(value)])),
      "/stroke_mm": this.store.at("/stroke_mm") ?? rounded(this.found?.stroke_mm ?? 500),
      "/quick_return_ratio": this.store.at("/quick_return_ratio") ?? rounded(this.found?.quick_return?.ratio ?? 1.8),
      "/least_transmission_angle_deg": this.store.at("/least_transmission_angle_deg") ?? 60,
      "/acceleration_rad_per_s2": undefined,
    });
  }

  #fix() {
    const { dimensions = {} } = this.found ?? {};
    this.store.assign(Object.fromEntries(Object.entries(dimensions).map(([name, value]) => [`/${name}`, value])));
  }

  async show(found, signal) {
    this.found = found;
    showStatus(describe(found), found.status);
    const made = found.stroke_mm !== null;
    this.box.hidden = !made;
    if (!made) return;
    const fetched = (name) => this.api.get(`${found.links.self}/${name}`, { signal });
    const [motion, scene] = await Promise.all([fetched("motion.json?points_per_degree=2"), fetched("animation.json")]);
    byId("sizes").replaceChildren(...terms(sizesOf(found)));
    const design = { extremes: [] }; // no bounds to draw
    this.charts.show({ motion, design, marks: found.dead_centres.map((each) => each.crank_travel_deg) }, null);
    this.cam.show({ scene }, null);
    byId("requirements-part").hidden = found.limits.length === 0;
    byId("requirements").replaceChildren(...tableParts(["", "came out", "at least", "at most", ""], found.limits.map(requirement)));
    byId("margins").replaceChildren(...tableParts(["quantity", "largest", "at", "smallest", "at"], found.extremes.map(extreme)));
    byId("centres").replaceChildren(...tableParts(["crank turned", "crank angle", "ram", "why"], found.dead_centres.map(centre)));
    const can = "cam.json" in found.links;
    byId("to-cam").disabled = !can;
    byId("to-cam-message").textContent = can ? "opens it on the page of planar cams" : "a cam turns at constant speed; this crank changes its speed";
  }

  async #toCam() {
    const body = await this.api.get(`${this.found.links.self}/cam.json`);
    location.assign(`/#${toAddress(body)}`);
  }
}

const rounded = (value) => Number(value.toPrecision(6));

function about(value) {
  if (value <= 0) return { min: rounded(value - 100), max: rounded(value + 100) };
  return { min: rounded(value / ROOM), max: rounded(value * ROOM) };
}

function describe(found) {
  if (found.status === "unsolved") return "Unsolved: no lengths were found, and that there are none is not proven.";
  if (found.stroke_mm === null) return "Infeasible: no lengths keep these requirements together.";
  const broken = found.limits.filter((each) => !each.holds).map((each) => nameAndUnit(each.limit)[0]);
  if (broken.length > 0) return `Infeasible: these lengths do not keep ${broken.join(", ")}.`;
  const made = `Stroke ${figure(found.stroke_mm, 6)} mm, quick return ${figure(found.quick_return.ratio, 5)}.`;
  if (!found.certificate) return made;
  const { objective, value, gap, bound_valid_for: over } = found.certificate;
  const [name, unit] = nameAndUnit(objective);
  const near = gap < 1e-6 ? "the best there is" : `within ${figure(100 * gap, 2)} % of the best`;
  const best = `${name} ${figure(value, 6)} ${unit}, ${near} over ${over}.`;
  return `${found.status === "optimal" ? "Optimal" : "Feasible"}: ${best} ${made}`;
}

function sizesOf(found) {
  const { guide_angle: guide, quick_return: quick } = found;
  return {
    stroke_mm: found.stroke_mm,
    quick_return_ratio: quick.ratio,
    slow_stroke_deg: quick.slow_deg,
    quick_stroke_deg: quick.quick_deg,
    least_transmission_angle_deg: found.least_transmission_angle_deg,
    ...(guide ? { guide_from_deg: guide.min_deg, guide_to_deg: guide.max_deg } : {}),
    ...found.dimensions,
  };
}

const cell = (...content) => element("td", {}, ...content);
const bound = (value) => (value === null ? "" : figure(value, 6));

function requirement(each) {
  const [name] = nameAndUnit(each.limit);
  return element(
    "tr",
    { class: each.holds ? "" : "broken" },
    element("th", { scope: "row" }, name),
    cell(`${figure(each.value, 6)} ${each.unit}`.trim()),
    cell(bound(each.lower)),
    cell(bound(each.upper)),
    cell(each.holds ? "kept" : "not kept"),
  );
}

function extreme({ quantity, unit, largest, smallest }) {
  const ends = [largest, smallest].flatMap((peak) => [
    element("td", { title: peak.width === null ? "not proven" : `proven to ${figure(peak.width, 2)}` }, `${figure(peak.value, 6)} ${unit}`),
    cell(`${figure(peak.crank_travel_deg, 5)}°`),
  ]);
  return element("tr", {}, element("th", { scope: "row" }, words(quantity)), ...ends);
}

function centre({ crank_travel_deg: turned, crank_deg: crank, ram_mm: ram, cause }) {
  return element("tr", {}, element("th", { scope: "row" }, `${figure(turned, 6)}°`), cell(`${figure(crank, 6)}°`), cell(`${figure(ram, 6)} mm`), cell(words(cause)));
}
