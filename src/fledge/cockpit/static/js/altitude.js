// The altitude as a bar between floor and ceiling, with the tops of obstacles as notches.

import { label, line } from "./canvas.js";
import { palette } from "./theme.js";

const EDGE = 20; // [px]

export function paintAltitude(paper, { flight, frame, ghost = null }) {
  const ink = paper.clear();
  if (!ink) return;
  const { width, height } = paper;
  const ceiling = flight.arena.height;
  const { uav, floor, wall, soft, ink: dark, rim, block, ghost: ghostly } = palette();
  const rail = { left: 26, right: width - 6 };
  const at = (z) => height - EDGE - (Math.max(0, Math.min(ceiling, z)) / ceiling) * (height - 2 * EDGE);
  ink.fillStyle = floor;
  ink.fillRect(rail.left, at(ceiling), rail.right - rail.left, at(0) - at(ceiling));
  for (const { height: top } of flight.obstacles) {
    ink.fillStyle = block;
    ink.fillRect(rail.right - 7, at(top), 7, at(0) - at(top));
  }
  for (let z = 0; z <= ceiling; z += 1) {
    line(ink, [[rail.left, at(z)], [rail.left + 7, at(z)]], { colour: soft });
    label(ink, `${z}`, [rail.left - 6, at(z)], { colour: soft, size: 11, align: "right" });
  }
  const level = (height) => [[rail.left, at(height)], [rail.right, at(height)]];
  for (const end of [0, ceiling]) line(ink, level(end), { colour: wall, width: 2.5 });
  const { z } = frame.vehicles[0];
  ink.globalAlpha = 0.25;
  ink.fillStyle = uav;
  ink.fillRect(rail.left, at(z), rail.right - rail.left, at(0) - at(z));
  ink.globalAlpha = 1;
  if (ghost) line(ink, level(ghost.vehicles[0].z), { colour: ghostly, width: 2, dash: [4, 3] });
  line(ink, level(z), { colour: uav, width: 3 });
  line(ink, [[rail.left, at(z)], [rail.left - 7, at(z) - 6], [rail.left - 7, at(z) + 6]], { fill: uav, closed: true });
  label(ink, z.toFixed(2), [(rail.left + rail.right) / 2, at(z) - 11], { colour: dark, rim, size: 13, weight: 700 });
  label(ink, "m", [rail.left - 6, 8], { colour: soft, size: 11, align: "right" });
}
