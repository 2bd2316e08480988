// SPDX-License-Identifier: Apache-2.0
// Keys of the scene: the schema, and the values in force.

import { getJson } from "./server.js";

export const schema = {};
export let values = {};

// "clouds[0].bake.seed" is an instance of "clouds[].bake.seed".
export function getEntry(key) { return schema[key.replace(/\[\d+\]/g, "[]")]; }

export async function loadSchema() {
  for (const entry of (await getJson("/api/schema")).keys) schema[entry.key] = entry;
}

export async function loadValues() {
  values = (await getJson("/api/values")).values;
}

// Ranges of sliders, in the unit of the schema: least, greatest, and whether the scale is logarithmic.
const soft_ranges = {
  "sun.elevation": [-6, 90],
  "sun.azimuth": [0, 360],
  "output.exposure": [-6, 8],
  "camera.focal_length": [0.012, 0.3, true],
  "clouds[].extinction": [0.001, 2, true],
  "clouds[].bake.base": [100, 8000],
  "clouds[].bake.thickness": [50, 8000, true],
  "terrain.ridges.relief": [0, 4000],
  "atmosphere.mie_height": [200, 5000, true],
};

export function getRange(key) {
  const entry = getEntry(key);
  if (!entry || entry.count !== 1) return null;
  const plain = key.replace(/\[\d+\]/g, "[]");
  if (soft_ranges[plain]) return soft_ranges[plain];
  return entry.type === "real" && entry.unit === "" && entry.min === 0 && entry.max === 1 ? [0, 1] : null;
}

export function getChoices(entry) {
  if (entry.type === "choice") return entry.choices;
  return entry.type === "preset" ? entry.values.replace(/^one of /, "").split(", ") : null;
}

// Groups that come first, with their keys; the rest follows by section.
export const basics = [
  ["Sun", ["sun.elevation", "sun.azimuth", "sun.time"]],
  ["View", ["output.exposure", "output.view", "camera.focal_length", "camera.fov", "camera.position",
    "camera.look_at", "camera.roll"]],
  ["Cloud", ["bake.preset", "bake.seed", "bake.coverage", "bake.type", "bake.base", "bake.thickness",
    "bake.billowiness", "bake.erosion", "bake.wispiness", "extinction"].map(key => "clouds[0]." + key)],
  ["Ground", ["terrain.albedo", "terrain.ridges.relief", "terrain.ridges.seed"]],
  ["Quality", ["render.quality", "render.integrator", "render.samples"]],
];
