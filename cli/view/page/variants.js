// SPDX-License-Identifier: Apache-2.0
// Variants of a cloud as small pictures: its presets, or seeds behind its own.

import { getChoices, getEntry, values } from "./keys.js";
import { getPictures, post, setOnce } from "./server.js";

const strip = document.getElementById("strip");
let offered = [], number_shown = 0;

// Offers values of a key; their pictures come one by one.
async function offer(key, choices) {
  const answer = await post("/api/vary", choices.map(choice => `${key}=${choice}`).join("\n"));
  if (answer.refusal) return answer.refusal;
  offered = choices.map(choice => [key, choice]);
  strip.hidden = false;
  strip.replaceChildren(...offered.map(([, choice]) => {
    const button = document.createElement("button"), name = String(choice).replaceAll("_", " ");
    button.append(document.createElement("canvas"), name);
    button.onclick = () => setOnce(key, choice);
    return button;
  }));
  return "";
}

export function offerSeeds(cloud) {
  const seed = Number(values[`clouds[${cloud}].bake.seed`] ?? 0);
  return offer(`clouds[${cloud}].bake.seed`, [1, 2, 3, 4, 5, 6].map(step => seed + step));
}

export function offerPresets(cloud) {
  return offer(`clouds[${cloud}].bake.preset`, getChoices(getEntry("clouds[].bake.preset")));
}

export function close() {
  offered = [];
  strip.hidden = true;
}

// Draws the pictures that are there, when they have changed.
export async function follow(number) {
  if (number === number_shown || !offered.length) return;
  number_shown = number;
  const [{ sizes }, pixels] = await getPictures("/api/variants");
  let at = 0;
  sizes.forEach(([width, height], i) => {
    const canvas = strip.children[i]?.firstChild, size = 4 * width * height;
    if (!size || !canvas) return;
    canvas.width = width;
    canvas.height = height;
    canvas.getContext("2d").putImageData(new ImageData(pixels.slice(at, at + size), width, height), 0, 0);
    at += size;
  });
}
