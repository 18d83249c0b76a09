// Training on what was recorded: choose a set-up, watch the loss, fly the result.

import { Paper } from "./canvas.js";
import { paintCurve } from "./curve.js";
import { $, choices, make, say } from "./page.js";
import { maySit, sitDown } from "./seat.js";
import { title } from "./words.js";

export class Train {
  #link;
  #paper;
  #points = [];

  constructor(link, fly) {
    this.#link = link;
    this.#paper = new Paper($("curve"), () => this.redraw());
    link.on("welcome", ({ setups }) => this.#offer(setups));
    link.on("harvest", () => this.#count());
    link.on("lesson", (lesson) => this.#learn(lesson));
    link.on("seat", () => this.#allow());
    // On joining the server tells the whole curve anew.
    link.on("open", () => (this.#points = []));
    link.on("closed", () => this.#allow());
    $("lesson-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#start();
    });
    $("cancel").addEventListener("click", () => link.send("cancel"));
    $("fly-it").addEventListener("click", () => fly(link.latest.lesson.policy));
    this.#allow();
  }

  redraw() {
    paintCurve(this.#paper, this.#points, this.#link.latest.lesson?.epochs ?? 0);
  }

  #start() {
    const epochs = $("epochs").value;
    sitDown(this.#link);
    this.#link.send("train", {
      setup: $("setup").value,
      epochs: epochs ? Number(epochs) : null,
      takeovers: $("takeovers").checked,
    });
  }

  #offer(setups) {
    choices($("setup"), setups, title, "primitive");
    this.#count();
    this.#allow();
  }

  #count() {
    const { welcome, harvest } = this.#link.latest;
    const heaps = harvest?.heaps ?? [];
    $("heaps").replaceChildren(...(welcome?.tasks ?? []).map(({ name, goal }) => {
      const rows = heaps.find(({ manoeuvre }) => manoeuvre === name)?.rows ?? 0;
      const of = goal ? ` of ${goal.toLocaleString("en")}` : "";
      const count = make("span", { class: "count soft" }, `${rows.toLocaleString("en")}${of} rows`);
      const value = goal ? Math.min(rows, goal) : 0;
      const bar = make("progress", { max: goal || 1, value, "aria-label": title(name) });
      return make("li", {}, make("span", {}, title(name)), count, bar);
    }));
  }

  #learn(lesson) {
    // A training begins without a point, whoever has started it.
    if (lesson.state === "running" && !lesson.epoch) this.#points = [];
    this.#points.push(...lesson.points);
    say($("lesson"), told(lesson, this.#points.at(-1)), lesson.state);
    $("lesson-bar").max = lesson.epochs || 1;
    $("lesson-bar").value = lesson.epoch;
    this.#allow();
    this.redraw();
  }

  #allow() {
    const { welcome, lesson } = this.#link.latest;
    const isRunning = lesson?.state === "running";
    const isSeated = maySit(this.#link);
    $("train").disabled = !welcome || isRunning || !isSeated;
    $("cancel").disabled = !isRunning || !isSeated;
    $("fly-it").hidden = lesson?.state !== "done" || !welcome?.pilots.includes(lesson.policy);
    $("fly-it").disabled = !isSeated;
  }
}

function told({ state, setup, policy, epoch, epochs, problem }, point) {
  const loss = point ? `, held-out loss ${point[2].toPrecision(3)}` : "";
  return {
    none: "No training yet.",
    running: `${title(setup)}: epoch ${epoch.toLocaleString("en")} of ${epochs.toLocaleString("en")}${loss}`,
    done: `${title(setup)} is trained: ${policy}${loss}`,
    failed: `It did not work: ${problem}`,
    cancelled: "Cancelled.",
  }[state];
}
