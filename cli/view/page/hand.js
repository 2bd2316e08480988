// SPDX-License-Identifier: Apache-2.0
// The hand: camera and sun by pointer, wheel and keyboard.

import { values } from "./keys.js";
import { getPixel, getValues, readOut } from "./picture.js";
import { beginGesture, record, set, setOnce } from "./server.js";
import { parseList, parseNumber, printNumber, printPoint } from "./values.js";

const canvas = document.getElementById("picture");

// ---- Vectors ----

const add = (a, b, scale = 1) => a.map((x, i) => x + scale * b[i]);
const subtract = (a, b) => add(a, b, -1);
const length = a => Math.hypot(...a);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const normalize = a => a.map(x => x / (length(a) || 1));

// Direction by azimuth and elevation, radians, and back.
const toDirection = ([azimuth, elevation]) =>
  [Math.cos(elevation) * Math.cos(azimuth), Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation)];
const toAngles = a => [Math.atan2(a[1], a[0]), Math.atan2(a[2], Math.hypot(a[0], a[1]))];
const turn = (a, azimuth, elevation) => {
  const [before_azimuth, before_elevation] = toAngles(a);
  const limit = 1.55;
  return toDirection([before_azimuth + azimuth, Math.min(limit, Math.max(-limit, before_elevation + elevation))]).map(x => x * length(a));
};

// ---- Camera ----

function getCamera() { return { eye: parseList(values["camera.position"]), target: parseList(values["camera.look_at"]) }; }

// The keys in force, before the server has them described anew.
function setCamera({ eye, target }) {
  const moved = { "camera.position": printPoint(eye), "camera.look_at": printPoint(target) };
  for (const [key, value] of Object.entries(moved))
    if (values[key] !== value) {
      values[key] = value;
      set(key, value);
    }
}

function getAxes({ eye, target }) {
  const ahead = normalize(subtract(target, eye)), right = normalize(cross(ahead, [0, 0, 1]));
  return { ahead, right, up: cross(right, ahead) };
}

const speed = 0.004; // radians a pixel

const moves = {
  orbit: (camera, x, y) => ({ ...camera, eye: add(camera.target, turn(subtract(camera.eye, camera.target), -x * speed, y * speed)) }),
  look: (camera, x, y) => ({ ...camera, target: add(camera.eye, turn(subtract(camera.target, camera.eye), -x * speed, -y * speed)) }),
  pan: (camera, x, y) => {
    const { right, up } = getAxes(camera), step = length(subtract(camera.target, camera.eye)) / canvas.clientWidth;
    const by = add(right.map(a => -a * x * step), up, y * step);
    return { eye: add(camera.eye, by), target: add(camera.target, by) };
  },
};

function dolly(camera, factor) {
  return { ...camera, eye: add(camera.target, subtract(camera.eye, camera.target), factor) };
}

function fly(camera, [right_steps, ahead_steps, up_steps]) {
  const { right, ahead } = getAxes(camera), step = 0.02 * length(subtract(camera.target, camera.eye));
  const by = add(add(right.map(x => x * right_steps * step), ahead, ahead_steps * step), [0, 0, 1], up_steps * step);
  return { eye: add(camera.eye, by), target: add(camera.target, by) };
}

// Point of the world under a pixel, by its depth along the camera's axis; null where there is nothing.
async function getPoint(pixel) {
  const { Z } = await getValues(pixel), camera = getCamera(), { ahead, right, up } = getAxes(camera);
  if (Z == null) return null;
  const lens = parseNumber(values["camera.focal_length"]), fov = parseNumber(values["camera.fov"]) * Math.PI / 180;
  const half_width = Number.isNaN(lens) ? Math.tan(fov / 2) : parseNumber(values["camera.sensor"]) / 2 / lens;
  const x = (2 * (pixel[0] + 0.5) / canvas.width - 1) * half_width;
  const y = (1 - 2 * (pixel[1] + 0.5) / canvas.height) * half_width * canvas.height / canvas.width;
  return add(add(add(camera.eye, ahead, Z), right, x * Z), up, y * Z);
}

// ---- Sun ----

const minute_ms = 60000;

// Moves the sun: by the time of day where the scene gives one, else by its angles.
function moveSun(from, x, y) {
  if (from.time) return set("sun.time", new Date(from.time + Math.round(x / 2) * minute_ms).toISOString().slice(0, 16) + "Z");
  set("sun.azimuth", printNumber((from.azimuth + x * 0.2 + 360) % 360, "deg"));
  set("sun.elevation", printNumber(Math.min(90, Math.max(-18, from.elevation - y * 0.15)), "deg"));
}

function getSun() {
  const time = Date.parse(values["sun.time"] ?? "");
  return { time: Number.isNaN(time) ? 0 : time, azimuth: parseNumber(values["sun.azimuth"]), elevation: parseNumber(values["sun.elevation"]) };
}

// ---- Pointer and keyboard ----

function chooseMove(event) {
  if (event.button === 1 || event.shiftKey) return moves.pan;
  return event.button === 2 ? moves.look : moves.orbit;
}

let drag = null;

canvas.onpointerdown = event => {
  canvas.setPointerCapture(event.pointerId);
  canvas.focus();
  beginGesture();
  drag = { x: event.clientX, y: event.clientY, move: chooseMove(event), sun: event.ctrlKey && getSun(), camera: getCamera() };
};
canvas.onpointermove = event => {
  if (!drag) return readOut(event);
  const x = event.clientX - drag.x, y = event.clientY - drag.y;
  if (drag.sun) moveSun(drag.sun, x, y);
  else setCamera(drag.move(drag.camera, x, y));
};
canvas.onpointerup = canvas.onpointercancel = () => { drag = null; };
canvas.oncontextmenu = event => event.preventDefault();

let last_wheel = 0;

canvas.onwheel = event => {
  event.preventDefault();
  if (event.timeStamp - last_wheel > 400) beginGesture();
  last_wheel = event.timeStamp;
  setCamera(dolly(getCamera(), Math.exp(event.deltaY * 0.001)));
};

canvas.ondblclick = async event => {
  const point = await getPoint(getPixel(event)).catch(() => null);
  if (point) setOnce("camera.look_at", printPoint(point));
};

const flights = { w: [0, 1, 0], s: [0, -1, 0], a: [-1, 0, 0], d: [1, 0, 0], e: [0, 0, 1], q: [0, 0, -1] };
const turns = { ArrowLeft: [-10, 0], ArrowRight: [10, 0], ArrowUp: [0, 10], ArrowDown: [0, -10] };

function changeExposure(by) {
  const now = parseNumber(values["output.exposure"]);
  const value = printNumber((Number.isNaN(now) ? record.state.stops : now) + by, "EV");
  values["output.exposure"] = value;
  set("output.exposure", value);
}

canvas.onkeydown = event => {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const is_known = key in flights || key in turns || key === "[" || key === "]";
  if (!is_known || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  if (!event.repeat) beginGesture();
  if (key in flights) setCamera(fly(getCamera(), flights[key]));
  else if (key in turns) setCamera(moves.orbit(getCamera(), ...turns[key]));
  else changeExposure(key === "]" ? 1 / 3 : -1 / 3);
};
