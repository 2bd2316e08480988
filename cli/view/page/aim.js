// SPDX-License-Identifier: Apache-2.0
// Sun and focus by a place in the picture.

import { getRay, toAngles } from "./camera.js";
import { values } from "./keys.js";
import { getPixel, getSize, getValues } from "./picture.js";
import { beginGesture, setAll, tell } from "./server.js";
import { printNumber } from "./values.js";

const degree = Math.PI / 180;
const f_stop = "2.8"; // aperture of a camera that had none

// Puts the sun behind a pixel.
function placeSun(pixel) {
  const ray = getRay(pixel, ...getSize());
  if (values["sun.time"]) return tell("fault", "the sun is placed by date and time: place it by its angles first");
  if (!ray) return tell("fault", "only a perspective camera can have the sun placed in its picture");
  const [turned, elevation] = toAngles(ray);
  const azimuth = (450 - turned / degree) % 360; // clockwise from north
  setAll({ "sun.azimuth": printNumber(azimuth, "deg", 5), "sun.elevation": printNumber(elevation / degree, "deg", 5) });
}

// Focuses at the depth of a pixel.
async function focusAt(pixel) {
  const { Z } = await getValues(pixel).catch(() => ({}));
  if (Z == null) return tell("fault", "there is nothing to focus on");
  const has_aperture = (values["camera.f_stop"] ?? "none") !== "none";
  setAll({ "camera.focus_distance": printNumber(Z, "m"), ...(!has_aperture && { "camera.f_stop": f_stop }) });
}

// ---- Pointer and keyboard ----

const aims = { sun: placeSun, focus: focusAt };
let chosen = null; // aim of the next drags
let is_dragging = false;

function choose(name) {
  chosen = chosen === name ? null : name;
  for (const each of Object.keys(aims)) document.getElementById("aim-" + each).setAttribute("aria-pressed", each === chosen);
}

for (const name of Object.keys(aims)) document.getElementById("aim-" + name).onclick = () => choose(name);

// Takes a pointer that places the sun or the focus; false: it moves the camera.
export function beginDrag(event) {
  const name = event.ctrlKey && event.shiftKey ? "sun" : chosen;
  if (!name || event.button) return false;
  beginGesture();
  is_dragging = name === "sun";
  aims[name](getPixel(event));
  return true;
}

export function drag(event) {
  if (is_dragging) placeSun(getPixel(event));
  return is_dragging;
}

export function endDrag() { is_dragging = false; }

// Aims at the pixel that the pointer was over last.
export function aim(name, pixel) {
  beginGesture();
  aims[name](pixel);
}
