// SPDX-License-Identifier: Apache-2.0
// The server: its state and pictures, and edits, one request at a time.

const token = location.hash.slice(1) || sessionStorage.getItem("token") || "";
sessionStorage.setItem("token", token);
history.replaceState(null, "", location.pathname);

const headers = { "X-Nephos-Token": token };
const decoder = new TextDecoder();

// Record for tests and measurements: edits with their answers, pictures as they were drawn.
export const record = { state: null, edits: [], draws: [], ready: false };
window.nephos = record;

export async function getJson(path) {
  const reply = await fetch(path, { headers, cache: "no-store" });
  if (!reply.ok) throw new Error(await reply.text());
  return reply.json();
}

export async function getBytes(path) {
  const reply = await fetch(path, { headers, cache: "no-store" });
  if (!reply.ok) throw new Error(await reply.text());
  return new Uint8Array(await reply.arrayBuffer());
}

// An answer of a JSON line and pixels behind it, or null where there are none.
export async function getPictures(path) {
  const reply = await fetch(path, { headers, cache: "no-store" });
  if (!reply.ok) throw Object.assign(new Error(await reply.text()), { status: reply.status });
  const buffer = await reply.arrayBuffer(), bytes = new Uint8Array(buffer), end = bytes.indexOf(10);
  const pixels = bytes.length > end + 1 ? new Uint8ClampedArray(buffer, end + 1) : null;
  return [JSON.parse(decoder.decode(bytes.subarray(0, end))), pixels];
}

// Posts a body; the answer has the state of the document, and the reason of a refusal.
export async function post(path, body = "") {
  const reply = await fetch(path, { method: "POST", headers, body });
  const is_json = reply.headers.get("Content-Type").startsWith("application/json");
  return is_json ? reply.json() : { refusal: await reply.text() };
}

// Posts an edit that is no set, and tells its answer.
export async function act(path, body = "") {
  sends++;
  const answer = await post(path, body);
  tell("edit", [], answer);
  return answer;
}

// Edits that wait for the one under way. A later value of a key replaces the earlier one.
const waiting = new Map();
let is_posting = false, gesture = 0, sends = 0;
const listeners = { edit: [], picture: [], fault: [] };

export function on(event, listener) { listeners[event].push(listener); }

export function tell(event, ...what) { for (const listener of listeners[event]) listener(...what); }

// Number of the last edit; NaN while one is under way. A description that was asked for before it lacks it.
export function getEditNumber() { return is_posting ? NaN : sends; }

// Begins a gesture: its edits are undone together.
export function beginGesture() { gesture = Date.now(); }

async function send() {
  if (is_posting || !waiting.size) return;
  is_posting = true;
  sends++;
  const keys = [...waiting.keys()];
  const body = [...waiting].map(([key, value]) => key + "=" + value).join("\n");
  const sent = performance.now();
  waiting.clear();
  try {
    const answer = await post("/api/set?gesture=" + gesture, body);
    record.edits.push({ keys, sent, answered: performance.now(), ...answer });
    tell("edit", keys, answer);
  } catch (fault) {
    tell("fault", "the server does not answer: " + fault.message);
  }
  is_posting = false;
  send();
}

export function set(key, value) {
  waiting.set(key, value);
  send();
}

// Sets several keys in one request.
export function setAll(pairs) {
  for (const [key, value] of Object.entries(pairs)) waiting.set(key, value);
  send();
}

// An edit of its own.
export function setOnce(key, value) {
  beginGesture();
  set(key, value);
}

// Follows the picture until the server ends.
export async function follow() {
  let after = 0;
  for (;;) {
    try {
      const [state, pixels] = await getPictures("/api/picture?after=" + after);
      after = state.number;
      tell("picture", state, pixels);
      if (pixels) await new Promise(requestAnimationFrame);
      if (pixels) record.draws.push({ at: performance.now(), ...state });
      if (record.draws.length > 2000) record.draws.splice(0, 1000);
      record.state = state;
    } catch (fault) {
      tell("fault", fault.status ? fault.message : "the server does not answer");
      if (fault.status === 401) return;
      await new Promise(resolve => setTimeout(resolve, 1000));
    }
  }
}
