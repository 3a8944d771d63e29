// A small sweep over one or two numbers of the spec, and the trade-off curve that comes out of it.

import { byId, element, figure, shape } from "./dom.js";
import { labelOf, words } from "./names.js";
import { numbers } from "./pointer.js";

const SIZE = { width: 620, height: 340, left: 74, right: 16, top: 14, bottom: 46 };

export class Sweep {
  /** `pick` is given the values of an item: {pointer: number}. */
  constructor(api, store, schemas, pick) {
    Object.assign(this, { api, store, schemas, pick, items: [] });
    byId("sweep-start").addEventListener("click", () => this.start());
    byId("sweep-stop").addEventListener("click", () => this.stop());
    for (const id of ["sweep-x", "sweep-y"]) byId(id).addEventListener("change", () => this.#draw());
    this.#axes();
    store.addEventListener("change", () => this.#axes());
    const { kinds } = schemas.described(schemas.named.SweepSpec.properties.quantities.items);
    byId("sweep-quantity").replaceChildren(...kinds.map(([kind]) => element("option", { value: kind }, words(kind))));
    byId("sweep-quantity").value = "peak_acceleration";
  }

  // -- what is varied -----------------------------------------------------------------------

  #axes() {
    const known = numbers(this.store.spec).filter(([pointer]) => !/tolerance|budget/.test(pointer));
    const listed = JSON.stringify(known.map(([pointer]) => pointer));
    if (listed === this.listed) return;
    this.listed = listed;
    for (const which of ["1", "2"]) {
      const select = byId(`sweep-axis-${which}`);
      const before = select.value;
      select.replaceChildren(
        element("option", { value: "" }, which === "1" ? "choose a number …" : "none"),
        ...known.map(([pointer]) => element("option", { value: pointer }, this.#named(pointer))),
      );
      select.value = known.some(([pointer]) => pointer === before) ? before : "";
      select.onchange = () => this.#suggest(which);
    }
    if (!byId("sweep-axis-1").value) {
      const first = known.find(([pointer]) => pointer.startsWith("/limits")) ?? known[0];
      if (first) byId("sweep-axis-1").value = first[0];
      this.#suggest("1");
    }
  }

  /** "limit pressure angle: rise [°]" of /limits/0/rise_deg. */
  #named(pointer) {
    const steps = pointer.split("/").slice(1);
    const at = (depth) => this.store.at(`/${steps.slice(0, depth).join("/")}`);
    const last = labelOf(steps.at(-1));
    if (steps[0] === "limits") return `limit ${words(at(2).kind)}: ${last}`;
    if (steps[0] === "program") return `segment ${Number(steps[1]) + 1} (${words(at(2).kind)}): ${steps.slice(2, -1).map(words).join(" ")} ${last}`;
    return [...steps.slice(0, -1).map(words), last].join(": ").replace("follower: ", "follower ");
  }

  #suggest(which) {
    const value = this.store.at(byId(`sweep-axis-${which}`).value);
    if (typeof value !== "number") return;
    byId(`sweep-from-${which}`).value = Number((0.8 * value).toPrecision(3));
    byId(`sweep-to-${which}`).value = Number((1.25 * value).toPrecision(3));
  }

  #spec() {
    const axis = (which) => ({
      kind: "range",
      pointer: byId(`sweep-axis-${which}`).value,
      start: Number(byId(`sweep-from-${which}`).value),
      stop: Number(byId(`sweep-to-${which}`).value),
      count: Number(byId(`sweep-count-${which}`).value),
    });
    const axes = ["1", "2"].filter((which) => byId(`sweep-axis-${which}`).value).map(axis);
    return { name: "studio", base: this.store.spec, axes, plan: { kind: "grid" }, quantities: [{ kind: byId("sweep-quantity").value }] };
  }

  // -- running ------------------------------------------------------------------------------

  async start() {
    this.#close();
    this.items = [];
    this.front = new Set();
    this.known = false; // which quantities the designs have
    byId("sweep-curve").hidden = false;
    this.#draw();
    this.#report("Asking …");
    try {
      this.sweep = await this.api.post("/v1/sweeps", this.#spec());
    } catch (problem) {
      this.#report(problem.message, true);
      return;
    }
    const path = `${this.sweep.links.self}/events`;
    this.api.note("GET", path);
    this.events = new EventSource(path);
    this.events.addEventListener("item", (event) => this.#addItem(JSON.parse(event.data)));
    this.events.addEventListener("progress", (event) => this.#progress(JSON.parse(event.data)));
    this.events.addEventListener("end", (event) => this.#end(JSON.parse(event.data)));
    byId("sweep-stop").disabled = false;
  }

  async stop() {
    if (this.sweep) await this.api.delete(`${this.sweep.links.self}?discard=false`).catch((problem) => this.#report(problem.message, true));
  }

  #close() {
    this.events?.close();
    this.events = null;
    byId("sweep-stop").disabled = true;
  }

  #addItem(item) {
    this.items.push(item);
    if (!this.known && Object.keys(item.quantities).length > 0) this.#quantities(item);
    this.late ??= requestAnimationFrame(() => {
      this.late = null;
      this.#draw();
    });
  }

  #progress({ progress, counts, time_left_s: left }) {
    byId("sweep-progress").value = progress;
    const rest = left ? `, ${figure(left, 2)} s left` : "";
    this.#report(`${counts.done} of ${counts.items} designs, ${counts.unsolved} unsolved, ${counts.infeasible} infeasible, ${counts.failed} failed${rest}.`);
  }

  async #end(summary) {
    this.#close();
    this.#progress(summary);
    await this.#findFront();
  }

  /** The service says which designs no other beats. */
  async #findFront() {
    const [x, y] = ["sweep-x", "sweep-y"].map((id) => byId(id).value);
    this.front = new Set();
    if (this.sweep && x && y && x !== y && !x.startsWith("/")) {
      const wanted = [x, y].map((name) => `minimise=${encodeURIComponent(name)}`).join("&");
      const found = await this.api.get(`${this.sweep.links.pareto}?${wanted}`).catch(() => ({ items: [] }));
      this.front = new Set(found.items.map((item) => item.number));
    }
    this.#draw(false);
  }

