// The spec that is being edited, and who wants to know.

import { at, put } from "./pointer.js";

export class SpecStore extends EventTarget {
  spec = {};

  /** Another spec altogether. */
  replace(spec) {
    this.spec = structuredClone(spec);
    this.#notify(true);
  }

  /** One field; `structural` where fields come or go with it, so that the form is made anew. */
  set(pointer, value, structural = false) {
    put(this.spec, pointer, value);
    this.#notify(structural);
  }

  /** Many fields at once: {pointer: value}. */
  assign(values) {
    for (const [pointer, value] of Object.entries(values)) put(this.spec, pointer, value);
    this.#notify(true);
  }

  at(pointer) {
    return at(this.spec, pointer);
  }

  #notify(structural) {
    this.dispatchEvent(new CustomEvent("change", { detail: { structural } }));
  }
}
