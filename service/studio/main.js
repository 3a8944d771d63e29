// The studio: a spec on the left, the cam that comes out on the right. Nothing is computed here;
// every number comes from the service.

import { fromAddress, toAddress } from "./address.js";
import { Api, Problem } from "./api.js";
import { listCalls } from "./calls.js";
import { Cam } from "./cam.js";
import { Charts } from "./charts.js";
import { showDifferences } from "./compare.js";
import { byId, element, debounced } from "./dom.js";
import { Files } from "./files.js";
import { Form } from "./form.js";
import { LatestRequest } from "./latest_request.js";
import { put } from "./pointer.js";
import { showStatus, showDesign, showProblem } from "./result.js";
import { Schemas } from "./schema.js";
import { SpecStore } from "./spec_store.js";
import { showSummary } from "./summary.js";
import { Sweep } from "./sweep.js";

const FIRST = "p2-sized"; // of the worked examples
const LIVE_WAIT = 120; // after the last change [ms]

class Studio {
  constructor(api, openapi, titles) {
    this.api = api;
    this.schemas = new Schemas(openapi, "/v1/designs", "DesignSpec");
    this.store = new SpecStore();
    this.form = new Form(this.store, this.schemas, titles, ["follower", "base_radius_mm"]);
    this.files = new Files(api, openapi, "/v1/designs/{design_id}", "profile.txt");
    this.charts = new Charts((angle) => this.cam.turnTo(angle));
    this.cam = new Cam((angle) => this.charts.point(angle));
    this.sweep = new Sweep(api, this.store, this.schemas, (values) => this.#take(values));
    this.request = new LatestRequest((signal) => this.#answer(signal));
    this.present = null;
    this.kept = null;
    listCalls(api);
    this.#listen();
  }

  begin() {
    const menu = byId("example");
    menu.append(...Object.entries(this.schemas.examples).map(([name, { summary }]) => element("option", { value: name }, summary)));
    menu.addEventListener("change", () => menu.value && this.#open(this.schemas.examples[menu.value].value));
    const shared = fromAddress();
    if (shared === undefined) {
      showStatus("The address holds a spec that cannot be read; an example is shown instead.", "problem");
    }
    if (shared) {
      this.#open(shared);
    } else {
      menu.value = FIRST;
      this.#open(this.schemas.examples[FIRST].value);
    }
  }

  // -- the spec -----------------------------------------------------------------------------

  /** Another spec, designed at once. */
  #open(spec) {
    this.store.replace(spec);
    this.design();
  }

  #listen() {
    const later = debounced(LIVE_WAIT, () => {
      if (byId("live").checked && JSON.stringify(this.store.spec) !== this.requested) this.design();
    });
    this.store.addEventListener("change", () => {
      if (document.activeElement !== byId("json")) byId("json").value = JSON.stringify(this.store.spec, null, 2);
      later();
    });
    byId("json").addEventListener("input", debounced(300, () => this.#read()));
    byId("design").addEventListener("click", () => this.design());
    byId("keep").addEventListener("click", () => this.#keep(this.present));
    byId("drop").addEventListener("click", () => this.#keep(null));
    document.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) this.design();
    });
    for (const tab of document.querySelectorAll("[role=tab]")) {
      tab.addEventListener("click", () => show(tab));
      tab.addEventListener("keydown", (event) => ["ArrowLeft", "ArrowRight"].includes(event.key) && show(other(tab)).focus());
    }
  }

  #read() {
    const area = byId("json");
    let spec;
    try {
      spec = JSON.parse(area.value);
      if (spec === null || typeof spec !== "object" || Array.isArray(spec)) throw new SyntaxError("An object is wanted: { … }.");
    } catch (error) {
      area.setAttribute("aria-invalid", "true");
      byId("json-error").textContent = `This is not JSON yet: ${error.message}`;
      return;
    }
    area.removeAttribute("aria-invalid");
    byId("json-error").textContent = "";
    // a worked example, or a request of a sweep, may be pasted whole
    this.store.replace(spec.value ?? spec.base ?? spec);
  }

  #take(values) {
    this.store.assign(values);
    this.design();
  }

