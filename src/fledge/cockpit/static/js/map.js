// The arena from above, north up: what stands in it, how near the net lets the UAV come, where it was, and where it
// would come to rest if it were told to stop now.

import { circle, label, line, lines, stroke } from "./canvas.js";
import { Lens } from "./lens.js";
import { colourOf, mark, quadrotor } from "./shapes.js";
import { palette } from "./theme.js";

const EDGE = 26; // [px] around the arena, for its numbers
const UAV_RADIUS = 0.26; // [m], of `fledge.dynamics`
const LEAST = 11; // [px]: smaller vehicles could not be told apart

// `scene` is {flight, frame, trail, ghost}; a ghost is {vehicles, trail} of another flight.
export function paintMap(paper, { flight, frame, trail = [], ghost = null }) {
  const ink = paper.clear();
  if (!ink) return;
  const place = placing(paper, flight.arena);
  paper.backdrop([flight, palette()], (back) => paintHall(back, place, flight));
  const { uav, ghost: ghostly } = palette();
  const footprint = new Lens(flight.lens, frame.vehicles[0]).footprint.map(place.at);
  line(ink, footprint, { colour: palette().level, width: 1.25, dash: [2, 4], closed: true });
  if (ghost) {
    line(ink, ghost.trail.map(place.at), { colour: ghostly, width: 1.5, dash: [4, 4] });
    paintUav(ink, place, ghost.vehicles[0], { colour: ghostly, fill: "transparent" });
  }
  line(ink, trail.map(place.at), { colour: uav, width: 2 });
  frame.vehicles.slice(1).forEach((ugv, i) => paintUgv(ink, place, ugv, i));
  paintStop(ink, place, frame.vehicles[0]);
  paintUav(ink, place, frame.vehicles[0], { colour: uav, fill: palette().rim });
}

// World to paper, the whole arena as large as it goes.
function placing({ width, height }, { x_min, x_max, y_min, y_max }) {
  const scale = Math.min((width - 2 * EDGE) / (x_max - x_min), (height - 2 * EDGE) / (y_max - y_min));
  const left = (width - scale * (x_max - x_min)) / 2;
  const bottom = (height + scale * (y_max - y_min)) / 2;
  return { scale, at: ([x, y]) => [left + scale * (x - x_min), bottom - scale * (y - y_min)] };
}

function rectangle(ink, { at, scale }, { x_min, x_max, y_min, y_max }, grown, look) {
  const [x, y] = at([x_min - grown, y_max + grown]);
  const [width, height] = [x_max - x_min, y_max - y_min].map((side) => scale * (side + 2 * grown));
  ink.beginPath();
  ink.roundRect(x, y, width, height, scale * grown);
  stroke(ink, look);
}

function paintHall(ink, place, { arena, obstacles, margins }) {
  const [margin = 0] = margins;
  paintArena(ink, place, arena);
  for (const block of obstacles) paintBlock(ink, place, block, margin);
  if (margin) paintMargin(ink, place, arena, margin);
}

function paintArena(ink, place, arena) {
  const { floor, floorLine, wall, soft } = palette();
  rectangle(ink, place, arena, 0, { fill: floor });
  const { x_min, x_max, y_min, y_max } = arena;
  const step = x_max - x_min > 8 ? 2 : 1;
  for (let x = Math.ceil(x_min); x <= x_max; x += 1) {
    line(ink, [place.at([x, y_min]), place.at([x, y_max])], { colour: floorLine });
    const [u, v] = place.at([x, y_min]);
    if (x % step === 0) label(ink, `${x}`, [u, v + 12], { colour: soft, size: 11 });
  }
  for (let y = Math.ceil(y_min); y <= y_max; y += 1) {
    line(ink, [place.at([x_min, y]), place.at([x_max, y])], { colour: floorLine });
    const [u, v] = place.at([x_min, y]);
    if (y % step === 0) label(ink, `${y}`, [u - 6, v], { colour: soft, size: 11, align: "right" });
  }
  rectangle(ink, place, arena, 0, { colour: wall, width: 2.5 });
  const [right, bottom] = place.at([x_max, y_min]);
  label(ink, "m", [right + 10, bottom + 12], { colour: soft, size: 11 });
}

function paintBlock(ink, place, block, margin) {
  const { block: fill, wall, ink: dark, margin: red } = palette();
  if (margin) rectangle(ink, place, block, margin, { colour: red, width: 1.25, dash: [5, 4] });
  rectangle(ink, place, block, 0, { colour: wall, width: 1.5, fill });
  const [x, y] = place.at([(block.x_min + block.x_max) / 2, block.y_max]);
  label(ink, `${block.height.toFixed(1)} m`, [x, y - 9], { colour: dark, rim: palette().rim, size: 11 });
}

function paintMargin(ink, place, { x_min, x_max, y_min, y_max }, margin) {
  const inner = { x_min: x_min + margin, x_max: x_max - margin, y_min: y_min + margin, y_max: y_max - margin };
  rectangle(ink, place, inner, 0, { colour: palette().margin, width: 1.25, dash: [5, 4] });
}

// A mark with a hand, as of a clock, where its nose points.
function paintUgv(ink, place, ugv, i) {
  const [x, y] = place.at([ugv.x, ugv.y]);
  const tip = [x + 1.9 * LEAST * Math.cos(ugv.heading), y - 1.9 * LEAST * Math.sin(ugv.heading)];
  line(ink, [[x, y], tip], { colour: palette().markRim, width: 6 });
  line(ink, [[x, y], tip], { colour: colourOf(i), width: 3.5 });
  mark(ink, i, [x, y], LEAST - 2);
}

function paintUav(ink, place, uav, look) {
  quadrotor(ink, place.at([uav.x, uav.y]), Math.max(UAV_RADIUS * place.scale, LEAST), -uav.heading, look);
}

function paintStop(ink, place, { x, y, stop }) {
  if (!stop?.length) return;
  const { stopPoint } = palette();
  const at = place.at(stop);
  line(ink, [place.at([x, y]), at], { colour: stopPoint, width: 1.5 });
  circle(ink, at, Math.max(4, stop[2] * place.scale), { colour: stopPoint, width: 2 });
  const [u, v] = at;
  const cross = [[[u - 4, v - 4], [u + 4, v + 4]], [[u - 4, v + 4], [u + 4, v - 4]]];
  lines(ink, cross, { colour: stopPoint, width: 2 });
}
