// Which axis and button of a gamepad is which: a value per device, kept by this browser.
//
// An axis is {index, low, middle, high}: raw values at full stick backward (right, down, clockwise), at rest, and at
// full stick forward (left, up, counter-clockwise). Low may lie above high; that is how an axis is reversed.

import { remember, remembered } from "./page.js";

export const BUTTONS = {
  arm: "Arm",
  switch: "Take over",
  hand_back: "Hand back",
  stop: "Stop",
  land: "Land",
  dead_man: "Without net (held)",
};

const NEUTRAL = 0.06; // chosen: worn sticks rest within 5 % of their middle

// As `fledge.lab.control.joy` has it, with the numbers of a browser's "standard" gamepad (where down and right are 1).
const STANDARD = {
  axes: {
    forward: { index: 3, low: 1, middle: 0, high: -1 },
    left: { index: 2, low: 1, middle: 0, high: -1 },
    up: { index: 1, low: 1, middle: 0, high: -1 },
    turn: { index: 0, low: 1, middle: 0, high: -1 },
  },
  buttons: { arm: 9, switch: 3, hand_back: 2, stop: 1, land: 0, dead_man: 4 },
};

export function mappingOf(id) {
  return remembered(`pad.${id}`, STANDARD);
}

export function keepMapping(id, mapping) {
  remember(`pad.${id}`, mapping);
}

export function forgetMapping(id) {
  remember(`pad.${id}`, null);
}

// -1 to 1; what the device does not have, or says as no number, is the middle.
export function deflection({ index, low, middle, high }, raw) {
  const value = raw[index];
  if (!Number.isFinite(value)) return 0;
  const isHigh = (value - middle) * (high - middle) > 0;
  const span = isHigh ? high - middle : middle - low;
  const share = Math.max(-1, Math.min(1, span ? (value - middle) / span : 0));
  const beyond = Math.max(0, Math.abs(share) - NEUTRAL) / (1 - NEUTRAL);
  return Math.sign(share) * beyond;
}
