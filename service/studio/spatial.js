// The studio's page of spatial cams: a spec as a form, the cam turning in space, and its files.

import { Api, Problem } from "./api.js";
import { listCalls } from "./calls.js";
import { byId, element, figure, debounced } from "./dom.js";
import { Files } from "./files.js";
import { Form } from "./form.js";
import { words } from "./names.js";
import { showStatus, showProblem, sizes, tableParts, warnings } from "./result.js";
import { Scene } from "./scene.js";
import { Schemas } from "./schema.js";
import { SpecStore } from "./spec_store.js";
import { Playback } from "./playback.js";

const PATH = "/v1/spatial-cams";
const LIVE_WAIT = 300; // after the last change [ms]

class Studio {
  constructor(api, openapi, titles) {
    this.api = api;
    this.schemas = new Schemas(openapi, PATH, "SpatialCamSpec");
    this.store = new SpecStore();
    this.form = new Form(this.store, this.schemas, titles, ["machine"]);
    this.files = new Files(api, openapi, `${PATH}/{cam_id}`, "body.stl");
    this.scene = sceneOn(byId("scene"));
    this.turning = new Playback((angle) => this.scene?.turnTo(angle), byId("scene"));
    listCalls(api);
    this.#listen();
  }

  begin() {
    const menu = byId("example");
    menu.append(...Object.entries(this.schemas.examples).map(([name, { summary }]) => element("option", { value: name }, summary)));
    menu.addEventListener("change", () => this.#open(menu.value));
    menu.value = "p4";
    this.#open(menu.value);
  }

  #open(name) {
    this.store.replace(this.schemas.examples[name].value);
    this.design();
  }

  #listen() {
    const later = debounced(LIVE_WAIT, () => {
      if (byId("live").checked && JSON.stringify(this.store.spec) !== this.requested) this.design();
    });
    this.store.addEventListener("change", later);
    byId("design").addEventListener("click", () => this.design());
    document.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) this.design();
    });
  }

  /** Asks for a cam of the present spec; an older question is given up. */
  async design() {
    this.requested = JSON.stringify(this.store.spec);
    this.abort?.abort();
    const { signal } = (this.abort = new AbortController());
    const slow = setTimeout(() => showStatus("Working …", "working"), 300);
    try {
      const began = performance.now();
      const design = await this.api.post(PATH, structuredClone(this.store.spec), { signal });
      clearTimeout(slow);
      byId("took").textContent = `${Math.round(performance.now() - began)} ms with transfer; ${Math.round(1000 * design.report.seconds)} ms in the core`;
      this.form.showErrors([]);
      byId("conflict").replaceChildren();
      show(design);
      this.files.show(design);
      await this.#draw(design, signal);
    } catch (error) {
      if (error instanceof Problem) showProblem(error, this.form.showErrors(error.document.errors ?? []));
      else if (error.name !== "AbortError") throw error;
    } finally {
      clearTimeout(slow);
    }
  }

  /** The picture; of a cam that leaves no body, the reason. */
  async #draw(design, signal) {
    if (!this.scene || design.motion.length === 0) return;
    try {
      this.scene.show(await this.api.get(`${design.links.self}/surfaces.json`, { signal }));
      showNote("");
    } catch (error) {
      if (!(error instanceof Problem)) throw error;
      this.scene.clear();
      showNote(error.message);
    }
  }
}

/** The picture, or a note for a browser without WebGL. */
function sceneOn(canvas) {
  try {
    const scene = new Scene(canvas);
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => event.buttons && scene.orbit(event.movementX, event.movementY));
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return;
      event.preventDefault();
      scene.zoom(Math.exp(0.001 * event.deltaY));
    });
    canvas.addEventListener("keydown", ({ key }) => {
      const steps = { a: [-25, 0], d: [25, 0], w: [0, -25], s: [0, 25], ArrowUp: [0, -25], ArrowDown: [0, 25] };
      if (steps[key]) scene.orbit(...steps[key]);
      if ("+-".includes(key)) scene.zoom(key === "+" ? 0.9 : 1.1);
    });
    return scene;
  } catch (error) {
    showNote(error.message);
    return null;
  }
}

function showNote(text) {
  byId("no-picture").textContent = text;
  byId("no-picture").hidden = text === "";
}

const STATUS_TEXT = {
  optimal: "Optimal: every limit holds, and the gap is within the tolerance.",
  feasible: "Feasible: every limit holds, and no wall is undercut.",
  unsolved: "Unsolved: no cam was found, and that there is none is not proven.",
  infeasible: "Infeasible: a limit is broken, or a wall is undercut.",
};

function show(design) {
  const stop = design.severity === "stop";
  const text = STATUS_TEXT[design.status];
  showStatus(stop ? `STOP, this cam cannot work. ${text}` : text, stop ? "stop" : design.status);
  byId("warnings").replaceChildren(...warnings(design.warnings));
  byId("sizes").replaceChildren(...sizes(design));
  const names = ["quantity", "value", "cam angle", "where", "bound", ""];
  byId("margins").replaceChildren(...tableParts(names, design.extremes.map(row)));
}

function row(each) {
  const where = [each.roller ? `${each.roller}${each.side ?? ""}` : "", each.rho_mm === null ? "" : `ρ = ${figure(each.rho_mm, 4)} mm`];
  return element(
    "tr",
    { class: each.holds ? "" : "broken", title: each.evidence },
    element("th", { scope: "row" }, words(each.quantity)),
    element("td", {}, `${figure(each.value, 5)} ${each.unit === "1" ? "" : each.unit}`),
    element("td", {}, each.angle_deg === null ? "" : `${figure(each.angle_deg, 4)}°`),
    element("td", {}, where.filter(Boolean).join(", ")),
    element("td", {}, each.bound === null ? "" : figure(each.bound, 5)),
    element("td", {}, each.bound === null ? "" : each.holds ? "holds" : "broken"),
  );
}

async function start() {
  const api = new Api();
  const paths = ["/openapi.json", "/v1/motion-laws"];
  const [openapi, laws] = await Promise.all(paths.map((path) => api.get(path, { silent: true })));
  new Studio(api, openapi, Object.fromEntries(laws.map(({ kind, title }) => [kind, title]))).begin();
}

start().catch((error) => {
  showStatus(`The studio could not start: ${error.message}`, "problem");
  throw error;
});
