// SPDX-License-Identifier: Apache-2.0
// The sun on the dome of the sky, seen from below with north up and east right, or by date and time.

import { onValues } from "./controls.js";
import { numbers, values } from "./keys.js";
import { act, beginGesture, set, setAll } from "./server.js";
import { printNumber } from "./values.js";

const part = id => document.getElementById(id);
const dome = part("dome"), painter = dome.getContext("2d");
const middle = dome.width / 2, radius = 50, lowest = -18;
const degree = Math.PI / 180;

// Places on the dome: the zenith in the middle, the horizon a circle, twilight around it.
const toPlace = ({ azimuth, elevation }) => {
  const away = radius * (90 - elevation) / 90;
  return [middle + away * Math.sin(azimuth * degree), middle - away * Math.cos(azimuth * degree)];
};
const toAngles = (x, y) => ({
  azimuth: (Math.atan2(x - middle, middle - y) / degree + 360) % 360,
  elevation: Math.max(lowest, 90 - 90 * Math.hypot(x - middle, y - middle) / radius),
});

function isByTime() { return Boolean(values["sun.time"]); }

let sun = { azimuth: 0, elevation: 0 };

function circle(x, y, r, fill) {
  painter.beginPath();
  painter.arc(x, y, r, 0, 2 * Math.PI);
  if (fill) painter.fill();
  else painter.stroke();
}

function draw() {
  painter.clearRect(0, 0, dome.width, dome.height);
  painter.fillStyle = "#16304f";
  circle(middle, middle, radius, true);
  painter.strokeStyle = "#6c7f96";
  for (const elevation of [0, 30, 60]) circle(middle, middle, radius * (90 - elevation) / 90);
  painter.fillStyle = "#e4e4e4";
  painter.font = "11px sans-serif";
  painter.textAlign = "center";
  painter.textBaseline = "middle";
  [["N", 0, -1], ["E", 1, 0], ["S", 0, 1], ["W", -1, 0]].forEach(([name, x, y]) => painter.fillText(name, middle + 60 * x, middle + 60 * y));
  if (isByTime()) return;
  const [x, y] = toPlace(sun);
  painter.fillStyle = sun.elevation > 0 ? "#ffd35a" : "#a07a3a";
  circle(x, y, 6, true);
}

function describe() {
  const time = isByTime();
  part("sun-by-time").setAttribute("aria-pressed", time);
  for (const id of ["sun-date", "sun-clock", "sun-minute"]) part(id).disabled = !time;
  part("sun-text").textContent = time ? values["sun.time"] : `${sun.elevation.toFixed(1)}° high, azimuth ${sun.azimuth.toFixed(1)}°`;
  dome.setAttribute("aria-valuenow", sun.elevation.toFixed(1));
  dome.setAttribute("aria-valuetext", part("sun-text").textContent);
  dome.setAttribute("aria-disabled", time);
}

function show() {
  if (!dragging) sun = { azimuth: numbers["sun.azimuth"] ?? 0, elevation: numbers["sun.elevation"] ?? 0 };
  if (isByTime()) {
    const [date, clock] = new Date(values["sun.time"]).toISOString().split("T");
    part("sun-date").value = date;
    part("sun-clock").value = clock.slice(0, 5);
    part("sun-minute").value = 60 * clock.slice(0, 2) + Number(clock.slice(3, 5));
  }
  describe();
  draw();
}

function move(angles) {
  sun = { azimuth: angles.azimuth, elevation: Math.min(90, Math.max(lowest, angles.elevation)) };
  setAll({ "sun.azimuth": printNumber(sun.azimuth, "deg"), "sun.elevation": printNumber(sun.elevation, "deg") });
  describe();
  draw();
}

let dragging = false;

function drag(event) {
  const box = dome.getBoundingClientRect();
  move(toAngles((event.clientX - box.left) * dome.width / box.width, (event.clientY - box.top) * dome.height / box.height));
}

dome.onpointerdown = event => {
  if (isByTime()) return;
  dome.setPointerCapture(event.pointerId);
  beginGesture();
  dragging = true;
  drag(event);
};
dome.onpointermove = event => { if (dragging) drag(event); };
dome.onpointerup = dome.onpointercancel = () => { dragging = false; };

const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

dome.onkeydown = event => {
  const step = steps[event.key], size = event.shiftKey ? 10 : 1;
  if (!step || isByTime()) return;
  event.preventDefault();
  if (!event.repeat) beginGesture();
  move({ azimuth: (sun.azimuth + size * step[0] + 360) % 360, elevation: sun.elevation + size * step[1] });
};

// ---- Date and time ----

const print = minute => String(Math.floor(minute / 60)).padStart(2, "0") + ":" + String(minute % 60).padStart(2, "0");

function setTime(clock) {
  if (part("sun-date").value && clock) set("sun.time", `${part("sun-date").value}T${clock}Z`);
}

part("sun-date").onchange = part("sun-clock").onchange = () => {
  beginGesture();
  setTime(part("sun-clock").value.slice(0, 5));
};
part("sun-minute").onpointerdown = beginGesture;
part("sun-minute").onkeydown = event => { if (!event.repeat) beginGesture(); };
part("sun-minute").oninput = () => {
  part("sun-clock").value = print(Number(part("sun-minute").value));
  setTime(part("sun-clock").value);
};
// A time needs a place.
part("sun-by-time").onclick = () => {
  if (isByTime()) return act("/api/unset", "sun.time");
  beginGesture();
  const place = "place.latitude" in values ? {} : { "place.latitude": "45 deg", "place.longitude": "0 deg" };
  setAll({ ...place, "sun.time": new Date().toISOString().slice(0, 11) + "12:00Z" });
};

onValues(show);
