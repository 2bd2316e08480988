// SPDX-License-Identifier: Apache-2.0
// The hand: camera and sun by pointer, wheel and keyboard.

import * as aim from "./aim.js";
import { add, getAxes, getCamera, getPoint, length, setCamera, subtract, turn } from "./camera.js";
import { values } from "./keys.js";
import { getPixel, getSize, getValues, readOut } from "./picture.js";
import * as region from "./region.js";
import { beginGesture, record, set, setAll, setOnce } from "./server.js";
import { parseNumber, printNumber, printPoint } from "./values.js";

const canvas = document.getElementById("picture");

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

// ---- Sun ----

const minute_ms = 60000;

// Moves the sun: by the time of day where the scene gives one, else by its angles.
function moveSun(from, x, y) {
  if (from.time) return set("sun.time", new Date(from.time + Math.round(x / 2) * minute_ms).toISOString().slice(0, 16) + "Z");
  setAll({
    "sun.azimuth": printNumber((from.azimuth + x * 0.2 + 360) % 360, "deg"),
    "sun.elevation": printNumber(Math.min(90, Math.max(-18, from.elevation - y * 0.15)), "deg"),
  });
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
let pointed = null; // pixel under the pointer
const fingers = new Map(); // pointers of a touch, by their numbers

// Two fingers: their distance dollies, their middle pans.
function beginPinch() {
  const [a, b] = fingers.values();
  drag = { camera: getCamera(), apart: Math.max(1, Math.hypot(a.x - b.x, a.y - b.y)), x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
}

function pinch() {
  const [a, b] = fingers.values(), apart = Math.max(1, Math.hypot(a.x - b.x, a.y - b.y));
  const panned = moves.pan(drag.camera, (a.x + b.x) / 2 - drag.x, (a.y + b.y) / 2 - drag.y);
  setCamera(dolly(panned, drag.apart / apart));
}

canvas.onpointerdown = event => {
  canvas.setPointerCapture(event.pointerId);
  canvas.focus();
  if (region.beginDrag(event) || aim.beginDrag(event)) return;
  beginGesture();
  if (event.pointerType === "touch") fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  if (fingers.size === 2) return beginPinch();
  drag = { x: event.clientX, y: event.clientY, move: chooseMove(event), sun: event.ctrlKey && getSun(), camera: getCamera() };
};
canvas.onpointermove = event => {
  pointed = getPixel(event);
  if (region.drag(event) || aim.drag(event)) return;
  if (fingers.has(event.pointerId)) fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  if (fingers.size === 2 && drag?.apart) return pinch();
  if (!drag) return readOut(event);
  const x = event.clientX - drag.x, y = event.clientY - drag.y;
  if (drag.sun) moveSun(drag.sun, x, y);
  else setCamera(drag.move(drag.camera, x, y));
};
canvas.onpointerup = canvas.onpointercancel = event => {
  region.endDrag();
  aim.endDrag();
  fingers.delete(event.pointerId);
  drag = null;
};
canvas.onpointerleave = () => { pointed = null; };
canvas.oncontextmenu = event => event.preventDefault();

let last_wheel = 0;

canvas.onwheel = event => {
  event.preventDefault();
  if (event.timeStamp - last_wheel > 400) beginGesture();
  last_wheel = event.timeStamp;
  setCamera(dolly(getCamera(), Math.exp(event.deltaY * 0.001)));
};

canvas.ondblclick = async event => {
  const pixel = getPixel(event), { Z } = await getValues(pixel).catch(() => ({}));
  const point = getPoint(pixel, Z, canvas.width, canvas.height);
  if (point) setOnce("camera.look_at", printPoint(point));
};

const flights = { w: [0, 1, 0], s: [0, -1, 0], a: [-1, 0, 0], d: [1, 0, 0], e: [0, 0, 1], q: [0, 0, -1] };
const turns = { ArrowLeft: [-10, 0], ArrowRight: [10, 0], ArrowUp: [0, 10], ArrowDown: [0, -10] };

const aims = { l: "sun", f: "focus" };

function changeExposure(by) {
  const now = parseNumber(values["output.exposure"]);
  const value = printNumber((Number.isNaN(now) ? record.state.stops : now) + by, "EV");
  values["output.exposure"] = value;
  set("output.exposure", value);
}

canvas.onkeydown = event => {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const is_known = key in flights || key in turns || key in aims || key === "[" || key === "]";
  if (!is_known || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  if (key in aims) return aim.aim(aims[key], pointed ?? getSize().map(size => size >> 1));
  if (!event.repeat) beginGesture();
  if (key in flights) setCamera(fly(getCamera(), flights[key]));
  else if (key in turns) setCamera(moves.orbit(getCamera(), ...turns[key]));
  else changeExposure(key === "]" ? 1 / 3 : -1 / 3);
};
