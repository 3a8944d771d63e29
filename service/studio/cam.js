// The cam turning under its follower. Shapes and positions come from the service, frame by frame;
// here they are only shown.

import { byId, shape } from "./dom.js";
import { Playback } from "./playback.js";

const SVG = "http://www.w3.org/2000/svg";
const MARGIN = 0.03; // of the picture

export class Cam {
  /** `moved` receives the cam angle [°] that is shown. */
  constructor(moved) {
    this.moved = moved;
    this.parts = [];
    this.turning = new Playback((angle, turns) => this.#draw(angle, turns), byId("cam"));
  }

  /** The machine of a design; the outline of another one's cam is drawn dashed on it. */
  show(found, other) {
    const { scene } = found;
    const boxes = [scene.extent, ...(other ? [other.scene.extent] : [])];
    const [left, bottom] = [0, 1].map((k) => Math.min(...boxes.map((box) => box[k])));
    const [right, top] = [2, 3].map((k) => Math.max(...boxes.map((box) => box[k])));
    const room = MARGIN * Math.max(right - left, top - bottom);
    const picture = byId("cam");
    picture.setAttribute("viewBox", [left - room, -top - room, right - left + 2 * room, top - bottom + 2 * room].join(" "));
    const stage = shape("g", { transform: `scale(${scene.mirror} -1)`, class: "mechanism" }, ...drawn(scene.shapes));
    if (other && other.scene.mirror === scene.mirror) {
      stage.querySelector('[data-part="cam"]').append(...drawn(other.scene.outline).map(asOther));
    }
    picture.replaceChildren(stage);
    this.parts = scene.parts.map((part) => ({ ...part, node: stage.querySelector(`[data-part="${part.name}"]`) }));
    this.turning.show();
  }

  /** Stops, and shows a cam angle [°]. */
  turnTo(angle) {
    this.turning.turnTo(angle);
  }

  #draw(angle, [whole, part]) {
    if (this.parts.length === 0) return;
    for (const { node, kind, columns } of this.parts) {
      const [a, b] = columns.map((column) => between(column, part));
      const perTurn = kind === "turn" ? columns[0].at(-1) - columns[0][0] : 0;
      node?.setAttribute("transform", kind === "turn" ? `rotate(${a + whole * perTurn})` : `translate(${a} ${b})`);
    }
    this.moved(angle);
  }
}

/** Evenly spaced over a turn; two values are a straight line. */
function between(column, part) {
  const place = part * (column.length - 1);
  const k = Math.min(Math.floor(place), column.length - 2);
  return column[k] + (place - k) * (column[k + 1] - column[k]);
}

/** Shapes that the service has drawn. */
export function drawn(markup) {
  const parsed = new DOMParser().parseFromString(`<svg xmlns="${SVG}">${markup}</svg>`, "image/svg+xml");
  return [...document.importNode(parsed.documentElement, true).children];
}

function asOther(node) {
  node.setAttribute("class", "kept");
  return node;
}
