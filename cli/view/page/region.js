// SPDX-License-Identifier: Apache-2.0
// A region of the picture that is rendered alone.

import { post } from "./server.js";

const canvas = document.getElementById("picture"), box = document.getElementById("region");
const button = document.getElementById("choose-region");
let is_choosing = false, begin = null, region = null;

function getShare(event) {
  const frame = canvas.getBoundingClientRect();
  return [(event.clientX - frame.left) / frame.width, (event.clientY - frame.top) / frame.height].map(x => Math.min(1, Math.max(0, x)));
}

function show() {
  box.hidden = !region;
  button.setAttribute("aria-pressed", Boolean(region) || is_choosing);
  canvas.style.cursor = is_choosing ? "crosshair" : "";
  if (!region) return;
  const [left, top, right, bottom] = region.map(x => 100 * x);
  Object.assign(box.style, { left: left + "%", top: top + "%", width: right - left + "%", height: bottom - top + "%" });
}

export function toggle() {
  if (region) {
    region = null;
    post("/api/region");
  } else {
    is_choosing = !is_choosing;
  }
  show();
}

// Takes a pointer that draws a region; false: none is being chosen.
export function beginDrag(event) {
  if (!is_choosing) return false;
  begin = getShare(event);
  return true;
}

export function drag(event) {
  if (!begin) return false;
  const end = getShare(event);
  region = [Math.min(begin[0], end[0]), Math.min(begin[1], end[1]), Math.max(begin[0], end[0]), Math.max(begin[1], end[1])];
  show();
  return true;
}

export function endDrag() {
  if (!begin) return;
  begin = null;
  is_choosing = false;
  if (region && (region[2] - region[0] < 0.01 || region[3] - region[1] < 0.01)) region = null;
  if (region) post("/api/region", region.map(x => x.toFixed(4)).join(" "));
  show();
}

button.onclick = toggle;
