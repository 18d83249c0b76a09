// What a person orders beside moving sticks: flags, by their names in the `sticks` message.
//
// An order comes from buttons, keys and gamepads alike. It is said as long as somebody holds it, and after a mere press
// for a moment, since one lost message must not lose an order. Handing back is a wish that the supervisor grants
// only once all is calm, so its moment is longer. What takes the net away ends with the hand that holds it.

const MOMENT = { hand_back: 1_200, dead_man: 0 }; // [ms]; the supervisor wants one second without an alarm
const SHORT = 300; // [ms]
const SURELY = 800; // [ms] that one must hold what cannot be undone
const LET_GO = ["pointerup", "pointercancel", "pointerleave"];

export class Orders {
  #until = {};
  #holders = {};

  press(name) {
    this.#until[name] = performance.now() + (MOMENT[name] ?? SHORT);
  }

  hold(name, holder, held) {
    const holders = (this.#holders[name] ??= new Set());
    if (held && !holders.has(holder)) this.press(name);
    if (held) holders.add(holder);
    else holders.delete(holder);
  }

  // Nobody orders anything any more: the window lost its focus, or the seat is gone.
  letGo() {
    this.#until = {};
    this.#holders = {};
  }

  says(name) {
    return Boolean(this.#holders[name]?.size) || performance.now() < (this.#until[name] ?? 0);
  }
}

// A button that orders while it is held; with the keyboard, Enter and Space press it.
export function orderButton(button, orders, name) {
  button.addEventListener("pointerdown", () => orders.hold(name, button, true));
  for (const end of LET_GO) button.addEventListener(end, () => orders.hold(name, button, false));
  button.addEventListener("click", () => orders.press(name));
}

// A button for what cannot be undone: it has to be held for a while.
export function sureButton(button, orders, name) {
  let timer = 0;
  const begin = () => {
    if (timer || button.disabled) return;
    button.classList.add("holding");
    timer = setTimeout(() => orders.press(name), SURELY);
  };
  const end = () => {
    clearTimeout(timer);
    timer = 0;
    button.classList.remove("holding");
  };
  button.addEventListener("pointerdown", begin);
  button.addEventListener("keydown", (event) => {
    if (event.key === "Enter" || event.key === " ") begin();
  });
  for (const kind of [...LET_GO, "keyup", "blur"]) button.addEventListener(kind, end);
}
