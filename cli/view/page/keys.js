// SPDX-License-Identifier: Apache-2.0
// Keys of the scene: the schema, and the values in force.

import { getJson } from "./server.js";

export const schema = {};
export let values = {};  // texts, as the scene has them
export let numbers = {}; // the numbers among them, in the unit of the schema
export let given = {};   // whether the scene states a key itself
export let file = "";        // path of the scene
export let edits = new Map(); // keys that differ from the file, null where they are taken away

// "clouds[0].bake.seed" is an instance of "clouds[].bake.seed".
export function getEntry(key) { return schema[key.replace(/\[\d+\]/g, "[]")]; }

export async function loadSchema() {
  for (const entry of (await getJson("/api/schema")).keys) schema[entry.key] = entry;
}

// Loads the values; false: `isCurrent` says no when they come, and they are left.
export async function loadValues(isCurrent = () => true) {
  const [described, changed] = await Promise.all([getJson("/api/values"), getJson("/api/edits")]);
  if (!isCurrent()) return false;
  values = described.values;
  numbers = described.numbers;
  given = described.given;
  file = described.file;
  edits = new Map(changed.edits.map(edit => [edit.key, edit.value]));
  return true;
}

export function countClouds() {
  return Object.keys(values).filter(key => /^clouds\[\d+\]\.name$/.test(key)).length;
}

// Whether a key has a slider: one number with a usual range.
export function hasSlider(entry) { return entry.count === 1 && entry.soft_max > entry.soft_min; }

export function getChoices(entry) {
  return entry.type === "choice" || entry.type === "preset" ? entry.choices : null;
}

// Groups that come first: the keys of rank "basic" by section, with those of one cloud.
const getSections = cloud => [["Sun", ["sun."]], ["View", ["output.", "camera."]], [`Cloud ${cloud + 1}`, [`clouds[${cloud}].`]],
  ["Air", ["atmosphere."]], ["Ground", ["terrain.", "water."]], ["Quality", ["render."]]];

export function listBasics(cloud) {
  const keys = Object.keys(values).filter(key => getEntry(key)?.rank === "basic");
  return getSections(cloud).map(([name, sections]) => [name, keys.filter(key => sections.some(section => key.startsWith(section)))]);
}
