// A loss curve: training and held-out loss by epoch, the loss on a logarithmic axis.

import { circle, label, line, stroke } from "./canvas.js";
import { palette } from "./theme.js";

const EDGE = { left: 66, right: 96, top: 18, bottom: 40 }; // [px]

export function paintCurve(paper, points, epochs) {
  const ink = paper.clear();
  if (!ink || !points.length) return;
  const { soft, floorLine, uav, ghost, line: border } = palette();
  const losses = points.flatMap(([, training, heldOut]) => [training, heldOut]).filter((loss) => loss > 0);
  if (!losses.length) return;
  const low = Math.log10(Math.min(...losses)) - 0.05;
  const high = Math.log10(Math.max(...losses)) + 0.05;
  const last = Math.max(epochs, points.at(-1)[0], 1);
  const [width, height] = [paper.width - EDGE.left - EDGE.right, paper.height - EDGE.top - EDGE.bottom];
  const x = (epoch) => EDGE.left + (epoch / last) * width;
  const y = (loss) => EDGE.top + ((high - Math.log10(loss)) / (high - low)) * height;
  for (const loss of ticks(low, high)) {
    line(ink, [[x(0), y(loss)], [x(last), y(loss)]], { colour: floorLine });
    label(ink, loss.toPrecision(1), [EDGE.left - 8, y(loss)], { colour: soft, size: 12, align: "right" });
  }
  for (const share of [0, 0.25, 0.5, 0.75, 1]) {
    const at = [x(share * last), paper.height - EDGE.bottom + 14];
    label(ink, Math.round(share * last).toLocaleString("en"), at, { colour: soft, size: 12 });
  }
  label(ink, "epoch", [EDGE.left + width / 2, paper.height - 9], { colour: soft, size: 12 });
  ink.beginPath();
  ink.rect(EDGE.left, EDGE.top, width, height);
  stroke(ink, { colour: border });
  const ends = [
    { column: 1, colour: uav, word: "training", dash: [] },
    { column: 2, colour: ghost, word: "held out", dash: [7, 4] },
  ].map((one) => {
    const known = points.filter((point) => point[one.column] > 0);
    return { ...one, path: known.map((point) => [x(point[0]), y(point[one.column])]) };
  });
  // Names side by side would lie on each other where the curves end close together.
  const apart = ends[0].path.length && ends[1].path.length ? ends[0].path.at(-1)[1] - ends[1].path.at(-1)[1] : 99;
  const shift = Math.abs(apart) < 16 ? (16 - Math.abs(apart)) / 2 : 0;
  ends.forEach(({ path, colour, dash, word }, i) => {
    if (!path.length) return;
    const [u, v] = path.at(-1);
    const away = (i === 0) === apart >= 0 ? shift : -shift;
    line(ink, path, { colour, width: 2.25, dash });
    circle(ink, [u, v], 4, { fill: colour });
    label(ink, word, [u + 10, v + away], { colour, size: 13, align: "left" });
  });
}

// 1, 2 and 5 times powers of ten; powers alone where there is room for no more.
function ticks(low, high) {
  const factors = high - low < 2 ? [1, 2, 5] : [1];
  const found = [];
  for (let power = Math.floor(low); power <= high; power += 1) {
    for (const factor of factors) {
      const loss = factor * 10 ** power;
      if (Math.log10(loss) >= low && Math.log10(loss) <= high) found.push(loss);
    }
  }
  return found;
}
