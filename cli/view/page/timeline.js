// SPDX-License-Identifier: Apache-2.0
// Frames of an animation: a line that plays and scrubs. Frames that were drawn are drawn again at once, until an edit.

import { getJson, post, record } from "./server.js";

const part = id => document.getElementById(id);
const slider = part("frame-slider"), play = part("play"), canvas = part("picture");
const kept_max = 200;
let frames = [1], is_playing = false, wanted = -1, is_asking = false, edit_kept = 0;
const kept = new Map(); // frame: picture

function show(index) {
  slider.value = index;
  part("frame-number").textContent = frames[index];
  slider.setAttribute("aria-valuetext", "frame " + frames[index]);
}

// Asks for the frame that is wanted last, one request at a time.
async function ask() {
  if (is_asking) return;
  is_asking = true;
  while (wanted >= 0) {
    const index = wanted;
    wanted = -1;
    const answer = await post("/api/frame", String(frames[index]));
    if ("edit" in answer) edit_kept = answer.edit;
  }
  is_asking = false;
}

function goTo(index) {
  show(index);
  const picture = kept.get(frames[index]);
  if (picture && picture.width === canvas.width) canvas.getContext("2d").drawImage(picture, 0, 0);
  wanted = index;
  ask();
}

function setPlaying(is_on) {
  is_playing = is_on;
  play.setAttribute("aria-pressed", is_on);
  play.textContent = is_on ? "Stop" : "Play";
  if (is_on) goTo((Number(slider.value) + 1) % frames.length);
}

function keep(frame) {
  const copy = kept.get(frame) ?? document.createElement("canvas");
  copy.width = canvas.width;
  copy.height = canvas.height;
  copy.getContext("2d").drawImage(canvas, 0, 0);
  kept.delete(frame);
  kept.set(frame, copy);
  if (kept.size > kept_max) kept.delete(kept.keys().next().value);
}

export function toggle() { if (frames.length > 1) setPlaying(!is_playing); }

export async function start() {
  frames = await getJson("/api/frames");
  part("timeline").hidden = frames.length < 2;
  slider.max = frames.length - 1;
  show(0);
}

slider.oninput = () => {
  if (is_playing) setPlaying(false);
  goTo(Number(slider.value));
};
play.onclick = toggle;

// Plays as fast as pictures come: the next frame is asked for once this one has been drawn.
export function follow(state, pixels) {
  if (frames.length < 2) return;
  if (state.edit !== edit_kept && !is_asking && wanted < 0) kept.clear(), edit_kept = state.edit;
  const is_shown = pixels && state.generation === state.wanted && state.frame === frames[slider.value];
  if (!is_shown || is_asking) return;
  if (state.complete) keep(state.frame);
  record.frames = (record.frames ?? 0) + 1;
  if (is_playing) goTo((Number(slider.value) + 1) % frames.length);
}
