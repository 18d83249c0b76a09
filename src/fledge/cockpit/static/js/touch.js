// Two sticks on the screen, to be moved by fingers or a mouse: the left one goes up and turns, the right one moves over
// the floor. They also show what all other devices say.

const RADIUS = 0.32; // of the pad's width: how far the knob goes
const KNOB = 0.36; // of the pad's width: the knob, as in the style sheet

export class TouchSticks {
  #at = { forward: 0, left: 0, up: 0, turn: 0 };
  #pads;

  constructor(left, right) {
    this.#pads = [
      { element: left, vertical: "up", horizontal: "turn" },
      { element: right, vertical: "forward", horizontal: "left" },
    ];
    for (const pad of this.#pads) this.#follow(pad);
  }

  read() {
    return this.#at;
  }

  // Right and down are where a pointer goes; left, counter-clockwise and up are where numbers grow.
  show(sticks) {
    const { axes } = sticks;
    for (const { element, vertical, horizontal } of this.#pads) {
      // In per cent of the knob's own size, so that nothing has to be measured.
      const [right, down] = [horizontal, vertical].map((axis) => (-100 * axes[axis] * RADIUS) / KNOB);
      const place = `translate(${right.toFixed(1)}%, ${down.toFixed(1)}%)`;
      const { style } = element.firstElementChild;
      if (style.transform !== place) style.transform = place;
      element.querySelector(".up").classList.toggle("idle", !sticks.counts(vertical));
      element.querySelector(".left").classList.toggle("idle", !sticks.counts(horizontal));
    }
  }

  #follow({ element, vertical, horizontal }) {
    const drag = (event) => {
      if (!element.hasPointerCapture(event.pointerId)) return;
      const box = element.getBoundingClientRect();
      const reach = RADIUS * box.width;
      const left = (box.left + box.width / 2 - event.clientX) / reach;
      const up = (box.top + box.height / 2 - event.clientY) / reach;
      const length = Math.max(1, Math.hypot(left, up));
      this.#at[horizontal] = left / length;
      this.#at[vertical] = up / length;
    };
    const letGo = () => {
      this.#at[horizontal] = 0;
      this.#at[vertical] = 0;
    };
    element.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      element.setPointerCapture(event.pointerId);
      drag(event);
    });
    element.addEventListener("pointermove", drag);
    element.addEventListener("lostpointercapture", letGo);
  }
}
