// SPDX-License-Identifier: Apache-2.0
// Vectors, and the camera by its keys.

import { values } from "./keys.js";
import { setAll } from "./server.js";
import { parseList, parseNumber, printPoint, unquote } from "./values.js";

// ---- Vectors ----

export const add = (a, b, scale = 1) => a.map((x, i) => x + scale * b[i]);
export const subtract = (a, b) => add(a, b, -1);
export const length = a => Math.hypot(...a);
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const normalize = a => a.map(x => x / (length(a) || 1));

// Direction by azimuth and elevation, radians, and back.
export const toDirection = ([azimuth, elevation]) =>
  [Math.cos(elevation) * Math.cos(azimuth), Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation)];
export const toAngles = a => [Math.atan2(a[1], a[0]), Math.atan2(a[2], Math.hypot(a[0], a[1]))];
export const turn = (a, azimuth, elevation) => {
  const [before_azimuth, before_elevation] = toAngles(a);
  const limit = 1.55;
  return toDirection([before_azimuth + azimuth, Math.min(limit, Math.max(-limit, before_elevation + elevation))]).map(x => x * length(a));
};

// ---- Camera ----

export function getCamera() { return { eye: parseList(values["camera.position"]), target: parseList(values["camera.look_at"]) }; }

// The keys in force, before the server has them described anew.
export function setCamera({ eye, target }) {
  const moved = { "camera.position": printPoint(eye), "camera.look_at": printPoint(target) };
  const changed = Object.entries(moved).filter(([key, value]) => values[key] !== value);
  Object.assign(values, Object.fromEntries(changed));
  if (changed.length) setAll(Object.fromEntries(changed));
}

export function getAxes({ eye, target }) {
  const ahead = normalize(subtract(target, eye)), right = normalize(cross(ahead, [0, 0, 1]));
  return { ahead, right, up: cross(right, ahead) };
}

// Half of the picture's width at a depth of 1.
function getHalfWidth() {
  const lens = parseNumber(values["camera.focal_length"]), fov = parseNumber(values["camera.fov"]) * Math.PI / 180;
  return Number.isNaN(lens) ? Math.tan(fov / 2) : parseNumber(values["camera.sensor"]) / 2 / lens;
}

// Ray under a pixel of a picture, to a depth of 1 along the camera's axis; null: the camera is not perspective.
export function getRay([column, row], width, height) {
  if (unquote(values["camera.kind"] ?? "perspective") !== "perspective") return null;
  const { ahead, right, up } = getAxes(getCamera()), half_width = getHalfWidth();
  const roll = (parseNumber(values["camera.roll"]) || 0) * Math.PI / 180;
  const [aside, above] = parseList(values["camera.shift"] ?? "[0, 0]");
  const x = (2 * (column + 0.5) / width - 1 + 2 * aside) * half_width;
  const y = ((1 - 2 * (row + 0.5) / height) * height / width + 2 * above) * half_width;
  const [cos, sin] = [Math.cos(roll), Math.sin(roll)];
  return add(add(ahead, right, x * cos + y * sin), up, y * cos - x * sin);
}

// Point of the world under a pixel, by its depth along the camera's axis; null where there is nothing.
export function getPoint(pixel, depth, width, height) {
  const ray = getRay(pixel, width, height);
  return ray && depth != null ? add(getCamera().eye, ray, depth) : null;
}
