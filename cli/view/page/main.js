// SPDX-License-Identifier: Apache-2.0
// The page: its parts, its toolbar and its bar.

import * as bookmarks from "./bookmarks.js";
import * as controls from "./controls.js";
import "./dome.js";
import "./hand.js";
import { countClouds, edits, file, getChoices, getEntry, loadSchema, numbers, values } from "./keys.js";
import * as picture from "./picture.js";
import * as plan from "./plan.js";
import * as region from "./region.js";
import { act, beginGesture, follow, getJson, on, post, record, setAll } from "./server.js";
import * as timeline from "./timeline.js";
import * as variants from "./variants.js";
import { parseWords, printShare, unquote } from "./values.js";

const part = id => document.getElementById(id);

// ---- Bar ----

const levels = ["first pixels", "all pixels", "refined"];

function showState(state) {
  const level = levels[Math.min(state.level, 2)];
  const seconds = state.seconds == null ? "" : `, ${state.seconds.toFixed(2)} s`;
  part("level").textContent = state.number ? `${level}, ${state.samples} ${state.samples === 1 ? "sample" : "samples"} a pixel${seconds}` : "no picture yet";
  part("progress").value = state.fraction ?? 0;
  part("stage-name").textContent = state.stage;
  part("error").textContent = `error ${printShare(state.error)} (noise ${printShare(state.noise)}, bias ${printShare(state.bias)}` +
    (state.bias_source === "unknown" ? ")" : `, ${state.bias_source})`);
  part("range").textContent = state.least == null ? "" : `${state.channel}: ${state.least.toPrecision(3)} (blue) to ${state.greatest.toPrecision(3)} (yellow)`;
  part("message").textContent = part("message").title = state.file_fault || state.message;
}

let hidden = []; // indices of clouds that are off

function showDocument(state) {
  if (String(hidden) !== String(state.hidden)) hidden = state.hidden, showClouds();
  part("undo").disabled = !state.undo;
  part("redo").disabled = !state.redo;
  part("news").hidden = !state.news;
  document.title = (state.edited ? "• " : "") + "nephos view";
}

function showRefusal(text) { part("refusal").textContent = text; }

// ---- Toolbar ----

// A word for the shell.
function quote(text) { return "'" + text.replaceAll("'", "'\\''") + "'"; }

function showText(text) {
  const area = part("text").querySelector("textarea");
  area.value = text;
  part("text").showModal();
  area.select();
}

function showCommand() {
  const absent = [...edits].filter(([, value]) => value === null).map(([key]) => key);
  if (absent.length) return showText(`No option takes a key away, and these are: ${absent.join(", ")}.\nSave a copy, and render it.`);
  const sets = [...edits].map(([key, value]) => "--set " + quote(`${key}=${value}`));
  showText(["nephos render", quote(file), ...sets, "--samples " + record.state.samples].join(" "));
}

async function save(path, body) {
  const answer = await post(path, body);
  showRefusal(answer.refusal);
  if (!answer.refusal) part("note").textContent = "saved: " + answer.file;
}

let offered = ""; // kind of the variants that are shown

async function toggleVariants(kind, offer) {
  offered = offered === kind ? "" : kind;
  for (const id of ["seeds", "presets"]) part(id).setAttribute("aria-pressed", id === offered);
  variants.close();
  if (offered) showRefusal(await offer(Number(part("cloud").value)));
}

function togglePixels() { part("exact").setAttribute("aria-pressed", picture.toggleExact()); }

const buttons = {
  undo: () => act("/api/undo"),
  redo: () => act("/api/redo"),
  save: () => save("/api/save"),
  "save-copy": () => save("/api/save_copy"),
  copy: showCommand,
  pin: picture.pin,
  exact: togglePixels,
  mark: bookmarks.add,
  "save-png": () => save("/api/save_picture", "png"),
  "save-exr": () => save("/api/save_picture", "exr"),
  "news-merge": () => act("/api/reload?keep=1"),
  "news-drop": () => act("/api/reload"),
  "add-cloud": () => act("/api/add_cloud", part("preset").value),
  "remove-cloud": () => act("/api/unset", `clouds[${part("cloud").value}]`),
  "toggle-cloud": () => act("/api/toggle_cloud?cloud=" + part("cloud").value),
  seeds: () => toggleVariants("seeds", variants.offerSeeds),
  presets: () => toggleVariants("presets", variants.offerPresets),
};
for (const [id, action] of Object.entries(buttons)) part(id).onclick = action;

