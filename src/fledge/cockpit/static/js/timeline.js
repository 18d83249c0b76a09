// A flight's time line: how far the UGVs' centre was from the picture's, and below, a lane for every vehicle with what
// was held back. Layers of the net differ in colour and in the shape at their beginning.

import { circle, label, line } from "./canvas.js";
import { palette } from "./theme.js";
import { layer } from "./words.js";

const LEFT = 62; // [px] for names, and for thousands of pixels
const RIGHT = 10;
const LANE = 15;
const LEAST = 60; // [px of the picture] that the curve's height is at least

// `other` is null, or the flight to compare with.
export function paintTimeline(paper, { replay, other, row }) {
  const ink = paper.clear();
  if (!ink) return;
  const lanes = replay.told.names.length;
  const floor = paper.height - lanes * LANE - 2;
  const last = Math.max(1, replay.rows - 1);
  const x = (i) => LEFT + (i / last) * (paper.width - LEFT - RIGHT);
  const { floorLine, soft, blue, ghost, ink: dark } = palette();
  const top = Math.max(LEAST, ...replay.distance, ...(other?.distance ?? []));
  const y = (pixels) => floor - 4 - (pixels / top) * (floor - 14);
  label(ink, `${top.toFixed(0)} px`, [LEFT - 8, 10], { colour: soft, size: 11, align: "right" });
  label(ink, "0", [LEFT - 8, floor - 5], { colour: soft, size: 11, align: "right" });
  line(ink, [[LEFT, y(0)], [paper.width - RIGHT, y(0)]], { colour: floorLine });
  const curve = ({ distance }) => distance.slice(0, replay.rows).map((pixels, i) => [x(i), y(pixels)]);
  if (other) line(ink, curve(other), { colour: ghost, width: 1.5, dash: [4, 3] });
  line(ink, curve(replay), { colour: blue, width: 1.75 });
  replay.told.names.forEach((name, vehicle) => {
    const middle = floor + (vehicle + 0.5) * LANE;
    label(ink, name, [LEFT - 8, middle], { colour: soft, size: 11, align: "right" });
    line(ink, [[LEFT, middle], [paper.width - RIGHT, middle]], { colour: floorLine });
    for (const span of replay.interventions(vehicle)) paintSpan(ink, span, x, middle);
  });
  line(ink, [[x(row), 0], [x(row), paper.height]], { colour: dark, width: 2 });
}

function paintSpan(ink, { first, last, reason }, x, y) {
  const what = layer(reason) || "net";
  const colour = palette()[what];
  line(ink, [[x(first), y], [Math.max(x(last + 1), x(first) + 2), y]], { colour, width: 6 });
  if (what === "person") circle(ink, [x(first), y], 5, { fill: colour });
  else line(ink, SHAPES[what].map(([a, b]) => [x(first) + a, y + b]), { fill: colour, closed: true });
}

const SHAPES = {
  net: [[-5, -5], [5, -5], [5, 5], [-5, 5]],
  watchdog: [[0, -7], [7, 0], [0, 7], [-7, 0]],
};

// The row under a point of the time line.
export function rowAt(paper, replay, offset) {
  const share = (offset - LEFT) / (paper.width - LEFT - RIGHT);
  return Math.round(share * (replay.rows - 1));
}
