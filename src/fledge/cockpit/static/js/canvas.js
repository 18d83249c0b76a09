// Paper to paint on: sharp on every screen, measured in CSS pixels.

import { palette } from "./theme.js";

const FONT = '"Inter", "Segoe UI", system-ui, -apple-system, "DejaVu Sans", sans-serif';

export class Paper {
  #isStale = true;
  #back = null;
  #keys = [];

  // `resized` is called when what was painted is gone.
  constructor(canvas, resized) {
    this.canvas = canvas;
    this.ink = canvas.getContext("2d", { alpha: false }); // a fifth less work for every picture
    new ResizeObserver(() => {
      this.#isStale = true;
      resized();
    }).observe(canvas);
  }

  // A sheet as blank as the card it lies on, or null while it has no size.
  clear() {
    if (this.#isStale) this.#measure();
    if (!this.width || !this.height) return null;
    this.ink.setTransform(this.scale, 0, 0, this.scale, 0, 0);
    this.ink.fillStyle = palette().card;
    this.ink.fillRect(0, 0, this.width, this.height);
    this.ink.lineJoin = "round";
    return this.ink;
  }

  // What seldom changes: painted anew only if one of `keys` is another than the last time, or the size is.
  backdrop(keys, paint) {
    if (!this.#back || keys.some((key, i) => key !== this.#keys[i])) {
      this.#back = new OffscreenCanvas(this.canvas.width, this.canvas.height);
      this.#keys = keys;
      const ink = this.#back.getContext("2d");
      ink.scale(this.scale, this.scale);
      paint(ink);
    }
    this.ink.drawImage(this.#back, 0, 0, this.width, this.height);
  }

  #measure() {
    const { clientWidth, clientHeight } = this.canvas;
    this.scale = Math.min(2, devicePixelRatio);
    this.width = clientWidth;
    this.height = clientHeight;
    this.canvas.width = Math.round(clientWidth * this.scale);
    this.canvas.height = Math.round(clientHeight * this.scale);
    this.#isStale = false;
    this.#back = null;
  }
}

function font(size, weight = 500) {
  return `${weight} ${size}px ${FONT}`;
}

export function line(ink, points, { colour, width = 1, dash = [], fill = "", closed = false }) {
  if (!points.length) return;
  ink.beginPath();
  points.forEach(([x, y], i) => (i ? ink.lineTo(x, y) : ink.moveTo(x, y)));
  if (closed) ink.closePath();
  stroke(ink, { colour, width, dash, fill });
}

// Many lines of one look, each from a point to another: one stroke is much faster than many.
export function lines(ink, pairs, look) {
  ink.beginPath();
  for (const [[x, y], [u, v]] of pairs) {
    ink.moveTo(x, y);
    ink.lineTo(u, v);
  }
  stroke(ink, look);
}

export function circle(ink, [x, y], radius, look) {
  ink.beginPath();
  ink.arc(x, y, Math.max(0, radius), 0, 2 * Math.PI);
  stroke(ink, look);
}

export function stroke(ink, { colour, width = 1, dash = [], fill = "" }) {
  if (fill) {
    ink.fillStyle = fill;
    ink.fill();
  }
  if (!colour) return;
  ink.strokeStyle = colour;
  ink.lineWidth = width;
  ink.setLineDash(dash);
  ink.stroke();
  ink.setLineDash([]);
}

// Text with a rim, so that it can be read on anything.
export function label(ink, text, [x, y], { colour, rim, size = 12, weight = 600, align = "center" }) {
  ink.font = font(size, weight);
  ink.textAlign = align;
  ink.textBaseline = "middle";
  if (rim) {
    ink.strokeStyle = rim;
    ink.lineWidth = 3;
    ink.strokeText(text, x, y);
  }
  ink.fillStyle = colour;
  ink.fillText(text, x, y);
}
