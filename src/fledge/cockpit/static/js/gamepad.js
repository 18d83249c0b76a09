// The gamepad: read sixty times a second, since browsers tell nobody that a stick has moved.
//
// Of several, the one that was touched last counts. One that disappears is missed (`lost`) until it or another is back.

import { BUTTONS, deflection, mappingOf } from "./mapping.js";
import { AXES } from "./words.js";

const TOUCHED = 0.5; // of an axis' raw value; chosen: what no stick does by itself
const REST = { forward: 0, left: 0, up: 0, turn: 0 };

export class Gamepads {
  lost = "";
  #index = null;
  #id = "";
  #mapping = null;
  #pressed = new Set();
  #orders;
  #arm;

  constructor(orders, arm) {
    this.#orders = orders;
    this.#arm = arm;
  }

  get id() {
    return this.#index === null ? "" : this.#id;
  }

  // The device itself, as it is now.
  get device() {
    return all().find((pad) => pad.index === this.#index) ?? null;
  }

  reread() {
    this.#mapping = mappingOf(this.#id);
  }

  // Nobody moves it while it is being calibrated.
  read(isActive) {
    const pad = this.#chosen();
    if (!pad) return REST;
    const names = Object.keys(BUTTONS);
    const pressed = new Set(names.filter((name) => isActive && isDown(pad, this.#mapping.buttons[name])));
    for (const name of names) {
      if (name !== "arm") this.#orders.hold(name, "gamepad", pressed.has(name));
      else if (pressed.has(name) && !this.#pressed.has(name)) this.#arm();
    }
    this.#pressed = pressed;
    if (!isActive) return REST;
    return Object.fromEntries(AXES.map((axis) => [axis, deflection(this.#mapping.axes[axis], pad.axes)]));
  }

  #chosen() {
    const pads = all();
    const touched = pads.find(isTouched);
    const now = touched ?? pads.find((pad) => pad.index === this.#index) ?? pads[0] ?? null;
    if (!now) {
      if (this.#index !== null) this.#unplugged();
      return null;
    }
    if (now.index !== this.#index || now.id !== this.#id) {
      this.#index = now.index;
      this.#id = now.id;
      this.reread();
    }
    this.lost = "";
    return now;
  }

  #unplugged() {
    this.lost = this.#id;
    this.#index = null;
    this.#pressed.clear();
    for (const name of Object.keys(BUTTONS)) this.#orders.hold(name, "gamepad", false);
  }
}

function all() {
  return [...navigator.getGamepads()].filter((pad) => pad?.connected);
}

function isDown(pad, index) {
  return Boolean(pad.buttons[index]?.pressed);
}

// Triggers of some devices rest at -1: only what is pressed, or a stick's axis, counts.
function isTouched(pad) {
  const isMoved = pad.axes.slice(0, 4).some((value) => Math.abs(value) > TOUCHED);
  return isMoved || pad.buttons.some((button) => button.pressed);
}
