// A spec in an address: base64 of its UTF-8, so that a page can be passed on.

/** spec=…, for what stands behind a #. */
export function toAddress(spec) {
  const bytes = new TextEncoder().encode(JSON.stringify(spec));
  const letters = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
  return `spec=${btoa(letters).replaceAll("+", "-").replaceAll("/", "_")}`;
}

/** The spec in the page's address: null where there is none, undefined where it cannot be read. */
export function fromAddress() {
  const text = new URLSearchParams(location.hash.slice(1)).get("spec");
  if (!text) return null;
  try {
    const bytes = Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
    return JSON.parse(new TextDecoder().decode(bytes));
  } catch {
    return undefined;
  }
}
