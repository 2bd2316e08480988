// SPDX-License-Identifier: Apache-2.0
// The scene from above, north up: clouds and camera, which are moved by hand, and the map of a cloud's coverage under a
// brush.

import { onValues } from "./controls.js";
import { countClouds, numbers, values } from "./keys.js";
import { beginGesture, getBytes, post, set, tell } from "./server.js";
import { printNumber, unquote } from "./values.js";

const part = id => document.getElementById(id);
const plan = part("plan"), painter = plan.getContext("2d"), edge = 256;
let chosen = 0, is_painting = false;

// ---- Places ----

const pair = value => Array.isArray(value) ? [value[0], value[1]] : [value ?? 0, value ?? 0];

// Middle and extent of a cloud's field, metres; null: it has none that is known here.
function getField(index) {
  const key = `clouds[${index}].`, at = numbers[key + "position"], extent = numbers[key + "bake.extent"];
  if (extent == null && !at) return null;
  return { key, has_position: Boolean(at), middle: at ? [at[0], at[1]] : pair(numbers[key + "bake.center"]), extent: pair(extent ?? 1000) };
}

function listFields() { return Array.from({ length: countClouds() }, (_, i) => getField(i)); }

let frame = { middle: [0, 0], scale: 0.01 }; // pixels a metre

// Shows all clouds and the camera; while its map is painted, the chosen cloud alone.
function fit(fields) {
  const camera = { middle: pair(numbers["camera.position"]), extent: [0, 0] };
  const shown = is_painting && fields[chosen] ? [fields[chosen]] : [camera, ...fields.filter(Boolean)];
  const low = [0, 1].map(k => Math.min(...shown.map(field => field.middle[k] - field.extent[k] / 2)));
  const high = [0, 1].map(k => Math.max(...shown.map(field => field.middle[k] + field.extent[k] / 2)));
  const across = Math.max(high[0] - low[0], high[1] - low[1], 100);
  frame = { middle: [0, 1].map(k => (low[k] + high[k]) / 2), scale: (plan.width - 24) / across };
}

const toPixel = ([x, y]) => [plan.width / 2 + (x - frame.middle[0]) * frame.scale, plan.height / 2 - (y - frame.middle[1]) * frame.scale];
const toWorld = ([x, y]) => [frame.middle[0] + (x - plan.width / 2) / frame.scale, frame.middle[1] - (y - plan.height / 2) / frame.scale];

// Share of a field's extent, from its north-western corner.
const toShare = (field, [x, y]) => [(x - field.middle[0]) / field.extent[0] + 0.5, 0.5 - (y - field.middle[1]) / field.extent[1]];

// ---- Drawing ----

let map = null; // coverage of the chosen cloud, a byte a pixel; null: unknown
const map_canvas = document.createElement("canvas");
map_canvas.width = map_canvas.height = edge;

function drawMap() {
  const image = new ImageData(edge, edge);
  map.forEach((value, i) => image.data.set([value, value, Math.min(255, value + 40), 255], 4 * i));
  map_canvas.getContext("2d").putImageData(image, 0, 0);
}

function drawCamera() {
  const eye = numbers["camera.position"], target = numbers["camera.look_at"];
  if (!eye || !target) return;
  const [x, y] = toPixel(eye), turn = Math.atan2(-(target[1] - eye[1]), target[0] - eye[0]);
  painter.fillStyle = "#7fb8ff";
  painter.beginPath();
  for (const [length, aside] of [[9, 0], [-5, 6], [-5, -6]])
    painter.lineTo(x + length * Math.cos(turn) - aside * Math.sin(turn), y + length * Math.sin(turn) + aside * Math.cos(turn));
  painter.fill();
}

let brush = null; // place of the brush, pixels

function draw() {
  const fields = listFields();
  painter.clearRect(0, 0, plan.width, plan.height);
  fields.forEach((field, i) => {
    if (!field) return;
    const [x, y] = toPixel([field.middle[0] - field.extent[0] / 2, field.middle[1] + field.extent[1] / 2]);
    const size = field.extent.map(length => Math.max(2, length * frame.scale));
    if (i === chosen && map) painter.drawImage(map_canvas, x, y, ...size);
    painter.strokeStyle = i === chosen ? "#ffcb6b" : "#b4b8be";
    painter.strokeRect(x, y, ...size);
  });
  drawCamera();
  if (!is_painting || !brush || !fields[chosen]) return;
  painter.strokeStyle = "#ff9a92";
  painter.beginPath();
  painter.ellipse(...brush, ...fields[chosen].extent.map(length => Number(part("brush-size").value) * length * frame.scale), 0, 0, 2 * Math.PI);
  painter.stroke();
}

function describe() {
  const field = getField(chosen), name = unquote(values[`clouds[${chosen}].name`]);
  part("plan-text").textContent = !field ? "no cloud with a place is chosen"
    : `${name}: ${field.extent.map(x => (x / 1000).toPrecision(3)).join(" × ")} km, its middle at ${field.middle.map(x => (x / 1000).toFixed(2)).join(", ")} km`;
}

// ---- The map of the chosen cloud ----

let loaded = "";

