// The key to the service, where it asks for one. The browser keeps it as a cookie that no script can
// read, so that pictures, downloads and events bring it along too.

import { byId, element } from "./dom.js";

const SESSION = "/session";
const KEPT = "has-key"; // in the tab's storage: whether a key was entered
let asking = null;

/** Whether a key was entered in this tab. */
export const hasKey = () => sessionStorage.getItem(KEPT) !== null;

/** Asks for the key, once for all that need it; whether the service has accepted it. */
export function askForKey() {
  asking ??= new Promise(ask).finally(() => (asking = null));
  return asking;
}

function ask(resolve) {
  const input = element("input", { id: "key", type: "password", autocomplete: "off", required: true, spellcheck: "false" });
  const error = element("p", { class: "error", role: "alert" });
  const cancel = element("button", { type: "button", onclick: () => dialog.close() }, "Cancel");
  const form = element(
    "form",
    { method: "dialog" },
    element("h2", {}, "Key"),
    element("p", { class: "note" }, "This service asks for one; who runs it makes them with the command camwright keys create."),
    element("label", { for: "key" }, "Your key: "), input, error,
    element("p", { class: "buttons" }, element("button", { class: "main" }, "Use it"), cancel),
  );
  const dialog = element("dialog", { id: "key-dialog" }, form);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const refusal = await keep(input.value.trim());
    if (refusal) error.textContent = refusal;
    else dialog.close("kept");
  });
  dialog.addEventListener("close", () => {
    dialog.remove();
    resolve(dialog.returnValue === "kept");
  });
  document.body.append(dialog);
  dialog.showModal();
}

/** Gives the key to the service for its cookie; why it refuses, or null. */
async function keep(key) {
  let answer;
  try {
    answer = await fetch(SESSION, { method: "POST", headers: { Authorization: `Bearer ${key}` } });
  } catch { // a character that no header has, or no service
    return "It cannot be sent: is it complete, and the service running?";
  }
  if (!answer.ok) return (await answer.json()).detail;
  sessionStorage.setItem(KEPT, "");
  showForget();
  return null;
}

function showForget() {
  const button = byId("forget-key");
  if (button) button.hidden = !hasKey();
}

byId("forget-key")?.addEventListener("click", async () => {
  await fetch(SESSION, { method: "DELETE" });
  sessionStorage.removeItem(KEPT);
  location.reload();
});
showForget();
