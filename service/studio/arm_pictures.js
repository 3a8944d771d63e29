// The arm from the side and from above, with its target to be dragged. Shapes and places come from the
// service; what the pointer says is turned into coordinates of the target.

import { drawn } from "./cam.js";
import { byId, shape } from "./dom.js";

const STEP = 10; // of an arrow key [mm]; with Shift ten of them
const ARROWS = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export class ArmPictures {
  /** `moved` receives where the target is wanted: {x_mm, y_mm, z_mm}, or some of them. */
  constructor(moved) {
    this.side = new Picture(byId("side"), ([r, z]) => moved({ ...this.#towards(Math.max(r, 0)), z_mm: z }));
    this.plan = new Picture(byId("plan"), ([x, y]) => moved({ x_mm: x, y_mm: y }));
  }

  /** A pose of the scene, one of its solutions in full and the others pale; `fresh`: as is asked now. */
  show(scene, pose, index, chosen, fresh) {
    this.pose = pose;
    const placed = scene.poses[index];
    const off = pose ? !pose.reachable : false;
    const ways = (placed?.solutions ?? []).map((each, k) => standing(scene.arm, each, pose.solutions[k], k === chosen));
    ways.push(...ways.splice(chosen, 1)); // the chosen one on top
    this.side.show(scene, [...drawn(scene.shapes), ...ways], placed?.target, off, fresh);
    const plan = shape("g", {}, ...drawn(scene.plan.shapes));
    const base = placed?.solutions[chosen]?.base_deg;
    plan.querySelector('[data-part="base"]').setAttribute("transform", `rotate(${base ?? 0})`);
    this.plan.show({ ...scene, extent: scene.plan.extent }, [plan], placed?.plan_target, off, fresh);
  }

  /** A radius the way the target lies: along x where it is on axis 1. */
  #towards(radius) {
    const { x_mm: x, y_mm: y } = this.pose;
    const away = Math.hypot(x, y);
    if (away > 1e-6) this.way = [x / away, y / away];
    const [along, across] = this.way ?? [1, 0];
    return { x_mm: radius * along, y_mm: radius * across };
  }
}

/** The arm in one solution. */
function standing(arm, { mirror, parts }, { beyond }, chosen) {
  const kinds = ["way", chosen ? "" : "ghost", beyond.length > 0 ? "beyond" : ""].filter(Boolean).join(" ");
  const made = shape("g", { class: kinds, transform: `scale(${mirror} 1)` }, ...drawn(arm));
  for (const { name, kind, at } of parts) {
    const place = kind === "turn" ? `rotate(${at[0]})` : `translate(${at[0]} ${at[1]})`;
    made.querySelector(`[data-part="${name}"]`).setAttribute("transform", place);
  }
  return made;
}

/** A picture, y upwards, with a target that follows pointer and arrow keys. */
class Picture {
  /** `moved` receives two coordinates [mm]. */
  constructor(node, moved) {
    Object.assign(this, { node, moved, scale: 1, at: null, held: false });
    this.shapes = shape("g", {});
    this.target = shape("g", { class: "target" }, shape("circle", { class: "reach" }), shape("circle", { class: "mark" }));
    this.stage = shape("g", { class: "mechanism", transform: "scale(1 -1)" }, this.shapes, this.target);
    node.replaceChildren(this.stage);
    this.target.addEventListener("pointerdown", (event) => {
      this.held = true;
      this.target.setPointerCapture(event.pointerId);
      event.preventDefault();
      node.focus({ preventScroll: true });
    });
    this.target.addEventListener("pointermove", (event) => this.held && this.#pulled(event));
    for (const end of ["pointerup", "pointercancel"]) this.target.addEventListener(end, () => this.#released());
    node.addEventListener("dblclick", (event) => this.#pulled(event));
    node.addEventListener("keydown", (event) => this.#key(event));
  }

  show({ extent, scale }, shapes, at, off, fresh) {
    this.scale = scale;
    if (fresh || !this.at) this.at = at ?? null;
    this.shapes.replaceChildren(...shapes);
    const [left, bottom, right, top] = this.#room(extent);
    this.node.setAttribute("viewBox", [left, -top, right - left, top - bottom].join(" "));
    this.target.setAttribute("class", off ? "target off" : "target");
    this.target.toggleAttribute("hidden", !at);
    const unit = (extent[2] - extent[0]) / 100;
    this.target.children[0].setAttribute("r", 4.5 * unit);
    this.target.children[1].setAttribute("r", 1.6 * unit);
    if (this.at && !this.held) this.#put(this.at);
  }

  /** The extent with the target in it; it stands still while the target is held. */
  #room(extent) {
    if (this.held && this.box) return this.box;
    const [left, bottom, right, top] = extent;
    const [x, y] = this.at ?? [left, bottom];
    const edge = 0.05 * (right - left);
    this.box = [Math.min(left, x - edge), Math.min(bottom, y - edge), Math.max(right, x + edge), Math.max(top, y + edge)];
    return this.box;
  }

  #released() {
    this.held = false;
    if (this.at) this.#put(this.at);
  }

  #put([x, y]) {
    this.target.setAttribute("transform", `translate(${x} ${y})`);
  }

  #pulled({ clientX, clientY }) {
    const { x, y } = new DOMPoint(clientX, clientY).matrixTransform(this.stage.getScreenCTM().inverse());
    this.at = [x, y]; // keys go on from here before an answer comes
    this.#put(this.at);
    this.moved([x / this.scale, y / this.scale]);
  }

  #key(event) {
    const way = ARROWS[event.key];
    if (!way || !this.at) return;
    event.preventDefault();
    const step = STEP * (event.shiftKey ? 10 : 1);
    const [x, y] = this.at.map((value, k) => value / this.scale + step * way[k]);
    this.at = [x * this.scale, y * this.scale]; // so that steps add up before an answer comes
    this.moved([x, y]);
  }
}
