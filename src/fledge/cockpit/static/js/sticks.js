// What the person says, sixty times a second: all devices together, as `sticks` to the server.
//
// They are sent while this page has the seat, a flight runs, and the page is seen: who does not see does not fly. The
// server misses them after 0.4 s and brakes.
//
// **Arming.** A vehicle must have been seen disarmed before it is armed, and one that flies stays armed whoever takes
// the seat. So `arm` follows the UAV's mode, but for the moment between a person's wish and the first motion. A wish that
// nothing came of is forgotten, so that the vehicle is seen disarmed again and a person may wish anew.
//
// **Stop** does not end a person's own flying, as the supervisor has it; so after it the sticks are dead until they
// have been in the middle.

import { AXES, FLYING } from "./words.js";

const RATE = 60; // [Hz]
const CENTRED = 0.1; // as the supervisor's `neutral`
const WISH = 1_000; // [ms] after which it is forgotten; chosen: a take-off is under way within two ticks
const DEAF = 2_000; // [ms] after which a server that hears nothing is asked for the seat anew
const FLAGS = ["switch", "hand_back", "stop", "dead_man", "land", "terminate"];

export class Sticks {
  axes = { forward: 0, left: 0, up: 0, turn: 0 };
  vehicle = 0;
  only = AXES; // those that count; all of them when the person flies by take-over
  #link;
  #orders;
  #devices;
  #wished = -Infinity; // when
  #isDead = false;
  #sequence = 0;
  #heard = { sequence: -1, at: 0 };
  #before = performance.now();

  constructor(link, orders, devices) {
    this.#link = link;
    this.#orders = orders;
    this.#devices = devices;
    link.on("frame", (frame) => this.#see(frame));
    link.on("flight", () => (this.#wished = -Infinity));
    link.on("seat", () => (this.#heard.at = performance.now()));
    setInterval(() => this.#tick(), 1_000 / RATE);
  }

  get isMine() {
    return this.#link.latest.seat?.seat === "mine";
  }

  get isSending() {
    return this.isMine && this.#link.latest.flight?.state === "running" && !document.hidden;
  }

  get canArm() {
    const { vehicles, armable } = this.#link.latest.frame ?? {};
    const isReady = armable && vehicles[0].mode === "READY" && vehicles.every(({ mode }) => mode !== "INIT");
    return this.isSending && isReady;
  }

  counts(axis) {
    return this.only.includes(axis) || this.#link.latest.frame?.vehicles[0].mode === "MANUAL";
  }

  arm() {
    if (this.canArm) this.#wished = performance.now();
  }

  #see({ vehicles, sequence }) {
    if (vehicles[0].mode !== "READY") this.#wished = -Infinity;
    if (sequence !== this.#heard.sequence) this.#heard = { sequence, at: performance.now() };
  }

  #tick() {
    const now = performance.now();
    const raw = this.#devices.map((device) => device(Math.min(0.1, (now - this.#before) / 1_000)));
    this.#before = now;
    for (const axis of AXES) {
      const sum = raw.reduce((total, one) => total + one[axis], 0);
      this.axes[axis] = this.counts(axis) ? Math.max(-1, Math.min(1, sum)) : 0;
    }
    if (this.#orders.says("stop")) this.#isDead = true;
    else if (AXES.every((axis) => Math.abs(this.axes[axis]) < CENTRED)) this.#isDead = false;
    if (this.#isDead) this.axes = { forward: 0, left: 0, up: 0, turn: 0 };
    if (!this.isSending) {
      this.#heard.at = now;
      return;
    }
    this.#askAnew(now);
    this.#send(now);
  }

  #send(now) {
    const mode = this.#link.latest.frame?.vehicles[0].mode;
    this.#sequence += 1;
    this.#link.send("sticks", {
      sequence: this.#sequence,
      stamp: now,
      vehicle: this.vehicle,
      axes: AXES.map((axis) => this.axes[axis]),
      arm: FLYING.has(mode) || (mode === "READY" && now - this.#wished < WISH),
      ...Object.fromEntries(FLAGS.map((flag) => [flag, this.#orders.says(flag)])),
    });
  }

  // A page whose clock stood still, as in a computer that slept, is late for good until it asks for the seat again.
  #askAnew(now) {
    if (now - this.#heard.at < DEAF) return;
    this.#heard.at = now;
    this.#link.send("seat", { want: true });
  }
}