  #report(text, wrong = false) {
    byId("sweep-message").textContent = text;
    byId("sweep-message").classList.toggle("error", wrong);
  }

  // -- the curve ----------------------------------------------------------------------------

  #quantities(item) {
    this.known = true;
    const objective = [this.store.spec.objective].flat()[0]?.kind ?? "base_radius";
    const second = byId("sweep-quantity").value;
    const names = [...Object.keys(item.quantities), ...Object.keys(item.values)];
    for (const [id, wanted] of [["sweep-x", objective], ["sweep-y", second]]) {
      byId(id).replaceChildren(...names.map((name) => element("option", { value: name }, name.startsWith("/") ? this.#named(name) : labelOf(name))));
      byId(id).value = names.find((name) => name.startsWith(wanted)) ?? names[0];
    }
  }

  #draw(changed = true) {
    const [x, y] = ["sweep-x", "sweep-y"].map((id) => byId(id).value);
    const of = (item, name) => (name.startsWith("/") ? item.values[name] : item.quantities[name]);
    const shown = this.items
      .filter((item) => item.status === "optimal" || item.status === "feasible")
      .map((item) => ({ item, x: of(item, x), y: of(item, y) }))
      .filter((point) => Number.isFinite(point.x) && Number.isFinite(point.y));
    const picture = byId("trade-off");
    picture.replaceChildren();
    if (shown.length === 0) return;
    const [px, py] = [scaled(shown.map((p) => p.x), SIZE.left, SIZE.width - SIZE.right), scaled(shown.map((p) => p.y), SIZE.height - SIZE.bottom, SIZE.top)];
    picture.append(...ticks(px, py), ...titles(x.startsWith("/") ? this.#named(x) : labelOf(x), y.startsWith("/") ? this.#named(y) : labelOf(y)));
    const best = shown.filter((p) => this.front?.has(p.item.number)).sort((a, b) => a.x - b.x);
    if (best.length > 1) picture.append(shape("path", { class: "front", d: best.map((p, i) => `${i ? "L" : "M"}${px.at(p.x)} ${py.at(p.y)}`).join("") }));
    picture.append(...shown.map((point) => this.#dot(point, px, py, this.front?.has(point.item.number))));
    if (changed && !this.events && this.sweep) this.#findFront();
  }

  #dot({ item, x, y }, px, py, best) {
    const values = Object.entries(item.values).map(([pointer, value]) => `${this.#named(pointer)} ${figure(value, 4)}`).join(", ");
    const label = `${figure(x, 5)}, ${figure(y, 5)}: ${values}${best ? ", on the trade-off curve" : ""}`;
    const take = () => this.pick(item.values);
    const dot = shape(
      "circle",
      { cx: px.at(x), cy: py.at(y), r: best ? 6 : 4.5, class: best ? "dot best" : "dot", tabindex: 0, role: "button", "aria-label": label, onclick: take,
        onkeydown: (event) => (event.key === "Enter" || event.key === " ") && (event.preventDefault(), take()) },
      shape("title", {}, label),
    );
    return dot;
  }
}

function scaled(values, from, to) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const room = 0.06 * (high - low || Math.abs(high) || 1);
  const [least, most] = [low - room, high + room];
  return { least, most, at: (value) => Number((from + ((value - least) / (most - least)) * (to - from)).toFixed(2)) };
}

function round(scale) {
  const rough = (scale.most - scale.least) / 5;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((each) => each >= rough);
  const first = Math.ceil(scale.least / step) * step;
  return Array.from({ length: 12 }, (_, k) => first + k * step).filter((value) => value <= scale.most);
}

function ticks(px, py) {
  const bottom = SIZE.height - SIZE.bottom;
  const across = round(px).flatMap((value) => [
    shape("line", { class: "grid", x1: px.at(value), x2: px.at(value), y1: SIZE.top, y2: bottom }),
    shape("text", { class: "tick", x: px.at(value), y: bottom + 16, "text-anchor": "middle" }, figure(value, 4)),
  ]);
  const up = round(py).flatMap((value) => [
    shape("line", { class: "grid", x1: SIZE.left, x2: SIZE.width - SIZE.right, y1: py.at(value), y2: py.at(value) }),
    shape("text", { class: "tick", x: SIZE.left - 6, y: py.at(value) + 4, "text-anchor": "end" }, figure(value, 4)),
  ]);
  return [...across, ...up];
}

function titles(x, y) {
  return [
    shape("text", { class: "axis", x: (SIZE.left + SIZE.width - SIZE.right) / 2, y: SIZE.height - 8, "text-anchor": "middle" }, x),
    shape("text", { class: "axis", transform: `translate(14 ${(SIZE.top + SIZE.height - SIZE.bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, y),
  ];
}
