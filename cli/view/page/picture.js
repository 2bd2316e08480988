// SPDX-License-Identifier: Apache-2.0
// The picture: its pixels at the right size, pinned pictures beside it, values under the pointer, its histogram.

import { getPoint } from "./camera.js";
import { getJson, post } from "./server.js";

const stage = document.getElementById("stage"), frame = document.getElementById("frame");
const canvas = document.getElementById("picture"), pinned = document.getElementById("pinned");
const pins = document.getElementById("pins"), wipe = document.getElementById("wipe");
const histogram = document.getElementById("histogram"), readout = document.getElementById("pixel");
const painter = canvas.getContext("2d");
let is_exact = false, wipe_share = 0.5;

export function draw(state, pixels) {
  if (canvas.width !== state.width || canvas.height !== state.height) {
    canvas.width = state.width;
    canvas.height = state.height;
    fit();
  }
  painter.putImageData(new ImageData(pixels, state.width, state.height), 0, 0);
  if (state.complete) drawHistogram(pixels);
}

// Fits the picture into the stage, or gives each of its pixels one of the screen.
export function fit() {
  const screen = window.devicePixelRatio;
  const room = Math.min((stage.clientWidth - 16) / canvas.width, (stage.clientHeight - 48) / canvas.height);
  const scale = is_exact ? 1 / screen : Math.max(room, 0.05);
  for (const each of [canvas, pinned]) {
    each.style.width = canvas.width * scale + "px";
    each.style.height = canvas.height * scale + "px";
    each.style.imageRendering = scale * screen >= 2 || is_exact ? "pixelated" : "auto";
  }
  placeWipe();
}

export function toggleExact() {
  is_exact = !is_exact;
  fit();
  return is_exact;
}

// ---- Pins ----

function placeWipe() {
  const left = wipe_share * canvas.clientWidth;
  wipe.style.left = left + "px";
  pinned.style.clipPath = `inset(0 0 0 ${left}px)`;
}

function compare(pin) {
  const is_on = pin && pin.getAttribute("aria-pressed") !== "true";
  for (const each of pins.children) each.setAttribute("aria-pressed", each === pin && is_on);
  pinned.hidden = wipe.hidden = !is_on;
  if (!is_on) return;
  pinned.width = pin.width;
  pinned.height = pin.height;
  pinned.getContext("2d").drawImage(pin, 0, 0);
  fit();
}

// Keeps the picture as it is, beside the last three.
export function pin() {
  const copy = document.createElement("canvas");
  copy.width = canvas.width;
  copy.height = canvas.height;
  copy.getContext("2d").drawImage(canvas, 0, 0);
  copy.tabIndex = 0;
  copy.setAttribute("role", "button");
  copy.setAttribute("aria-label", "pinned picture " + (pins.children.length + 1) + ": compare");
  copy.title = "left of the line: now; right of it: this picture";
  copy.onclick = () => compare(copy);
  copy.onkeydown = event => { if (event.key === "Enter" || event.key === " ") compare(copy); };
  if (pins.children.length === 4) pins.firstChild.remove();
  pins.append(copy);
  compare(copy);
}

wipe.onpointerdown = event => {
  wipe.setPointerCapture(event.pointerId);
  wipe.onpointermove = move => {
    const box = canvas.getBoundingClientRect();
    wipe_share = Math.min(1, Math.max(0, (move.clientX - box.left) / box.width));
    placeWipe();
  };
};
wipe.onpointerup = () => { wipe.onpointermove = null; };

// ---- Values ----

// Pixel of the picture below a pointer.
export function getPixel(event) {
  const box = canvas.getBoundingClientRect();
  return [(event.clientX - box.left) / box.width * canvas.width, (event.clientY - box.top) / box.height * canvas.height].map(Math.floor);
}

export function getSize() { return [canvas.width, canvas.height]; }

export async function getValues([x, y]) { return getJson(`/api/pixel?x=${x}&y=${y}`); }

let is_reading = false;

// Optical depth of the clouds: of its channel, or by their opacity.
function getOpticalDepth(values) {
  if (values.optical_depth != null) return values.optical_depth.toPrecision(3);
  return values.A == null ? "–" : values.A < 0.9999 ? Math.abs(Math.log(1 - values.A)).toPrecision(2) : "above 9";
}

const printKilometres = metres => (metres / 1000).toPrecision(3) + " km";

let focus_sent = 0;

// Names the place of the pointer, from which tiles are rendered outwards.
function sendFocus([x, y]) {
  if (performance.now() - focus_sent < 300) return;
  focus_sent = performance.now();
  const share = (at, size) => Math.min(1, Math.max(0, at / size)).toFixed(3);
  post("/api/focus", share(x, canvas.width) + " " + share(y, canvas.height)).catch(() => {});
}

export async function readOut(event) {
  sendFocus(getPixel(event));
  if (is_reading) return;
  is_reading = true;
  const pixel = getPixel(event), values = await getValues(pixel).catch(() => ({}));
  is_reading = false;
  if (!("R" in values)) return;
  const luminance = 0.2126 * values.R + 0.7152 * values.G + 0.0722 * values.B;
  const parts = [`${pixel[0]}, ${pixel[1]}`, [values.R, values.G, values.B].map(x => x.toPrecision(3)).join(" ") + " W/m²/sr/nm"];
  parts.push(`Y ${luminance.toPrecision(3)} = 2^${Math.log2(luminance).toFixed(1)}`, "τ " + getOpticalDepth(values));
  const point = getPoint(pixel, values.Z, canvas.width, canvas.height);
  if (point) parts.push(printKilometres(values.Z) + " deep", "at " + point.map(x => (x / 1000).toFixed(2)).join(", ") + " km");
  readout.textContent = parts.join(" · ");
}

function drawHistogram(pixels) {
  const counts = [0, 1, 2].map(() => new Uint32Array(64)), paint = histogram.getContext("2d");
  for (let i = 0; i < pixels.length; i += 4) for (let k = 0; k < 3; k++) counts[k][pixels[i + k] >> 2]++;
  const most = Math.max(...counts.flatMap(count => [...count.subarray(1, 63)]), 1);
  paint.globalCompositeOperation = "source-over";
  paint.clearRect(0, 0, histogram.width, histogram.height);
  paint.globalCompositeOperation = "lighter";
  counts.forEach((count, k) => {
    paint.fillStyle = ["#d33", "#3c3", "#46f"][k];
    count.forEach((n, i) => {
      const height = Math.min(1, n / most) * histogram.height;
      paint.fillRect(2 * i, histogram.height - height, 2, height);
    });
  });
}

new ResizeObserver(fit).observe(stage);
