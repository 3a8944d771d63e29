// Swagger UI. Whatever is opened is resolved by itself, and not the whole contract with it.

/** What a place of the contract refers to, as paths into the contract. */
function* references(place) {
  if (place === null || typeof place !== "object") return;
  const named = [place.$ref, ...Object.values(place.discriminator?.mapping ?? {})];
  for (const name of named.filter((each) => typeof each === "string" && each.startsWith("#/"))) {
    yield name.slice(2).split("/").map((key) => key.replaceAll("~1", "/").replaceAll("~0", "~"));
  }
  for (const inner of Object.values(place)) yield* references(inner);
}

/** The contract with no more in it than stands at a path and what that refers to. */
function reached(contract, path) {
  const part = { openapi: contract.openapi, info: contract.info, paths: {} };
  const found = new Set();
  const open = [path];
  while (open.length > 0) {
    const keys = open.pop();
    if (found.has(keys.join(" "))) continue;
    found.add(keys.join(" "));
    const place = keys.reduce((at, key) => at?.[key], contract);
    if (place === undefined) continue; // there are no security schemes
    const holder = keys.slice(0, -1).reduce((at, key) => (at[key] ??= {}), part);
    holder[keys.at(-1)] = place;
    open.push(...references(place));
  }
  return part;
}

/** As a plugin: for every operation that is opened, Swagger UI goes through all it is given. */
function Reached({ fn: { resolveSubtree } }) {
  return {
    fn: {
      resolveSubtree: (contract, path, options) =>
        resolveSubtree(reached(contract, path), path, options),
    },
  };
}

globalThis.SwaggerUIBundle?.({
  url: "/openapi.json",
  dom_id: "#swagger-ui",
  presets: [SwaggerUIBundle.presets.apis],
  plugins: [Reached],
  layout: "BaseLayout",
  deepLinking: true,
  showExtensions: true,
  showCommonExtensions: true,
  syntaxHighlight: false, // hangs near 1 MB of JSON
  tryItOutEnabled: true,
  displayRequestDuration: true,
  filter: true,
  defaultModelsExpandDepth: 0,
  defaultModelExpandDepth: 4,
  docExpansion: "list",
});