  // -- the design ---------------------------------------------------------------------------

  /** Asks for a design of the present spec: one at a time, the newest wins. */
  design() {
    const asked = JSON.stringify(this.store.spec);
    if (this.request.busy && asked === this.requested) return;
    this.request.send();
  }

  async #answer(signal) {
    this.requested = JSON.stringify(this.store.spec);
    const slow = setTimeout(() => showStatus("Working …", "working"), 300);
    try {
      await this.#solve(structuredClone(this.store.spec), signal);
    } catch (error) {
      if (!(error instanceof Problem)) throw error;
      this.#showRefusal(error);
    } finally {
      clearTimeout(slow);
    }
  }

  /** The quick proof first, so that the cam follows; then, unless the spec changes, the gap is closed. */
  async #solve(spec, signal) {
    const proof = spec.proof ?? "auto";
    const { status } = await this.#post(spec, proof === "auto" ? "quick" : proof, signal);
    if (proof === "auto" && status === "feasible" && !this.request.again) await this.#post(spec, proof, signal);
  }

  async #post(spec, proof, signal) {
    const began = performance.now();
    const design = await this.api.post("/v1/designs", { ...spec, proof }, { signal });
    const took = performance.now() - began;
    byId("took").textContent = `${Math.round(took)} ms with transfer; ${Math.round(1000 * design.report.seconds)} ms in the core`;
    this.form.showErrors([]);
    history.replaceState(null, "", `#${toAddress(spec)}`);
    await this.#showDesign(design, signal);
    return design;
  }

  async #showDesign(design, signal) {
    const made = design.motion.length > 0;
    const fetched = (name) => this.api.get(`${design.links.self}/${name}`, { signal });
    const [motion, profile, scene] = made
      ? await Promise.all([fetched("motion.json?points_per_degree=2"), fetched("profile.json?points_per_degree=2"), fetched("animation.json")])
      : [null, null, null];
    this.present = { design, motion, profile, scene };
    showDesign(design, (changes) => this.#relax(changes));
    showSummary(design);
    this.files.show(design);
    byId("keep").disabled = !made;
    byId("views").hidden = !made;
    this.#draw();
  }

  #draw() {
    showDifferences(this.kept, this.present?.motion ? this.present : null);
    if (!this.present?.motion) return;
    this.charts.show(this.present, this.kept);
    this.cam.show(this.present, this.kept);
  }

  #showRefusal(problem) {
    const loose = this.form.showErrors(problem.document.errors ?? []);
    const { best } = problem.document;
    showProblem(problem, loose);
    if (best?.links) this.#showDesign(best).then(() => showProblem(problem, loose));
  }

  #keep(design) {
    this.kept = design;
    byId("drop").disabled = design === null;
    this.#draw();
  }

  /** Makes the least change of one limit that helps, in every field where it stands. */
  #relax(changes) {
    const spec = structuredClone(this.store.spec);
    for (const { field, needed } of changes) put(spec, `/${field}`, needed);
    this.#open(spec);
  }
}

// -- tabs -------------------------------------------------------------------------------------

const tabs = () => [...document.querySelectorAll("[role=tab]")];
const other = (tab) => tabs().find((each) => each !== tab);

function show(tab) {
  for (const each of tabs()) {
    const on = each === tab;
    each.setAttribute("aria-selected", on);
    each.tabIndex = on ? 0 : -1;
    byId(each.getAttribute("aria-controls")).hidden = !on;
  }
  return tab;
}

async function start() {
  const api = new Api();
  const paths = ["/openapi.json", "/v1/motion-laws", "/v1/followers", "/v1/limits"];
  const [openapi, laws, followers, { limits, objectives }] = await Promise.all(
    paths.map((path) => api.get(path, { silent: true })),
  );
  const entries = [...laws, ...followers, ...limits, ...objectives];
  const titles = Object.fromEntries(entries.map(({ kind, title }) => [kind, title]));
  new Studio(api, openapi, titles).begin();
}

start().catch((error) => {
  showStatus(`The studio could not start: ${error.message}`, "problem");
  throw error;
});
