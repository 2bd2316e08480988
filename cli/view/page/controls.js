// SPDX-License-Identifier: Apache-2.0
// Rows of keys: slider, choice or text, by the schema.

import { edits, getChoices, getEntry, given, hasSlider, listBasics, loadValues, numbers, schema, values } from "./keys.js";
import { act, beginGesture, getEditNumber, on, set, setOnce } from "./server.js";
import { printNumber, tidy, unquote } from "./values.js";

const groups = document.getElementById("groups"), search = document.getElementById("find");
const rows = new Map(); // key: { element, show(value) }

function make(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
}

function getId(key) { return "key-" + key.replace(/[^a-z0-9]+/gi, "-"); }

function makeChoice(key, choices) {
  const select = make("select", { id: getId(key), className: "wide" }, ...choices.map(choice => make("option", { textContent: choice })));
  select.onchange = () => setOnce(key, select.value);
  return [[select], value => { select.value = unquote(value); }];
}

function makeText(key) {
  const input = make("input", { type: "text", id: getId(key), spellcheck: false, autocomplete: "off" });
  input.onchange = () => setOnce(key, input.value);
  return input;
}

// A slider beside the text.
function makeSlider(key, entry) {
  const text = makeText(key), steps = 1000, { soft_min: least, soft_max: greatest } = entry;
  const is_logarithmic = entry.scale === "log" && least > 0;
  const step = !entry.step ? "any" : steps * (is_logarithmic ? Math.log1p(entry.step) / Math.log(greatest / least) : entry.step / (greatest - least));
  const slider = make("input", { type: "range", min: 0, max: steps, step, ariaLabel: key + ", slider" });
  const toValue = at => is_logarithmic ? least * (greatest / least) ** at : least + (greatest - least) * at;
  const toPlace = value => is_logarithmic ? Math.log(value / least) / Math.log(greatest / least) : (value - least) / (greatest - least);
  const show = value => {
    text.value = tidy(value);
    if (key in numbers) slider.value = steps * toPlace(numbers[key]);
  };
  slider.onpointerdown = beginGesture;
  slider.onkeydown = event => { if (!event.repeat) beginGesture(); };
  slider.oninput = () => {
    text.value = printNumber(toValue(slider.value / steps), entry.unit);
    set(key, text.value);
  };
  return [[slider, text], show];
}

function makeControl(key, entry) {
  const choices = getChoices(entry);
  if (choices) return makeChoice(key, choices);
  if (hasSlider(entry)) return makeSlider(key, entry);
  const input = makeText(key);
  input.className = "wide";
  return [[input], value => { input.value = tidy(value); }];
}

// Keys that the scene states itself are marked, and those that differ from its file.
function showOrigin(key, element) {
  element.classList.toggle("edited", edits.has(key));
  element.classList.toggle("given", Boolean(given[key]));
}

function makeRow(key) {
  const entry = getEntry(key);
  if (!entry || entry.type === "section" || entry.type === "list" || rows.has(key)) return null;
  const [controls, show] = makeControl(key, entry);
  const label = make("label", { textContent: entry.label, htmlFor: getId(key) });
  label.title = `${key}: ${entry.values}\n${entry.meaning}` + (entry.default ? `\ndefault: ${entry.default}` : "");
  const is_file = entry.type === "file";
  if (is_file) for (const control of controls) control.readOnly = true;
  const reset = make("button", { className: "reset", textContent: "×", title: "back to the default", ariaLabel: key + ": back to the default" });
  reset.onclick = () => act("/api/unset", key);
  label.ondblclick = () => act("/api/unset", key);
  const element = make("div", { className: "row" }, label, ...controls, reset);
  element.dataset.key = key;
  rows.set(key, { element, show, controls });
  show(values[key]);
  showOrigin(key, element);
  return element;
}

function addGroup(name, keys, is_open) {
  const made = keys.map(makeRow).filter(Boolean);
  if (made.length) groups.append(make("details", { open: is_open }, make("summary", { textContent: name }), ...made));
}

// Keys that the scene could have, and that are not in force.
function listAbsent() {
  return Object.keys(schema).filter(key => !key.includes("[]") && !(key in values) && schema[key].type !== "tracks");
}

// Makes all rows anew, as after a change of the keys that are in force.
function rebuild() {
  const is_open = new Map([...groups.children].map(group => [group.firstChild.textContent, group.open]));
  groups.replaceChildren();
  rows.clear();
  for (const [name, keys] of listBasics(cloud)) addGroup(name, keys, is_open.get(name) ?? true);
  const sections = Object.groupBy(Object.keys(values), key => key.match(/^[a-z_]+(\[\d+\])?/)[0]);
  for (const [name, keys] of Object.entries(sections)) addGroup(name, keys, is_open.get(name) ?? false);
  addGroup("keys that are not in force", listAbsent(), false);
  filter();
}

let cloud = 0;

// Chooses the cloud whose keys come first.
export function chooseCloud(index) {
  if (index === cloud) return;
  cloud = index;
  rebuild();
}

const watchers = [];

// Calls a function whenever the values have changed.
export function onValues(watcher) { watchers.push(watcher); }

// Shows the values in force; a field that is being edited keeps its text. Values that were described before the last
// edit are left.
async function refresh() {
  const before = Object.keys(values).join(), number = getEditNumber();
  if (!await loadValues(() => getEditNumber() === number)) return refreshSoon();
  for (const watcher of watchers) watcher();
  if (Object.keys(values).join() !== before) return rebuild();
  for (const [key, row] of rows) {
    showOrigin(key, row.element);
    if (!row.element.classList.contains("bad") || !row.controls.includes(document.activeElement)) row.show(values[key]);
  }
}

function filter() {
  const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
  for (const { element } of rows.values()) {
    const entry = getEntry(element.dataset.key), text = (element.dataset.key + " " + entry.meaning).toLowerCase();
    element.hidden = !words.every(word => text.includes(word));
    if (words.length && !element.hidden) element.parentElement.open = true;
  }
  for (const group of groups.children) group.hidden = ![...group.querySelectorAll(".row")].some(row => !row.hidden);
}

// Marks the fields of an edit: edited, or refused with the reason.
function mark(keys, refusal) {
  for (const key of keys) {
    const row = rows.get(key);
    if (!row) continue;
    row.element.querySelector(".reason")?.remove();
    row.element.classList.toggle("bad", Boolean(refusal));
    for (const control of row.controls) control.ariaInvalid = refusal ? "true" : "false";
    if (refusal) row.element.append(make("p", { className: "reason", textContent: refusal }));
  }
}

let timer = 0, number_shown = 0;

function refreshSoon() {
  clearTimeout(timer);
  timer = setTimeout(refresh, 200);
}

// Values may change by the edit of another key, of another page, or of the file.
export function followNumber(number) {
  if (number === number_shown) return;
  number_shown = number;
  refreshSoon();
}

export async function start() {
  await loadValues();
  for (const watcher of watchers) watcher();
  rebuild();
  search.oninput = filter;
  on("edit", (keys, answer) => mark(keys, answer.refusal));
}
