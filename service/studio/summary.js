// The summary of a design: peaks, coefficients beside those of the usual law, the cam as a body.

import { byId, element, figure } from "./dom.js";
import { nameAndUnit, words } from "./names.js";
import { tableParts } from "./result.js";

const COEFFICIENTS = ["Cv", "Ca", "Cj", "Cva", "Ea", "Ej"];
const PEAK_NAMES = { convex_radius_mm: "least convex radius", hollow_radius_mm: "least hollow radius" };

/** Fills the tables of the summary; without a cam they are empty. */
export function showSummary({ motion, motion_summary: summary, geometry }) {
  byId("summary").hidden = !summary;
  if (!summary) return;
  const name = ({ segment }) => segmentName(motion[segment]);
  const parts = [["turn", summary], ...summary.moves.map((move) => [name(move), move])];
  const peaks = parts.flatMap(([over, part]) =>
    ["velocity", "acceleration", "jerk"].map((word) => peakRow(`${word}, ${over}`, part[word])));
  byId("peaks").replaceChildren(...tableParts(["", "unit", "largest", "at", "smallest", "at", "rms", "jumps"], peaks));
  const moves = summary.moves.flatMap((move) => [
    row(name(move), COEFFICIENTS.map((key) => value(move.coefficients[key]))),
    ...(move.reference ? [referenceRow(move.reference)] : []),
  ]);
  byId("coefficients").replaceChildren(...tableParts(["", ...COEFFICIENTS], moves));
  byId("body-figures").replaceChildren(...tableParts(["", "value", "at"], bodyRows(geometry)));
}

const value = (number) => (number === null ? "infinite" : figure(number, 5));
const row = (name, cells) => element("tr", {}, element("th", { scope: "row" }, name), ...cells.map((cell) => element("td", {}, cell)));

function segmentName({ kind, start_deg: start, angle_deg: angle }) {
  return `${kind} ${figure(start, 4)}–${figure(start + angle, 4)}°`;
}

function peakRow(name, { unit, largest, smallest, rms, jumps }) {
  const at = ({ angle_deg: angle }) => `${figure(angle, 5)}°`;
  const between = rms === null ? ", between jumps" : ""; // at a jump of the derivative below it is infinite
  return row(name + between, [unit, value(largest.value), at(largest), value(smallest.value), at(smallest), value(rms), jumps || "none"]);
}

function referenceRow({ law, ends, source, coefficients }) {
  const made = row(`reference: ${words(law)}, ${ends}`, COEFFICIENTS.map((key) => value(coefficients[key])));
  made.className = "note";
  made.title = source;
  return made;
}

/** Radii, perimeter, area, speeds of every flank; mass where it is known. */
function bodyRows({ flanks, mass_properties: mass }) {
  const rows = flanks.flatMap(({ flank, hollows, ...figures }) =>
    Object.entries(figures).filter(([, each]) => each !== null).map(([key, each]) => {
      const [text, unit] = nameAndUnit(key);
      const name = [PEAK_NAMES[key] ?? text, flank].filter(Boolean).join(" ");
      if (Array.isArray(each)) return row(`${name}, x and y`, [`${each.map((one) => figure(one, 6)).join(", ")} ${unit}`, ""]);
      if (typeof each === "number") return row(name, [`${figure(each, 6)} ${unit}`, ""]);
      return row(name, [`${figure(each.value, 6)} ${unit}`, `${figure(each.angle_deg, 5)}°`]);
    }));
  if (!mass) return rows;
  const [x, y] = mass.centre_of_gravity_mm;
  return [
    ...rows,
    row("mass", [`${figure(mass.mass_kg, 6)} kg`, ""]),
    row("centre of gravity, x and y", [`${figure(x, 6)}, ${figure(y, 6)} mm`, ""]),
    row("moment of inertia", [`${figure(mass.moment_of_inertia_kg_m2, 6)} kg m²`, ""]),
  ];
}
