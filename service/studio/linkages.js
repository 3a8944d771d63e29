// The studio's page of linkages: a shaper that turns, an arm whose target is dragged.

import { fromAddress, toAddress } from "./address.js";
import { Api, Problem } from "./api.js";
import { Arm } from "./arm.js";
import { listCalls } from "./calls.js";
import { byId, element, debounced } from "./dom.js";
import { Files } from "./files.js";
import { LatestRequest } from "./latest_request.js";
import { put } from "./pointer.js";
import { conflict, showStatus, showProblem } from "./result.js";
import { Schemas } from "./schema.js";
import { Sections } from "./sections.js";
import { Shaper } from "./shaper.js";
import { SpecStore } from "./spec_store.js";

const LIVE_WAIT = 120; // after the last change [ms]
const KINDS = {
  "six-bar-shapers": { schema: "ShaperSpec", first: "p5", view: Shaper, file: "motion.svg" },
  "palletising-arms": { schema: "ArmSpec", first: "irb-660", view: Arm, file: "workspace.svg" },
};

/** One kind of linkage: its spec, its form, what is shown of its answers. */
class Editor {
  /** `ask` asks at once about the present spec. */
  constructor(api, openapi, kind, ask) {
    const { schema, first, view, file } = KINDS[kind];
    this.path = `/v1/linkages/${kind}`;
    this.schemas = new Schemas(openapi, this.path, schema);
    this.store = new SpecStore();
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
    this.request = new LatestRequest((signal) => this.#answer(signal));
    const ask = () => this.request.send();
    this.editors = Object.fromEntries(Object.keys(KINDS).map((kind) => [kind, new Editor(api, openapi, kind, ask)]));
    listCalls(api);
    this.#listen();
  }

  begin() {
    this.#followAddress();
  }

  #followAddress() {
    const asked = new URLSearchParams(location.hash.slice(1)).get("kind");
    const kind = asked in this.editors ? asked : Object.keys(KINDS)[0];
    const shared = fromAddress();
    if (shared) this.editors[kind].store.replace(shared);
    this.#open(kind);
  }

  #open(kind) {
    this.kind = kind;
    this.editor = this.editors[kind];
    for (const each of Object.values(this.editors)) each.view.box.hidden = true;
    for (const link of byId("kinds").children) {
      if (link.hash === `#kind=${kind}`) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
    byId("made").href = this.editor.path;
    byId("example").replaceChildren(
      ...Object.entries(this.editor.schemas.examples).map(([name, { summary }]) => element("option", { value: name }, summary)),
    );
    byId("example").value = this.editor.example;
    this.editor.form.show();
    this.request.send();
  }

  #listen() {
    const later = debounced(LIVE_WAIT, () => {
      if (byId("live").checked && JSON.stringify(this.editor.store.spec) !== this.requested) this.request.send();
    });
    for (const editor of Object.values(this.editors)) {
      editor.store.addEventListener("change", ({ detail }) => {
        if (detail.structural) editor.form.show();
        later();
      });
    }
    byId("example").addEventListener("change", () => {
      this.editor.example = byId("example").value;
      this.#take(this.editor.schemas.examples[this.editor.example].value);
    });
    byId("design").addEventListener("click", () => this.request.send());
    document.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) this.request.send();
    });
    window.addEventListener("hashchange", () => this.#followAddress());
  }

  /** Another spec, asked about at once. */
  #take(spec) {
    this.editor.store.replace(spec);
    this.request.send();
  }

  async #answer(signal) {
    const { editor, kind } = this;
    const spec = structuredClone(editor.store.spec);
    this.requested = JSON.stringify(spec);
    const slow = setTimeout(() => showStatus("Working …", "working"), 300);
    try {
      const began = performance.now();
      const found = await this.api.post(editor.path, spec, { signal });
      clearTimeout(slow);
      byId("took").textContent = `${Math.round(performance.now() - began)} ms with transfer`;
      if (editor !== this.editor) return;
      editor.form.showErrors([]);
      history.replaceState(null, "", `#kind=${kind}&${toAddress(spec)}`);
      byId("conflict").replaceChildren(...(found.conflict ? conflict(found.conflict, (changes) => this.#relax(changes)) : []));
      editor.files.show(found);
      await editor.view.show(found, signal);
    } catch (error) {
      if (!(error instanceof Problem)) throw error;
      showProblem(error, editor.form.showErrors(error.document.errors ?? []));
    } finally {
      clearTimeout(slow);
    }
  }

  /** Makes the least change of one requirement that helps. */
  #relax(changes) {
    const spec = structuredClone(this.editor.store.spec);
    for (const { field, requested, needed } of changes) {
      const present = this.editor.store.at(field);
      const wider = needed < requested ? "min" : "max";
      put(spec, typeof present === "object" ? `${field}/${wider}` : field, needed);
    }
    this.#take(spec);
  }
}

async function start() {
  const api = new Api();
  new Studio(api, await api.get("/openapi.json", { silent: true })).begin();
}

start().catch((error) => {
  showStatus(`The studio could not start: ${error.message}`, "problem");
  throw error;
});
