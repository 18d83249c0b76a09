// The live pictures: camera, map and altitude, painted at most once for every picture of the screen, newest frame only.
//
// Measured here, since only here it is known: how many pictures a second a person sees, and how long it takes from the
// sticks to the picture that has heard of them.

import { paintAltitude } from "./altitude.js";
import { paintCamera } from "./camera.js";
import { Paper } from "./canvas.js";
import { paintMap } from "./map.js";
import { Median, Rate } from "./meter.js";
import { $ } from "./page.js";

const TRAIL = 20; // [s] of flight that stay on the map

export class Stage {
  updates = new Rate();
  latency = new Median();
  arrived = performance.now();
  #link;
  #papers;
  #video = null;
  #trail = [];
  #heard = -1;
  #isDue = false;
  #scene = null;

  constructor(link) {
    this.#link = link;
    const redraw = () => this.redraw();
    this.#papers = ["camera", "top", "altitude"].map((id) => new Paper($(id), redraw));
    link.on("frame", (frame) => this.#see(frame));
    link.on("flight", ({ state }) => this.#begin(state));
    link.on("video", (jpeg) => this.#show(jpeg));
  }

  // At the next picture of the screen, however often it is said until then.
  redraw() {
    if (this.#isDue) return;
    this.#isDue = true;
    requestAnimationFrame((now) => {
      this.#isDue = false;
      this.#paint(now);
    });
  }

  #see(frame) {
    this.arrived = performance.now();
    const last = this.#trail.at(-1);
    if (last && frame.t < last.t) this.#trail = [];
    this.#trail.push({ t: frame.t, at: [frame.vehicles[0].x, frame.vehicles[0].y] });
    while (this.#trail[0].t < frame.t - TRAIL) this.#trail.shift();
    this.redraw();
  }

  #begin(state) {
    this.arrived = performance.now();
    this.latency.clear();
    if (state === "none") this.#scene = this.#video = null;
    this.redraw();
  }

  async #show(jpeg) {
    const picture = await createImageBitmap(jpeg).catch(() => null);
    if (!picture) return;
    this.#video?.close();
    this.#video = picture;
    this.redraw();
  }

  #paint(now) {
    const { flight, frame } = this.#link.latest;
    // Without a line what was seen last stays, and may have to be painted anew.
    if (flight && frame) {
      const video = flight.world === "simulator" ? null : this.#video;
      this.#scene = { flight, frame, video, trail: this.#trail.map(({ at }) => at) };
    }
    if (!this.#scene) return;
    const [camera, top, altitude] = this.#papers;
    paintCamera(camera, this.#scene);
    paintMap(top, this.#scene);
    paintAltitude(altitude, this.#scene);
    if (frame) this.#measure(frame, now);
  }

  #measure(frame, now) {
    this.updates.count(now);
    if (frame.sequence > this.#heard) this.latency.add(performance.now() - frame.stamp);
    this.#heard = frame.sequence;
  }
}
