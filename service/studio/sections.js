// A spec as a form of sections: fields of its schema, in an order and with words of the page.

import { byId, element } from "./dom.js";
import { showFieldErrors } from "./field_errors.js";
import { field } from "./fields.js";

export class Sections {
  /** `sections` makes [heading, elements] pairs of this form. */
  constructor(store, schemas, sections) {
    Object.assign(this, { store, schemas, sections });
  }

  /** Makes the form anew from the spec, the focus kept where it was. */
  show() {
    const focus = document.activeElement?.id;
    const all = this.sections(this).flatMap(([heading, elements]) => [element("h3", {}, heading), ...elements]);
    byId("form").replaceChildren(...all);
    if (focus) byId(focus)?.focus();
  }

  /** The fields of these names. */
  some(names, options = {}) {
    const { properties, required = [] } = this.schemas.spec;
    return names.map((name) => field(this, `/${name}`, properties[name], { ...options, required: required.includes(name) }));
  }

  /** Puts the errors of a problem document at their fields; returns those that have no place. */
  showErrors(errors) {
    return showFieldErrors(errors);
  }
}
