// The errors of a problem document, shown at the fields of #form that they belong to.

/** Puts errors at their fields, those of before taken away; returns those that have no place. */
export function showFieldErrors(errors) {
  for (const place of document.querySelectorAll("[data-error]")) place.textContent = "";
  for (const input of document.querySelectorAll("[aria-invalid]")) input.removeAttribute("aria-invalid");
  return errors.filter(({ pointer, rule, remedy }) => {
    const place = nearest(pointer ?? "", "data-error");
    if (!place) return true;
    place.textContent = [place.textContent, sentences(rule, remedy)].filter(Boolean).join(" ");
    nearest(pointer, "data-pointer")?.setAttribute("aria-invalid", "true");
    return false;
  });
}

/** The element of a pointer, or of the closest field around it. */
function nearest(pointer, attribute) {
  for (let path = pointer; path; path = path.slice(0, path.lastIndexOf("/"))) {
    const found = document.querySelector(`#form [${attribute}="${CSS.escape(path)}"]`);
    if (found) return found;
  }
  return null;
}

/** What is wrong and the way out, each with its full stop. */
export const sentences = (...texts) =>
  texts.filter(Boolean).map((text) => (/[.!?]$/.test(text) ? text : `${text}.`)).join(" ");