document.onkeydown = event => {
  const is_text = event.target.matches("input[type=text], input[type=search], textarea, select");
  const key = event.key.toLowerCase(), has_control = event.ctrlKey || event.metaKey;
  const action = has_control ? { z: event.shiftKey ? buttons.redo : buttons.undo, s: buttons.save }[key]
    : is_text ? null : { p: buttons.pin, r: region.toggle, 1: buttons.exact, "/": () => part("find").focus() }[key];
  if (!action) return;
  event.preventDefault();
  action();
};

// ---- Clouds and channels ----

function fill(select, entries, chosen) {
  const is_same = entries.length === select.options.length && entries.every(([value, text], i) => select.options[i].value === String(value) && select.options[i].text === text);
  if (!is_same) select.replaceChildren(...entries.map(([value, text]) => new Option(text, value)));
  select.value = chosen;
}

function showClouds() {
  const names = Array.from({ length: countClouds() }, (_, i) => [i, unquote(values[`clouds[${i}].name`]) + (hidden.includes(i) ? " (off)" : "")]);
  const last = Math.max(names.length - 1, 0), shown = part("cloud").options.length, is_added = shown > 0 && names.length > shown;
  const chosen = is_added ? last : Math.min(part("cloud").value || 0, last);
  fill(part("cloud"), names, chosen);
  for (const id of ["cloud", "remove-cloud", "toggle-cloud", "seeds", "presets"]) part(id).disabled = !names.length;
  part("toggle-cloud").setAttribute("aria-pressed", hidden.includes(chosen));
  fill(part("preset"), getChoices(getEntry("clouds[].bake.preset")).map(name => [name, name.replaceAll("_", " ")]), part("preset").value || "cumulus_mediocris");
  controls.chooseCloud(chosen);
  plan.choose(chosen);
}

part("cloud").onchange = () => {
  controls.chooseCloud(Number(part("cloud").value));
  plan.choose(Number(part("cloud").value));
};

// Channels that the picture has; the others of the schema are added to the scene when they are chosen.
async function showChannels() {
  const present = await getJson("/api/channels");
  const absent = [...getEntry("output.aovs").choices, "relative_error"].filter(name => !present.includes(name));
  const label = name => ({ standard_error: "error map: standard error", relative_error: "error map: share of the luminance", Z: "depth" })[name] ?? name.replaceAll("_", " ");
  const chosen = part("channel").value.replace(/^\+/, ""), is_present = !chosen || present.includes(chosen);
  fill(part("channel"), [["", "picture"], ...present.map(name => [name, label(name)]), ...absent.map(name => ["+" + name, label(name) + " (render)"])],
    is_present ? chosen : "+" + chosen);
}

// Adds a channel to those of the scene. An error takes two samples.
function addChannel(name) {
  const aov = name === "relative_error" ? "standard_error" : name;
  const has_error = ["standard_error", "variance"].includes(aov);
  const aovs = "[" + [...parseWords(values["output.aovs"]), aov].join(", ") + "]";
  beginGesture();
  setAll({ "output.aovs": aovs, ...(has_error && numbers["render.samples"] < 2 && { "render.samples": "2" }) });
}

part("channel").onchange = async () => {
  const chosen = part("channel").value, name = chosen.replace(/^\+/, "");
  if (chosen !== name) addChannel(name);
  await post("/api/show", name);
};

// ---- Start ----

let channels_of = -1; // generation of the picture whose channels are listed

controls.onValues(showClouds);
on("edit", (keys, answer) => {
  showRefusal(answer.refusal);
  part("note").textContent = answer.notice ?? "";
  if ("edit" in answer) showDocument(answer);
});
on("fault", showRefusal);
on("picture", (state, pixels) => {
  if (pixels) picture.draw(state, pixels);
  timeline.follow(state, pixels);
  showState(state);
  showDocument(state);
  variants.follow(state.variants);
  controls.followNumber(state.edit);
  if (state.complete && state.generation !== channels_of) {
    channels_of = state.generation;
    showChannels();
  }
});

try {
  await loadSchema();
  await controls.start();
  await timeline.start();
  record.ready = true;
  follow();
} catch (fault) {
  showRefusal(fault.message);
}
