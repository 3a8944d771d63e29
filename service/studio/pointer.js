// JSON pointers (RFC 6901) into a spec.

const steps = (pointer) =>
  pointer.split("/").slice(1).map((step) => step.replaceAll("~1", "/").replaceAll("~0", "~"));

/** What stands there, or undefined. */
export function at(value, pointer) {
  return steps(pointer).reduce((inside, step) => inside?.[step], value);
}

/** Puts a value there, in place; undefined takes it away. */
export function put(value, pointer, given) {
  const path = steps(pointer);
  const last = path.pop();
  let inside = value;
  for (const step of path) inside = inside[step] ??= {};
  if (given !== undefined) inside[last] = given;
  else if (Array.isArray(inside)) inside.splice(Number(last), 1);
  else delete inside[last];
}

/** [pointer, number] of every number in a value. */
export function numbers(value, pointer = "") {
  if (typeof value === "number") return [[pointer, value]];
  if (value === null || typeof value !== "object") return [];
  return Object.entries(value).flatMap(([key, inside]) => numbers(inside, `${pointer}/${key}`));
}
