// What the UAV's camera sees, as the paper's operator saw it: a red dot for the picture's centre, a blue dot and circle
// for the UGVs', dashed the circle as it should be. Without video the floor is drawn, too.

import { circle, label, line, lines } from "./canvas.js";
import { Lens } from "./lens.js";
import { colourOf, mark, rover } from "./shapes.js";
import { palette } from "./theme.js";

const UGV = [0.55, 0.43]; // [m] a Pioneer from above, of `fledge.dynamics`
const LOW = 0.3; // [m] above an obstacle's top from which its walls can still be drawn

// `scene` is {flight, frame, video, ghost}; `ghost` another flight's picture at the same time.
export function paintCamera(paper, { flight, frame, video, ghost }) {
  const ink = paper.clear();
  if (!ink) return;
  const { width, height } = flight.lens;
  const scale = Math.min(paper.width / width, paper.height / height);
  ink.translate((paper.width - scale * width) / 2, (paper.height - scale * height) / 2);
  ink.scale(scale, scale);
  ink.save();
  ink.beginPath();
  ink.roundRect(0, 0, width, height, 8 / scale);
  ink.clip();
  const lens = new Lens(flight.lens, frame.vehicles[0]);
  if (video) ink.drawImage(video, 0, 0, width, height);
  else paintFloor(ink, lens, flight, frame);
  paintLevel(ink, lens);
  if (ghost) paintCircle(ink, ghost, { colour: palette().ghost, dash: [3, 5] });
  paintPicture(ink, frame.picture, lens);
  ink.restore();
}

function paintFloor(ink, lens, flight, frame) {
  const { floor, outside, floorLine, floorLineStrong, wall } = palette();
  const { arena } = flight;
  ink.fillStyle = outside;
  ink.fillRect(0, 0, lens.width, lens.height);
  const { x_min: west, x_max: east, y_min: south, y_max: north } = arena;
  const walls = [[west, south], [east, south], [east, north], [west, north]].map(([x, y]) => lens.pixel(x, y));
  line(ink, walls, { fill: floor, closed: true });
  const grid = [...gridLines(arena)].map(([from, to, isStrong]) => [lens.pixel(...from), lens.pixel(...to), isStrong]);
  lines(ink, grid.filter(([, , isStrong]) => !isStrong), { colour: floorLine });
  lines(ink, grid.filter(([, , isStrong]) => isStrong), { colour: floorLineStrong });
  line(ink, walls, { colour: wall, width: 4, closed: true });
  for (const block of flight.obstacles) paintBlock(ink, lens, block);
  frame.vehicles.slice(1).forEach((ugv, i) => {
    const scale = lens.focal / Math.max(lens.uav.z, LOW);
    const angle = lens.uav.heading - ugv.heading - Math.PI / 2;
    rover(ink, lens.pixel(ugv.x, ugv.y), UGV[0] * scale, UGV[1] * scale, angle, colourOf(i));
  });
}

// Lines every half metre, strong on whole ones.
function* gridLines({ x_min: west, x_max: east, y_min: south, y_max: north }) {
  for (let i = Math.ceil(2 * west); i <= 2 * east; i += 1) yield [[i / 2, south], [i / 2, north], i % 2 === 0];
  for (let i = Math.ceil(2 * south); i <= 2 * north; i += 1) yield [[west, i / 2], [east, i / 2], i % 2 === 0];
}

function paintBlock(ink, lens, { x_min: west, x_max: east, y_min: south, y_max: north, height }) {
  const { block, blockSide, wall } = palette();
  const corners = [[west, south], [east, south], [east, north], [west, north]];
  const top = Math.min(height, lens.uav.z - LOW);
  const base = corners.map(([x, y]) => lens.pixel(x, y));
  const lid = corners.map(([x, y]) => lens.pixel(x, y, top));
  for (let i = 0; i < 4; i += 1) {
    const next = (i + 1) % 4;
    line(ink, [base[i], base[next], lid[next], lid[i]], { colour: wall, fill: blockSide, closed: true });
  }
  line(ink, lid, { colour: wall, width: 1.5, fill: block, closed: true });
}

// The level, as on an artificial horizon, and where north is.
function paintLevel(ink, lens) {
  const { level, rim } = palette();
  const { width, height } = lens;
  for (const [from, to] of [[0.06, 0.3], [0.7, 0.94]]) {
    const ends = [[from * width, height / 2], [to * width, height / 2]];
    line(ink, ends, { colour: rim, width: 3 });
    line(ink, ends, { colour: level, width: 1.25, dash: [10, 6] });
  }
  const [x, y] = [width - 34, height - 34];
  // From east counter-clockwise to the picture's up: north is to the left of it by the UAV's heading.
  const angle = lens.uav.heading - Math.PI;
  const tip = [x + 15 * Math.cos(angle), y + 15 * Math.sin(angle)];
  circle(ink, [x, y], 24, { colour: level, width: 1, fill: rim });
  line(ink, [[x - 15 * Math.cos(angle), y - 15 * Math.sin(angle)], tip], { colour: level, width: 2 });
  label(ink, "N", tip, { colour: level, rim, size: 13, weight: 700 });
}

function paintPicture(ink, picture, lens) {
  const { red, blue, ideal, rim } = palette();
  const centre = [lens.width / 2, lens.height / 2];
  circle(ink, centre, picture.ideal_radius, { colour: rim, width: 4 });
  circle(ink, centre, picture.ideal_radius, { colour: ideal, width: 2, dash: [9, 7] });
  paintCircle(ink, picture, { colour: blue });
  picture.marks.forEach(([u, v], i) => {
    const at = [Math.max(16, Math.min(lens.width - 16, u)), Math.max(16, Math.min(lens.height - 16, v))];
    const isOut = at[0] !== u || at[1] !== v;
    if (isOut) line(ink, [at, [u, v]], { colour: red, width: 4, dash: [4, 3] });
    ink.globalAlpha = isOut ? 0.75 : 1;
    mark(ink, i, at, 11);
    ink.globalAlpha = 1;
  });
  line(ink, [centre, [picture.u, picture.v]], { colour: blue, width: 1.5 });
  circle(ink, [picture.u, picture.v], 6, { colour: rim, width: 2, fill: blue });
  circle(ink, centre, 6, { colour: rim, width: 2, fill: red });
}

function paintCircle(ink, { u, v, radius }, { colour, dash }) {
  circle(ink, [u, v], radius, { colour: palette().rim, width: 5 });
  circle(ink, [u, v], radius, { colour, width: 2.5, dash });
}
