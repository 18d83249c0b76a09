// The gamepad's dialog: see what it says, learn which axis and button is which, and how far its sticks go.

import { BUTTONS, deflection, forgetMapping, keepMapping, mappingOf } from "./mapping.js";
import { $, make, say } from "./page.js";
import { AXES, title } from "./words.js";

const PERIOD = 30; // [ms]
const SELDOM = 250; // [ms]
const FAR = 0.5; // from the middle: what nobody moves by accident
const HOLD = 600; // [ms] that a stick is watched at its stop, or at rest
const ABSENT = "Connect a gamepad and press one of its buttons: browsers show it only then, and only to secure pages.";
const WAYS = {
  forward: ["forward", "backward"],
  left: ["to the left", "to the right"],
  up: ["up", "down"],
  turn: ["to turn left", "to turn right"],
};

export function startPadDialog(pads) {
  const dialog = $("pad-dialog");
  const learn = lessons(dialog, pads);
  $("pad").addEventListener("click", () => dialog.showModal());
  $("calibrate").addEventListener("click", () => learn(async (school) => {
    for (const axis of AXES) await school.axis(axis);
  }));
  $("forget").addEventListener("click", () => {
    forgetMapping(pads.id);
    pads.reread();
  });
  const axes = AXES.map((axis) => {
    const gauge = make("span", { class: "gauge" }, make("span"));
    return row($("pad-axes"), title(axis), gauge, () => learn((school) => school.axis(axis)));
  });
  const buttons = Object.entries(BUTTONS).map(([name, word]) => {
    return row($("pad-buttons"), word, make("span"), () => learn((school) => school.button(name)));
  });
  setInterval(() => dialog.open && show(pads, axes, buttons), PERIOD);
  setInterval(() => say($("pad-label"), pads.id ? short(pads.id) : "No gamepad"), SELDOM);
}

function row(table, word, gauge, learn) {
  const set = make("button", { type: "button", class: "set", "aria-label": `Set ${word}` }, "Set");
  set.addEventListener("click", learn);
  const cells = [make("th", { scope: "row" }, word), make("td", {}, gauge), make("td", {}, set)];
  table.tBodies[0].append(make("tr", {}, ...cells));
  return gauge;
}

function show(pads, axes, buttons) {
  const pad = pads.device;
  for (const button of document.querySelectorAll("#pad-dialog .set, #calibrate, #forget")) button.disabled = !pad;
  if (!pad) {
    say($("pad-help"), ABSENT);
    return;
  }
  const mapping = mappingOf(pads.id);
  AXES.forEach((axis, i) => {
    axes[i].firstElementChild.style.left = `${50 + 50 * deflection(mapping.axes[axis], pad.axes)}%`;
  });
  Object.keys(BUTTONS).forEach((name, i) => {
    const index = mapping.buttons[name];
    say(buttons[i], `button ${index}${pad.buttons[index]?.pressed ? " ●" : ""}`);
  });
}

// One lesson at a time; it ends early with the dialog, or the gamepad.
function lessons(dialog, pads) {
  let isBusy = false;
  return async (lesson) => {
    if (isBusy) return;
    isBusy = true;
    const learnt = lesson(new School(dialog, pads));
    const said = await learnt.then(() => "That is kept for this device.", (left) => left.message);
    if (pads.device) say($("pad-help"), said);
    isBusy = false;
  };
}

class School {
  constructor(dialog, pads) {
    this.dialog = dialog;
    this.pads = pads;
    this.mapping = structuredClone(mappingOf(pads.id));
  }

  async axis(name) {
    const [there, back] = WAYS[name];
    const middle = await this.#rest("Let go of all sticks.");
    const high = await this.#stop(`Push the stick ${there}, as far as it goes, and hold it.`, middle);
    await this.#rest("Let go.");
    const low = await this.#stop(`Now ${back}, as far as it goes.`, middle, high.index);
    this.mapping.axes[name] = { index: high.index, low: low.value, middle: middle[high.index], high: high.value };
    this.#keep();
  }

  async button(name) {
    say($("pad-help"), `Press the button for: ${BUTTONS[name]}.`);
    const before = this.#pad.buttons.map(({ pressed }) => pressed);
    let index = -1;
    while (index < 0) {
      await this.#moment();
      index = this.#pad.buttons.findIndex(({ pressed }, i) => pressed && !before[i]);
    }
    this.mapping.buttons[name] = index;
    this.#keep();
  }

  get #pad() {
    const pad = this.dialog.open && this.pads.device;
    if (!pad) throw new Error("Nothing was changed.");
    return pad;
  }

  #keep() {
    keepMapping(this.pads.id, this.mapping);
    this.pads.reread();
  }

  async #moment() {
    await new Promise((resolve) => setTimeout(resolve, PERIOD));
  }

  // Raw values once nothing has moved for a while.
  async #rest(text) {
    say($("pad-help"), text);
    let [since, values] = [performance.now(), [...this.#pad.axes]];
    while (performance.now() - since < HOLD) {
      await this.#moment();
      const now = [...this.#pad.axes];
      if (now.some((value, i) => Math.abs(value - values[i]) > 0.05)) [since, values] = [performance.now(), now];
    }
    return values;
  }

  // The axis that is moved far from its middle, and how far it got.
  async #stop(text, middle, only = -1) {
    say($("pad-help"), text);
    let found = null;
    let until = Infinity;
    while (performance.now() < until) {
      await this.#moment();
      this.#pad.axes.forEach((value, index) => {
        const way = Math.abs(value - middle[index]);
        if (way < (found ? Math.abs(found.value - middle[found.index]) : FAR) || (only >= 0 && index !== only)) return;
        if (!found) until = performance.now() + HOLD;
        found = { index, value };
      });
    }
    return found;
  }
}

function short(id) {
  return id.replace(/\s*\(.*$/, "") || "Gamepad";
}