async function loadMap(is_forced) {
  const key = `${chosen} ${values[`clouds[${chosen}].bake.map.image`] ?? values[`clouds[${chosen}].bake.coverage`]}`;
  if (key === loaded && !is_forced) return;
  loaded = key;
  map = `clouds[${chosen}].bake.preset` in values ? await getBytes("/api/map?cloud=" + chosen).catch(() => null) : null;
  if (map) drawMap();
  draw();
}

// ---- Brush ----

const dabs = []; // that wait for the request under way
let is_sending = false, stroke = 0;

async function send() {
  if (is_sending) return;
  is_sending = true;
  while (dabs.length) {
    const body = dabs.splice(0, 400).map(dab => dab.map(x => x.toFixed(5)).join(" ")).join("\n");
    tell("edit", [], await post(`/api/paint?cloud=${chosen}&gesture=${stroke}`, body));
  }
  is_sending = false;
}

// The brush of view_map.c, on the copy that is shown.
function paintCopy([x, y, radius, strength, coverage]) {
  const reach = Math.max(radius * edge, 0.5);
  for (let row = Math.max(0, Math.floor(y * edge - reach)); row < Math.min(edge, y * edge + reach); row++)
    for (let column = Math.max(0, Math.floor(x * edge - reach)); column < Math.min(edge, x * edge + reach); column++) {
      const away = Math.hypot(column + 0.5 - x * edge, row + 0.5 - y * edge) / reach, i = row * edge + column;
      if (away < 1) map[i] += strength * (1 - away * away) ** 2 * (255 * coverage - map[i]);
    }
  drawMap();
}

function dab(pixel) {
  const field = getField(chosen);
  if (!field || !map) return;
  const made = [...toShare(field, toWorld(pixel)), ...["brush-size", "brush-flow", "brush-cover"].map(id => Number(part(id).value))];
  paintCopy(made);
  dabs.push(made);
  send();
}

part("unpaint").onclick = async () => {
  tell("edit", [], await post("/api/unpaint?cloud=" + chosen));
  loadMap(true);
};

// ---- Pointer and keyboard ----

function moveCloud(field, [x, y]) {
  const to = [x, y].map(value => printNumber(value, "m", 6));
  if (field.has_position) set(field.key + "position", `[${to}, ${numbers[field.key + "position"][2]} m]`);
  else set(field.key + "bake.center", `[${to}]`);
  numbers[field.key + (field.has_position ? "position" : "bake.center")] = field.has_position ? [x, y, numbers[field.key + "position"][2]] : [x, y];
}

function moveCamera([x, y]) {
  const eye = numbers["camera.position"];
  numbers["camera.position"] = [x, y, eye[2]];
  set("camera.position", `[${printNumber(x, "m", 6)}, ${printNumber(y, "m", 6)}, ${eye[2]} m]`);
}

let drag = null;

function getPixel(event) {
  const box = plan.getBoundingClientRect();
  return [(event.clientX - box.left) * plan.width / box.width, (event.clientY - box.top) * plan.height / box.height];
}

// The camera, the chosen cloud, or else the first cloud under a pixel.
function pick(pixel) {
  const eye = numbers["camera.position"], world = toWorld(pixel);
  if (eye && Math.hypot(...toPixel(eye).map((x, k) => x - pixel[k])) < 10) return { from: eye, move: moveCamera };
  const fields = listFields(), has = field => field && [0, 1].every(k => Math.abs(world[k] - field.middle[k]) < field.extent[k] / 2);
  const field = has(fields[chosen]) ? fields[chosen] : fields.find(has);
  return field ? { from: field.middle, move: to => moveCloud(field, to) } : null;
}

plan.onpointerdown = event => {
  const pixel = getPixel(event);
  plan.setPointerCapture(event.pointerId);
  beginGesture();
  stroke = Date.now();
  drag = is_painting ? { is_stroke: true } : pick(pixel);
  if (drag) drag.world = toWorld(pixel);
  if (drag?.is_stroke) dab(pixel);
};
plan.onpointermove = event => {
  brush = getPixel(event);
  if (drag?.is_stroke) dab(brush);
  else if (drag) drag.move(toWorld(brush).map((x, k) => drag.from[k] + x - drag.world[k]));
  draw();
};
plan.onpointerup = plan.onpointercancel = () => { drag = null; };
plan.onpointerleave = () => {
  brush = null;
  draw();
};

const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

plan.onkeydown = event => {
  const step = steps[event.key], field = getField(chosen);
  if (!field || (!step && event.key !== " ")) return;
  event.preventDefault();
  if (!event.repeat) beginGesture();
  brush ??= toPixel(field.middle);
  if (!step && is_painting) stroke = Date.now(), dab(brush);
  else if (step && is_painting) brush = [brush[0] + 4 * step[0], brush[1] - 4 * step[1]];
  else if (step) moveCloud(field, field.middle.map((x, k) => x + 0.02 * field.extent[k] * step[k]));
  draw();
};

function setPainting(is_on) {
  is_painting = is_on;
  part("plan-paint").setAttribute("aria-pressed", is_on);
  part("plan-move").setAttribute("aria-pressed", !is_on);
  show();
}
part("plan-paint").onclick = () => setPainting(true);
part("plan-move").onclick = () => setPainting(false);

function show() {
  if (!drag) fit(listFields());
  describe();
  draw();
  if (!drag) loadMap();
}

export function choose(index) {
  chosen = index;
  show();
}

onValues(show);
