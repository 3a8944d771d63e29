// Swagger UI. What is opened is resolved here: its own way to do so, made for documents that may
// refer to others, goes through the contract many times and takes seconds.

/** The place that a reference leads to. */
function placeOf(contract, reference) {
  const keys = reference.slice(2).split("/");
  return keys.reduce((at, key) => at?.[key.replaceAll("~1", "/").replaceAll("~0", "~")], contract);
}

// Fields of a large object: once in an operation it is written out, then it is only named.
const LARGE = 16;

/**
 * A place with all that it refers to written out. What stands beside a reference comes before what
 * is there; schemas without a title are called as in the contract.
 *
 * written: the references written out so far, with what they became; null while that goes on.
 */
function resolved(contract, place, written = new Map()) {
  if (Array.isArray(place)) return place.map((each) => resolved(contract, each, written));
  if (place === null || typeof place !== "object") return place;
  const { $ref, ...beside } = place;
  if (typeof $ref !== "string" || !$ref.startsWith("#/")) {
    const inner = ([key, value]) => [key, key === "examples" ? value : resolved(contract, value, written)];
    return together(Object.fromEntries(Object.entries(place).map(inner)));
  }
  if (!written.has($ref)) {
    written.set($ref, null);
    const [, title] = $ref.match(/^#\/components\/schemas\/(.+)$/) ?? [];
    written.set($ref, { ...(title && { title }), ...resolved(contract, placeOf(contract, $ref), written) });
  } else if (written.get($ref) === null || Object.keys(written.get($ref).properties ?? {}).length > LARGE) {
    const { type, description } = placeOf(contract, $ref);
    return { title: $ref.split("/").at(-1), type, description, ...beside };
  }
  return { ...written.get($ref), ...beside };
}

/** A schema that has all fields of others, with those among its own. */
function together({ allOf, ...own }) {
  if (!Array.isArray(allOf)) return own;
  const parts = [...allOf.map(({ title, description, ...part }) => part), own];
  const fields = Object.assign({}, ...parts.map((part) => part.properties));
  return Object.assign({}, ...parts, { properties: fields, required: parts.flatMap((part) => part.required ?? []) });
}

/** The same of an operation, its question first: where an answer repeats that, it is only named. */
function operation(contract, place) {
  if (!place?.requestBody) return resolved(contract, place);
  const written = new Map();
  const { requestBody, ...others } = place;
  return { requestBody: resolved(contract, requestBody, written), ...resolved(contract, others, written) };
}

/** What is drawn of an operation that is closed. */
const head = ({ tags, summary, operationId, deprecated }) => ({ tags, summary, operationId, deprecated });

const each = (object, change) =>
  Object.fromEntries(Object.entries(object ?? {}).map(([key, value]) => [key, change(value)]));

/** The same of a schema: without one of these, the page would take it for one without contents. */
const shape = ({ type, description = " " }) => ({ type, description });

/**
 * The contract with that alone of operations and schemas: the page keeps in trees of its own all
 * that it is given, and asks for what is opened.
 */
const headsOf = ({ paths, components, ...others }) => ({
  ...others,
  paths: each(paths, (path) => each(path, head)),
  components: { ...components, schemas: each(components.schemas, shape) },
});

// The tag whose operations are shown from the beginning.
const OPEN = "designs";

/** What of it is drawn first: all else, which nobody sees yet, would make the first operations wait. */
const beginning = ({ tags, paths, components: { schemas, ...others }, ...rest }) => ({
  ...rest,
  tags: tags?.filter(({ name }) => name === OPEN),
  paths: Object.fromEntries(
    Object.entries(paths).filter(([, path]) => Object.values(path).some(({ tags }) => tags?.includes(OPEN))),
  ),
  components: others,
});

// Milliseconds, some frames: the browser puts on the screen what is drawn while nothing else goes on.
const PAUSE = 100;

/** Do something some frames after what a selector names has been drawn. */
const whenShown = (selector, action) =>
  requestAnimationFrame(() =>
    document.querySelector(selector) ? setTimeout(action, PAUSE) : whenShown(selector, action));

// Asked for here, while the library is being read, so that the page is drawn once: by itself it would
// ask after that, and draw itself without the contract meanwhile.
const text = await fetch("/openapi.json").then((answer) => (answer.ok ? answer.text() : ""), () => "");
const library = document.querySelector("script[defer]");
if (!globalThis.SwaggerUIBundle) {
  await new Promise((done) => ["load", "error"].forEach((end) => library.addEventListener(end, done)));
}
let contract;

/** As a plugin. The contract is JSON: to read it as YAML, as it comes by default, takes longer. */
const Resolved = () => ({
  fn: {
    resolveSubtree: async (_, path) => ({
      spec: operation(contract, path.reduce((at, key) => at?.[key], contract)) ?? null,
      errors: [],
    }),
  },
  statePlugins: {
    spec: {
      wrapActions: {
        download: (download, { specActions }) => (url) => {
          if (!text) return download(url); // which says what is wrong
          specActions.updateLoadingStatus("success");
          return specActions.updateSpec(text);
        },
        parseToJson: (_, { specActions }) => (text) => {
          contract = JSON.parse(text);
          const whole = headsOf(contract);
          const first = beginning(whole);
          if (Object.keys(first.paths).length === 0) return specActions.updateJsonSpec(whole);
          whenShown(".opblock", () => specActions.updateJsonSpec(whole));
          return specActions.updateJsonSpec(first);
        },
      },
    },
  },
});

const ui = globalThis.SwaggerUIBundle?.({
  url: "/openapi.json",
  dom_id: "#swagger-ui",
  presets: [SwaggerUIBundle.presets.apis],
  plugins: [Resolved],
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
  docExpansion: "none", // but for the tag OPEN: to draw all operations takes as long as all else
});

// Its action `show` would put the tag into the address.
ui?.getStore().dispatch({ type: "layout_show", payload: { thing: ["operations-tag", OPEN], shown: true } });
