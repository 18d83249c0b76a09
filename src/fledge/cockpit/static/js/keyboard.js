// The keyboard as sticks: arrows move the vehicle over the floor, W and S up and down, A and D turn it.
//
// A key is all or nothing, and full stick is more than anybody needs to follow a UGV; so keys go to `REACH`, and there
// by degrees. Let go, they are at once in the middle.

import { AXES } from "./words.js";

const REACH = 0.7; // chosen: 0.7 m/s, where formations drive up to 0.4 m/s
const RISE = 2.5; // [1/s]; chosen: 0.3 s to full reach, as long as a person takes to react

const STICKS = {
  ArrowUp: ["forward", 1],
  ArrowDown: ["forward", -1],
  ArrowLeft: ["left", 1],
  ArrowRight: ["left", -1],
  KeyW: ["up", 1],
  KeyS: ["up", -1],
  KeyA: ["turn", 1],
  KeyD: ["turn", -1],
};
const HELD = { KeyT: "switch", KeyH: "hand_back", KeyL: "land", Escape: "stop", KeyN: "dead_man" };

// Whether keys belong to what has the focus: a list, a slider, a text, an open dialog.
function isTaken(event) {
  return event.ctrlKey || event.metaKey || event.altKey || Boolean(event.target.closest("select, input, dialog"));
}

export class Keyboard {
  #down = new Set();
  #at = { forward: 0, left: 0, up: 0, turn: 0 };
  #orders;

  // `commands` are verbs by key code, for what happens once per press.
  constructor(orders, isActive, commands) {
    this.#orders = orders;
    addEventListener("keydown", (event) => {
      if (!isActive() || isTaken(event)) return;
      const { code } = event;
      if (code in STICKS) event.preventDefault();
      if (event.repeat) return;
      this.#down.add(code);
      if (code in HELD) orders.hold(HELD[code], "keyboard", true);
      commands[code]?.();
    });
    addEventListener("keyup", ({ code }) => {
      this.#down.delete(code);
      if (code in HELD) orders.hold(HELD[code], "keyboard", false);
    });
    addEventListener("blur", () => this.letGo());
  }

  letGo() {
    this.#down.clear();
    for (const name of Object.values(HELD)) this.#orders.hold(name, "keyboard", false);
  }

  read(seconds) {
    const goal = { forward: 0, left: 0, up: 0, turn: 0 };
    for (const code of this.#down) {
      const [axis, sign] = STICKS[code] ?? [];
      if (axis) goal[axis] += sign * REACH;
    }
    for (const axis of AXES) {
      const at = Math.sign(this.#at[axis]) === Math.sign(goal[axis]) ? this.#at[axis] : 0;
      const step = RISE * seconds;
      this.#at[axis] = goal[axis] === 0 ? 0 : at + Math.max(-step, Math.min(step, goal[axis] - at));
    }
    return this.#at;
  }
}
