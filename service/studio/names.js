// Names of fields for people: the unit stands at the end of a field's name.

const UNITS = {
  n_m_s_per_rad: "N m s/rad", n_m_per_rad: "N m/rad", n_s_per_m: "N s/m", n_per_mm: "N/mm",
  n_m: "N m", n: "N", mpa: "MPa", kg_m2: "kg m²", kg: "kg", w: "W",
  rad_per_s2: "rad/s²", mm_per_s3: "mm/s³", mm_per_s2: "mm/s²", mm_per_s: "mm/s",
  deg_per_s3: "deg/s³", deg_per_s2: "deg/s²", deg_per_s: "deg/s",
  per_mm: "1/mm", mm2: "mm²", mm4: "mm⁴", mm: "mm", deg: "°", rpm: "rpm", s: "s",
};

/** ["rise", "°"] of rise_deg. */
export function nameAndUnit(name) {
  for (const [suffix, unit] of Object.entries(UNITS)) {
    if (name.endsWith(`_${suffix}`)) return [words(name.slice(0, -suffix.length - 1)), unit];
  }
  return [words(name), ""];
}

/** "rise [°]" */
export function labelOf(name) {
  const [text, unit] = nameAndUnit(name);
  return unit ? `${text} [${unit}]` : text;
}

/** "profile radius" of profile_radius. */
export const words = (name) => name.replaceAll("_", " ");
