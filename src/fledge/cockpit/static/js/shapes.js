// How vehicles look: every UGV has a number, a colour and a shape of its own, the same in all pictures.

import { circle, label, line, lines, stroke } from "./canvas.js";
import { palette } from "./theme.js";

const SIDES = [0, 4, 3, 5, 6]; // of UGV 1, 2, ...; 0 is a circle
const COLOURS = ["mark1", "mark2", "mark3", "mark4", "mark5"];

export function colourOf(ugv) {
  return palette()[COLOURS[ugv % COLOURS.length]];
}

// A UGV's mark: its shape with its number in it.
export function mark(ink, ugv, [x, y], radius) {
  const { markInk, markRim } = palette();
  const sides = SIDES[ugv % SIDES.length];
  const look = { colour: markRim, width: 2, fill: colourOf(ugv) };
  if (sides === 0) circle(ink, [x, y], radius, look);
  else line(ink, polygon(sides, [x, y], radius * (sides === 3 ? 1.35 : 1.15)), { ...look, closed: true });
  const middle = [x, y + (sides === 3 ? radius * 0.12 : 0.5)];
  label(ink, String(ugv + 1), middle, { colour: markInk, size: radius * 1.25, weight: 700 });
}

function polygon(sides, [x, y], radius) {
  const first = sides === 4 ? -Math.PI / 4 : -Math.PI / 2;
  return Array.from({ length: sides }, (_, i) => {
    const angle = first + (2 * Math.PI * i) / sides;
    return [x + radius * Math.cos(angle), y + radius * Math.sin(angle)];
  });
}

// The UAV from above: four rotors, and a wedge for its nose; `angle` is clockwise from the right, as on a canvas.
export function quadrotor(ink, [x, y], radius, angle, { colour, fill }) {
  ink.save();
  ink.translate(x, y);
  ink.rotate(angle);
  const arm = radius * 0.62;
  const arms = [[[-arm, -arm], [arm, arm]], [[-arm, arm], [arm, -arm]]];
  lines(ink, arms, { colour, width: Math.max(2, radius * 0.16) });
  for (const a of [-arm, arm]) {
    for (const b of [-arm, arm]) circle(ink, [a, b], radius * 0.42, { colour, width: 2, fill });
  }
  const nose = [[1.35, 0], [0.72, 0.32], [0.72, -0.32]].map(([a, b]) => [radius * a, radius * b]);
  line(ink, nose, { fill: colour, closed: true });
  ink.restore();
}

// A UGV's body from above, with a bar at its nose.
export function rover(ink, [x, y], length, width, angle, colour) {
  ink.save();
  ink.translate(x, y);
  ink.rotate(angle);
  ink.beginPath();
  ink.roundRect(-length / 2, -width / 2, length, width, width * 0.25);
  const { markRim } = palette();
  stroke(ink, { colour: markRim, width: 1, fill: colour });
  const bar = [[length * 0.3, -width * 0.3], [length * 0.3, width * 0.3]];
  line(ink, bar, { colour: markRim, width: Math.max(1.5, width * 0.12) });
  ink.restore();
}
