// The studio's page of linkages: a shaper that turns, an arm whose target is dragged.

import { fromAddress, toAddress } from "./address.js";
import { Api, Problem } from "./api.js";
import { Arm } from "./arm.js";
import { listCalls } from "./calls.js";
import { byId, element, settled } from "./dom.js";
import { Files } from "./files.js";
import { Newest } from "./newest.js";
import { put } from "./pointer.js";
import { conflict, say, showProblem } from "./result.js";
import { Schemas } from "./schema.js";
import { Sections } from "./sections.js";
import { Shaper } from "./shaper.js";
import { Store } from "./store.js";

const LIVE_WAIT = 120; // after the last change [ms]
const KINDS = {
  "six-bar-shapers": { schema: "ShaperSpec", first: "p5", view: Shaper, file: "motion.svg" },
  "palletising-arms": { schema: "ArmSpec", first: "irb-660", view: Arm, file: "workspace.svg" },
};

/** One kind of linkage: its spec, its form, what is shown of its answers. */
class Bench {
  /** `ask` asks at once about the present spec. */
  constructor(api, openapi, kind, ask) {
    const { schema, first, view, file } = KINDS[kind];
    this.path = `/v1/linkages/${kind}`;
    this.schemas = new Schemas(openapi, this.path, schema);
    this.store = new Store();
    this.example = first;
    this.store.replace(this.schemas.examples[first].value);
    this.view = new view(api, this.store, ask);
    this.form = new Sections(this.store, this.schemas, (form) => this.view.sections(form));
    this.files = new Files(api, openapi, `${this.path}/{linkage_id}`, file);
  }
}

class Studio {
  constructor(api, openapi) {
    this.api = api;
    this.newest = new Newest((signal) => this.#answer(signal));
    const ask = () => this.newest.now();
    this.benches = Object.fromEntries(Object.keys(KINDS).map((kind) => [kind, new Bench(api, openapi, kind, ask)]));
    listCalls(api);
    this.#listen();
  }

  begin() {
    this.#followAddress();
  }

  #followAddress() {
    const asked = new URLSearchParams(location.hash.slice(1)).get("kind");
    const kind = asked in this.benches ? asked : Object.keys(KINDS)[0];
    const shared = fromAddress();
    if (shared) this.benches[kind].store.replace(shared);
    this.#open(kind);
  }

  #open(kind) {
    this.kind = kind;
    this.bench = this.benches[kind];
    for (const each of Object.values(this.benches)) each.view.box.hidden = true;
    for (const link of byId("kinds").children) {
      if (link.hash === `#kind=${kind}`) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
    byId("made").href = this.bench.path;
    byId("example").replaceChildren(
      ...Object.entries(this.bench.schemas.examples).map(([name, { summary }]) => element("option", { value: name }, summary)),
    );
    byId("example").value = this.bench.example;
    this.bench.form.show();
    this.newest.now();
  }

  #listen() {
    const later = settled(LIVE_WAIT, () => {
      if (byId("live").checked && JSON.stringify(this.bench.store.spec) !== this.asked) this.newest.now();
    });
    for (const bench of Object.values(this.benches)) {
      bench.store.addEventListener("change", ({ detail }) => {
        if (detail.structural) bench.form.show();
        later();
      });
    }
    byId("example").addEventListener("change", () => {
      this.bench.example = byId("example").value;
      this.#take(this.bench.schemas.examples[this.bench.example].value);
    });
    byId("design").addEventListener("click", () => this.newest.now());
    document.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) this.newest.now();
    });
    window.addEventListener("hashchange", () => this.#followAddress());
  }

  /** Another spec, asked about at once. */
  #take(spec) {
    this.bench.store.replace(spec);
    this.newest.now();
  }

  async #answer(signal) {
    const { bench, kind } = this;
    const spec = structuredClone(bench.store.spec);
    this.asked = JSON.stringify(spec);
    const slow = setTimeout(() => say("Working …", "working"), 300);
    try {
      const began = performance.now();
      const found = await this.api.post(bench.path, spec, { signal });
      clearTimeout(slow);
      byId("took").textContent = `${Math.round(performance.now() - began)} ms with the way there`;
      if (bench !== this.bench) return;
      bench.form.faults([]);
      history.replaceState(null, "", `#kind=${kind}&${toAddress(spec)}`);
      byId("conflict").replaceChildren(...(found.conflict ? conflict(found.conflict, (change) => this.#mend(change)) : []));
      bench.files.show(found);
      await bench.view.show(found, signal);
    } catch (error) {
      if (!(error instanceof Problem)) throw error;
      showProblem(error, bench.form.faults(error.document.errors ?? []));
    } finally {
      clearTimeout(slow);
    }
  }

  /** Makes the least change of one wish that helps. */
  #mend({ field, requested, needed }) {
    const spec = structuredClone(this.bench.store.spec);
    const present = this.bench.store.at(field);
    const wider = needed < requested ? "min" : "max";
    put(spec, typeof present === "object" ? `${field}/${wider}` : field, needed);
    this.#take(spec);
  }
}

async function start() {
  const api = new Api();
  new Studio(api, await api.get("/openapi.json", { silent: true })).begin();
}

start().catch((error) => {
  say(`The studio could not start: ${error.message}`, "problem");
  throw error;
});
