// SPDX-License-Identifier: Apache-2.0
// Rows of keys: slider, choice or text, by the schema.

import { basics, getChoices, getEntry, getRange, loadValues, values } from "./keys.js";
import { beginGesture, on, set, setOnce } from "./server.js";
import { parseNumber, printNumber, unquote } from "./values.js";

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

// A slider beside the text. Shift makes its steps ten times finer.
function makeSlider(key, entry, [least, greatest, is_logarithmic]) {
  const text = makeText(key), steps = 1000;
  const slider = make("input", { type: "range", min: 0, max: steps, step: "any", ariaLabel: key + ", slider" });
  const toValue = at => is_logarithmic ? least * (greatest / least) ** at : least + (greatest - least) * at;
  const toPlace = value => is_logarithmic ? Math.log(value / least) / Math.log(greatest / least) : (value - least) / (greatest - least);
  const show = value => {
    const number = parseNumber(value);
    text.value = value ?? "";
    if (!Number.isNaN(number)) slider.value = steps * toPlace(number);
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
  const choices = getChoices(entry), range = getRange(key);
  if (choices) return makeChoice(key, choices);
  if (range) return makeSlider(key, entry, range);
  const input = makeText(key);
  input.className = "wide";
  return [[input], value => { input.value = value ?? ""; }];
}

function makeRow(key) {
  const entry = getEntry(key);
  if (!entry || entry.type === "section" || entry.type === "list" || rows.has(key)) return null;
  const [controls, show] = makeControl(key, entry);
  const name = key.split(".").at(-1).replaceAll("_", " ");
  const label = make("label", { textContent: name, htmlFor: getId(key) });
  label.title = `${key}: ${entry.values}\n${entry.meaning}` + (entry.default ? `\ndefault: ${entry.default}` : "");
  const is_file = entry.type === "file";
  if (is_file) for (const control of controls) control.readOnly = true;
  const element = make("div", { className: "row" }, label, ...controls);
  element.dataset.key = key;
  rows.set(key, { element, show, controls });
  show(values[key]);
  return element;
}

function addGroup(name, keys, is_open) {
  const made = keys.filter(key => key in values).map(makeRow).filter(Boolean);
  if (made.length) groups.append(make("details", { open: is_open }, make("summary", { textContent: name }), ...made));
}

// Makes all rows anew, as after a change of the keys that are in force.
function rebuild() {
  const is_open = new Map([...groups.children].map(group => [group.firstChild.textContent, group.open]));
  groups.replaceChildren();
  rows.clear();
  for (const [name, keys] of basics) addGroup(name, keys, is_open.get(name) ?? true);
  const sections = Object.groupBy(Object.keys(values), key => key.match(/^[a-z_]+(\[\d+\])?/)[0]);
  for (const [name, keys] of Object.entries(sections)) addGroup(name, keys, is_open.get(name) ?? false);
  filter();
}

// Shows the values in force; a field that is being edited keeps its text.
async function refresh() {
  const before = Object.keys(values).join();
  await loadValues();
  if (Object.keys(values).join() !== before) return rebuild();
  for (const [key, row] of rows)
    if (!row.controls.includes(document.activeElement) || row.element.classList.contains("bad") === false) row.show(values[key]);
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
    else row.element.classList.add("edited");
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
  rebuild();
  search.oninput = filter;
  on("edit", (keys, answer) => mark(keys, answer.refusal));
}
