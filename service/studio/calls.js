// The calls that the page has made, to be copied as curl.

import { curl } from "./api.js";
import { byId, element, figure } from "./dom.js";

export function listCalls(api) {
  const show = () => {
    byId("call-list").replaceChildren(
      ...api.calls.map((call) => {
        const text = curl(call);
        const button = element(
          "button",
          { type: "button", class: "small", "aria-label": `copy ${call.method} ${call.path} as curl`, onclick: () => copy(text, button) },
          "Copy as curl",
        );
        const took = call.ms === null ? "" : `${figure(call.ms, 3)} ms`;
        return element(
          "li",
          {},
          element("span", { class: "method" }, call.method), " ",
          element("code", {}, call.path.length > 90 ? `${call.path.slice(0, 88)}…` : call.path),
          ` ${call.status} ${took} `,
          button,
          element("details", {}, element("summary", {}, "show"), element("pre", {}, text)),
        );
      }),
    );
  };
  api.addEventListener("call", show);
}

async function copy(text, button) {
  try {
    await navigator.clipboard.writeText(text);
    button.textContent = "Copied";
  } catch {
    button.parentElement.querySelector("details").open = true;
    button.textContent = "Select below";
  }
  setTimeout(() => (button.textContent = "Copy as curl"), 1500);
}
