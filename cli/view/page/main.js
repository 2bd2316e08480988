// SPDX-License-Identifier: Apache-2.0
// The page: its parts, its toolbar and its bar.

import * as controls from "./controls.js";
import "./hand.js";
import { loadSchema } from "./keys.js";
import * as picture from "./picture.js";
import { follow, getText, on, post, record } from "./server.js";
import { printShare } from "./values.js";

const part = id => document.getElementById(id);

// ---- Bar ----

const levels = ["first pixels", "all pixels", "refined"];

function showState(state) {
  const level = levels[Math.min(state.level, 2)];
  const seconds = state.seconds == null ? "" : `, ${state.seconds.toFixed(2)} s`;
  part("level").textContent = state.number ? `${level}, ${state.samples} samples a pixel${seconds}` : "no picture yet";
  part("progress").value = state.fraction ?? 0;
  part("stage-name").textContent = state.stage;
  part("error").textContent = `error ${printShare(state.error)} (noise ${printShare(state.noise)}, bias ${printShare(state.bias)}` +
    (state.bias_source === "unknown" ? ")" : `, ${state.bias_source})`);
  part("message").textContent = part("message").title = state.file_fault || state.message;
}

function showDocument(state) {
  part("undo").disabled = !state.undo;
  part("redo").disabled = !state.redo;
  part("news").hidden = !state.news;
  document.title = (state.edited ? "• " : "") + "nephos view";
}

function showRefusal(text) { part("refusal").textContent = text; }

// ---- Toolbar ----

async function act(path) {
  const answer = await post(path);
  showRefusal(answer.refusal);
  if ("edit" in answer) showDocument(answer);
}

// A word for the shell.
function quote(text) { return "'" + text.replaceAll("'", "'\\''") + "'"; }

async function copy() {
  const edits = (await getText("/api/edits")).split("\n").filter(Boolean);
  const area = part("text").querySelector("textarea");
  area.value = edits.map(edit => "--set " + quote(edit)).join(" ");
  part("text").showModal();
  area.select();
}

function togglePixels() { part("exact").setAttribute("aria-pressed", picture.toggleExact()); }

part("undo").onclick = () => act("/api/undo");
part("redo").onclick = () => act("/api/redo");
part("copy").onclick = copy;
part("pin").onclick = picture.pin;
part("exact").onclick = togglePixels;
part("news-merge").onclick = () => act("/api/reload?keep=1");
part("news-drop").onclick = () => act("/api/reload");

document.onkeydown = event => {
  const is_text = event.target.matches("input[type=text], input[type=search], textarea, select");
  const key = event.key.toLowerCase();
  if ((event.ctrlKey || event.metaKey) && key === "z") {
    event.preventDefault();
    act(event.shiftKey ? "/api/redo" : "/api/undo");
  } else if (!is_text && !event.ctrlKey && key === "p") picture.pin();
  else if (!is_text && !event.ctrlKey && key === "1") togglePixels();
  else if (!is_text && !event.ctrlKey && key === "/") {
    event.preventDefault();
    part("find").focus();
  }
};

// ---- Start ----

on("edit", (keys, answer) => {
  showRefusal(answer.refusal);
  if ("edit" in answer) showDocument(answer);
});
on("fault", showRefusal);
on("picture", (state, pixels) => {
  if (pixels) picture.draw(state, pixels);
  showState(state);
  showDocument(state);
  controls.followNumber(state.edit);
});

try {
  await loadSchema();
  await controls.start();
  record.ready = true;
  follow();
} catch (fault) {
  showRefusal(fault.message);
}
