// Calls to the service. Every call is noted, so that it can be copied as curl.

import { askForKey, hasKey } from "./key.js";

/** A problem document (RFC 9457) as an exception. */
export class Problem extends Error {
  constructor(document) {
    super(document.detail || document.title);
    this.document = document;
  }
}

export class Api extends EventTarget {
  /** LatestRequest first: {method, path, body, status, ms}. */
  calls = [];

  get(path, options) {
    return this.#send("GET", path, undefined, options);
  }

  post(path, body, options) {
    return this.#send("POST", path, body, options);
  }

  delete(path) {
    return this.#send("DELETE", path);
  }

  /** Notes a call that the browser makes by itself: a download, a stream of events. */
  note(method, path, body, status = "", ms = null) {
    this.calls.unshift({ method, path, body, status, ms, keyed: hasKey() });
    this.calls.length = Math.min(this.calls.length, 40);
    this.dispatchEvent(new Event("call"));
  }

  async #send(method, path, body, { signal, silent = false } = {}) {
    const begin = performance.now();
    const headers = body === undefined ? {} : { "Content-Type": "application/json" };
    let answer;
    try {
      answer = await fetch(path, { method, headers, body: body && JSON.stringify(body), signal });
    } catch (error) {
      if (error.name === "AbortError") throw error;
      throw new Problem({ title: "The service does not answer", detail: "The service does not answer. Is it still running?" });
    }
    const text = await answer.text();
    if (!silent) this.note(method, path, body, answer.status, performance.now() - begin);
    const found = text ? JSON.parse(text) : null;
    if (answer.status === 401 && (await askForKey())) return this.#send(method, path, body, { signal, silent });
    if (!answer.ok) throw new Problem(found);
    return found;
  }
}

/** The same call from a shell. */
export function curl({ method, path, body, keyed }) {
  const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;
  const words = ["curl -s"];
  if (method !== "GET" && !(method === "POST" && body !== undefined)) words.push(`-X ${method}`);
  words.push(quoted(location.origin + path));
  if (keyed) words.push('-H "Authorization: Bearer $CAMWRIGHT_KEY"');
  if (body !== undefined) {
    words.push("-H 'Content-Type: application/json'", `-d ${quoted(JSON.stringify(body))}`);
  }
  return words.join(" ");
}
