// SPDX-License-Identifier: Apache-2.0
// Texts of values, as the scene has them: numbers with units, lists.

const units = { "": 1, m: 1, km: 1e3, mm: 1e-3, um: 1e-6, deg: 1, "1/m": 1, "1/km": 1e-3, EV: 1, s: 1, min: 60, h: 3600 };

// A number in the base unit; NaN for a word or an unknown unit.
export function parseNumber(text) {
  const match = /^\s*([-+]?[0-9.]+(?:e[-+]?[0-9]+)?)\s*(\S*)\s*$/i.exec(text ?? "");
  return match && match[2] in units ? Number(match[1]) * units[match[2]] : NaN;
}

export function parseList(text) { return (text ?? "").replace(/[[\]]/g, "").split(",").map(parseNumber); }

// Digits that a person would write.
export function printNumber(number, unit, digits = 4) {
  const rounded = Number(number.toPrecision(digits));
  return unit ? rounded + " " + unit : String(rounded);
}

export function printPoint(point) { return "[" + point.map(x => x.toFixed(2) + " m").join(", ") + "]"; }

export function printShare(share) { return share == null ? "–" : (100 * share).toPrecision(2) + " %"; }

// A value as a person would write it: lengths of lenses and films in millimetres.
export function tidy(text) {
  const match = /^(0\.0\d*) m$/.exec(text ?? "");
  return match ? printNumber(1000 * Number(match[1]), "mm") : text ?? "";
}

// Words of a list: "[depth, sun]", or none.
export function parseWords(text) { return (text ?? "").match(/[a-z_]+/g)?.filter(word => word !== "none") ?? []; }

// A text without the quotes of YAML.
export function unquote(text) { return (text ?? "").replace(/^"(.*)"$/, "$1"); }
