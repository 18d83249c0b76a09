// Plays a stored flight, with another one under it if one likes.

import { paintAltitude } from "./altitude.js";
import { paintCamera } from "./camera.js";
import { Paper } from "./canvas.js";
import { paintMap } from "./map.js";
import { $, say } from "./page.js";
import { paintTimeline, rowAt } from "./timeline.js";
import { clock, why } from "./words.js";

export class Player {
  #papers;
  #replay = null;
  #other = null;
  #at = 0; // [s] since the first row
  #isPlaying = false;
  #before = null; // [ms] when it was painted last, while it plays
  #isDue = false;

  constructor() {
    const redraw = () => this.redraw();
    this.#papers = ["watch-camera", "watch-top", "watch-altitude", "timeline"].map((id) => new Paper($(id), redraw));
    $("play").addEventListener("click", () => this.toggle());
    $("scrub").addEventListener("input", () => this.seek(Number($("scrub").value)));
    const timeline = $("timeline");
    const point = (event) => {
      if (this.#replay && event.buttons) this.seek(rowAt(this.#papers[3], this.#replay, event.offsetX));
    };
    timeline.addEventListener("pointerdown", (event) => {
      timeline.setPointerCapture(event.pointerId);
      point(event);
    });
    timeline.addEventListener("pointermove", point);
  }

  show(replay) {
    this.#replay = replay;
    this.#at = 0;
    $("scrub").max = replay.rows - 1;
    $("scrub").disabled = false;
    $("play").disabled = false;
    this.redraw();
  }

  lay(other) {
    this.#other = other;
    this.redraw();
  }

  // At the next picture of the screen; while it plays, at every one.
  redraw() {
    if (this.#isDue || !this.#replay) return;
    this.#isDue = true;
    requestAnimationFrame((now) => {
      this.#isDue = false;
      this.#advance(now);
      this.#paint(this.#row);
    });
  }

  pause() {
    this.#isPlaying = false;
    this.redraw();
  }

  // From the end it begins anew.
  toggle() {
    if (!this.#replay) return;
    this.#isPlaying = !this.#isPlaying;
    this.#before = null;
    if (this.#isPlaying && this.#row >= this.#replay.rows - 1) this.#at = 0;
    this.redraw();
  }

  move(rows) {
    if (this.#replay) this.seek(this.#row + rows);
  }

  seek(row) {
    this.#isPlaying = false;
    this.#at = (Math.max(0, Math.min(this.#replay.rows - 1, row)) / this.#replay.rows) * this.#replay.seconds;
    this.redraw();
  }

  get #row() {
    return this.#replay.row(this.#at);
  }

  #advance(now) {
    if (!this.#isPlaying) return;
    const seconds = this.#before === null ? 0 : (now - this.#before) / 1_000;
    this.#before = now;
    this.#at = Math.min(this.#at + seconds * Number($("pace").value), this.#replay.seconds);
    if (this.#row >= this.#replay.rows - 1) this.#isPlaying = false;
    this.redraw();
  }

  #paint(row) {
    const [replay, other] = [this.#replay, this.#other];
    const { flight } = replay;
    const frame = replay.frame(row);
    const otherRow = other ? other.row(this.#at) : 0;
    const ghost = other && { ...other.frame(otherRow), trail: other.trail.slice(0, otherRow + 1) };
    const [camera, top, altitude, timeline] = this.#papers;
    paintCamera(camera, { flight, frame, ghost: ghost?.picture });
    paintMap(top, { flight, frame, trail: replay.trail.slice(0, row + 1), ghost });
    paintAltitude(altitude, { flight, frame, ghost });
    paintTimeline(timeline, { replay, other, row });
    $("scrub").value = row;
    const time = `${clock(this.#at)} of ${clock(replay.seconds)}`;
    $("scrub").setAttribute("aria-valuetext", time);
    say($("clock"), time, row);
    say($("watched-now"), now(replay, frame));
    $("play").setAttribute("aria-label", this.#isPlaying ? "Pause" : "Play");
    $("play").querySelector("use").setAttribute("href", this.#isPlaying ? "#i-pause" : "#i-play");
  }
}

// The first vehicle that something was held back of, and why.
function now(replay, { vehicles }) {
  const held = vehicles.findIndex(({ intervened }) => intervened);
  return held < 0 ? "Nothing is held back." : `${replay.told.names[held]}: ${why(vehicles[held].reason)}`;
}
