// SPDX-License-Identifier: Apache-2.0
// Bookmarks of the camera; the tab keeps them.

import { values } from "./keys.js";
import { beginGesture, set } from "./server.js";

const list = document.getElementById("bookmarks");
const keys = ["camera.position", "camera.look_at", "camera.roll", "camera.focal_length", "camera.fov"];
const marks = JSON.parse(sessionStorage.getItem("bookmarks") ?? "[]");

function goTo(mark) {
  beginGesture();
  for (const [key, value] of Object.entries(mark)) set(key, value);
}

function show() {
  list.replaceChildren(...marks.map((mark, i) => {
    const button = document.createElement("button");
    button.textContent = i + 1;
    button.title = `camera ${i + 1}: ${mark["camera.position"]}`;
    button.onclick = () => goTo(mark);
    return button;
  }));
}

export function add() {
  marks.push(Object.fromEntries(keys.filter(key => key in values).map(key => [key, values[key]])));
  sessionStorage.setItem("bookmarks", JSON.stringify(marks));
  show();
}

show();
