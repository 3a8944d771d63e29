// Files of the present design, with what may be chosen about them.

import { byId, element } from "./dom.js";
import { labelOf, words } from "./names.js";

export class Files {
  /** `where`: the path of a design in the contract; `first`: the file that is offered first. */
  constructor(api, openapi, where, first) {
    Object.assign(this, { api, wanted: first });
    this.all = Object.entries(openapi.paths)
      .filter(([path]) => path.startsWith(`${where}/`) && /\.\w+$/.test(path))
      .map(([path, methods]) => [path.slice(where.length + 1), methods.get]);
    this.shared = openapi.components.parameters;
  }

  /** `design` null: there is none. */
  show(design) {
    this.design = design;
    const box = byId("files");
    this.paths = this.all.filter(([name]) => name in (design?.links ?? {}));
    if (this.paths.length === 0) {
      box.replaceChildren(element("p", { class: "note" }, "Files come with a design."));
      return;
    }
    const select = element(
      "select",
      { id: "file-name", onchange: () => this.#choices((this.wanted = select.value)) },
      ...this.paths.map(([name, get]) => element("option", { value: name, title: get.description }, `${name}: ${get.summary.replace(/^\w+: /, "")}`)),
    );
    select.value = this.paths.some(([name]) => name === this.wanted) ? this.wanted : this.paths[0][0];
    box.replaceChildren(
      element("label", { for: "file-name" }, "File"), select,
      element("div", { id: "file-options" }),
      element(
        "p",
        { class: "buttons" },
        element("a", { id: "file-link", class: "button", onclick: () => this.#checkDownload() }, "Download"),
        element("a", { id: "file-open", target: "_blank", onclick: () => this.#checkDownload() }, "Open"),
      ),
      element("p", { class: "error", id: "file-error", "aria-live": "polite" }),
    );
    this.#choices(select.value);
  }

  #choices(name) {
    this.chosen = name;
    const [, get] = this.paths.find(([each]) => each === name) ?? this.paths[0];
    const asked = (get.parameters ?? [])
      .map((each) => (each.$ref ? this.shared[each.$ref.split("/").at(-1)] : each))
      .filter((each) => each.in === "query");
    byId("file-options").replaceChildren(
      ...asked.map((each) => {
        const values = choices(each.schema);
        const id = `option-${each.name}`;
        const input = values
          ? element("select", { id }, element("option", { value: "" }, "default"), ...values.map((value) => element("option", { value }, words(String(value)))))
          : element("input", { id, placeholder: String(each.schema.default ?? "") });
        input.addEventListener("input", () => this.#link());
        return element("div", { class: "field", title: each.description ?? each.schema.description }, element("label", { for: id }, labelOf(each.name)), input);
      }),
    );
    this.#link();
  }

  get #path() {
    const query = new URLSearchParams();
    for (const input of byId("file-options").querySelectorAll("input, select")) {
      if (input.value !== "") query.set(input.id.slice("option-".length), input.value);
    }
    const asked = query.toString();
    return `${this.design.links.self}/${this.chosen}${asked ? `?${asked}` : ""}`;
  }

  #link() {
    byId("file-link").href = this.#path;
    byId("file-link").setAttribute("download", "");
    byId("file-open").href = this.#path;
    byId("file-open").hidden = !/\.(html|svg)$/.test(this.chosen); // what a browser shows
    byId("file-error").textContent = "";
  }

  /** The browser fetches the file; a refusal is shown here instead of landing in a file. */
  async #checkDownload() {
    const path = this.#path;
    this.api.note("GET", path);
    const answer = await fetch(path, { method: "GET", headers: { Range: "bytes=0-0" } });
    if (answer.status >= 400 && byId("file-error")) byId("file-error").textContent = (await answer.json()).detail;
  }
}

function choices(schema) {
  const all = schema.anyOf ?? [schema];
  return all.find((each) => each.enum)?.enum ?? null;
}
