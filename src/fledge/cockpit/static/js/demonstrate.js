// Demonstrations of the sub-tasks: choose one, fly it with its own axes only, keep it or throw it away.
//
// The server numbers a sub-task's flights, and every number has a scene of its own: those of `fledge demonstrate` with
// seed 0. Who throws a flight away may try the same scene again.

import { launch } from "./launch.js";
import { $, make, say } from "./page.js";
import { maySit } from "./seat.js";
import { AXES, title } from "./words.js";

const COUNT = 3; // [s] to put one's hands on the sticks
const NET = "stop-tube";
const HELP =
  "Keep the blue circle on the dashed one, and its dot on the red one. Only the sub-task's own axes count. " +
  "After 3, 2, 1 it flies by your sticks.";
const STORING = "It is being stored, and the synthetic operator flies the same scene for comparison.";

export class Demonstrate {
  #link;
  #sticks;
  #route;
  #tape;
  #task = "";
  #isBegun = false;
  #timer = 0;

  constructor(link, sticks, route, tape) {
    this.#link = link;
    this.#sticks = sticks;
    this.#route = route;
    this.#tape = tape;
    route.onChange(() => this.#limit());
    link.on("welcome", ({ tasks }) => this.#offer(tasks));
    link.on("harvest", () => this.#progress());
    link.on("flight", (flight) => this.#follow(flight));
    link.on("frame", () => {
      this.#countDown();
      this.#allow();
    });
    link.on("seat", () => this.#allow());
    link.on("stored", (stored) => this.#score(stored));
    link.on("closed", () => this.#stopCount());
    link.on("notice", ({ level }) => level === "error" && this.#stopCount());
    say($("record-help"), HELP);
    $("record").addEventListener("click", () => this.#record());
    $("keep").addEventListener("click", () => say($("record-help"), STORING));
  }

  #offer(tasks) {
    const names = tasks.map(({ name }) => name);
    if (!names.includes(this.#task)) this.#task = names[0] ?? "";
    $("tasks").replaceChildren(...tasks.map(({ name, axes, goal }) => {
      const bar = make("progress", { max: goal || 1, value: 0, "aria-label": `Rows of ${title(name)}` });
      const card = make(
        "button",
        { type: "button", class: "task", "data-task": name },
        make("strong", {}, title(name)),
        make("span", { class: "soft" }, axes.map((axis) => AXES[axis]).join(", ")),
        bar,
        make("span", { class: "count" }),
      );
      card.addEventListener("click", () => this.#choose(name));
      return card;
    }));
    this.#choose(this.#task);
    this.#progress();
  }

  #choose(name) {
    this.#task = name;
    for (const card of $("tasks").children) card.setAttribute("aria-pressed", String(card.dataset.task === name));
    say($("record-label"), `Record ${title(name).toLowerCase()}`);
    this.#limit();
    this.#allow();
  }

  // Here the sticks have the sub-task's own axes alone.
  #limit() {
    const task = this.#link.latest.welcome?.tasks.find(({ name }) => name === this.#task);
    const isHere = this.#route.view === "demonstrate" && task;
    this.#sticks.only = isHere ? task.axes.map((axis) => AXES[axis]) : AXES;
  }

  #heap(name) {
    return this.#link.latest.harvest?.heaps.find(({ manoeuvre }) => manoeuvre === name) ?? { flights: 0, rows: 0 };
  }

  #progress() {
    const { welcome } = this.#link.latest;
    for (const card of $("tasks").children) {
      const { goal } = welcome.tasks.find(({ name }) => name === card.dataset.task);
      const { flights, rows } = this.#heap(card.dataset.task);
      card.querySelector("progress").value = goal ? Math.min(rows, goal) : Number(rows > 0);
      const of = goal ? ` of ${goal.toLocaleString("en")}` : "";
      card.title = `${flights} flight${flights === 1 ? "" : "s"}`;
      say(card.querySelector(".count"), `${rows.toLocaleString("en")}${of} rows`);
      card.classList.toggle("done", goal > 0 && rows >= goal);
    }
  }

  #allow() {
    $("record").disabled = !this.#task || !maySit(this.#link) || this.#tape.isOpen;
  }

  #record() {
    $("score").hidden = true;
    $("record-help").hidden = false;
    say($("record-help"), HELP);
    this.#isBegun = true;
    const { nets } = this.#link.latest.welcome;
    launch(this.#link, {
      manoeuvre: this.#task,
      pilot: "person",
      net: nets.includes(NET) ? NET : nets[0],
      record: "demonstration",
    });
  }

  // While a flight is prepared there is none; whatever else is not ours to arm.
  #follow({ state, record }) {
    const isOurs = state === "none" || (state === "running" && record === "demonstration");
    if (!isOurs) this.#stopCount();
    this.#allow();
  }

  // From the moment at which the flight can be armed: 3, 2, 1, and it is.
  #countDown() {
    if (!this.#isBegun || this.#timer || !this.#sticks.canArm) return;
    let left = COUNT;
    const step = () => {
      say($("countdown"), left ? String(left) : "Fly");
      $("countdown").hidden = false;
      if (!left) this.#sticks.arm();
      this.#timer = setTimeout(left ? step : () => this.#stopCount(), 1_000);
      left -= 1;
    };
    step();
  }

  #stopCount() {
    clearTimeout(this.#timer);
    this.#timer = 0;
    this.#isBegun = false;
    $("countdown").hidden = true;
  }

  #score({ name, rows, marks, synthetic }) {
    const figures = [
      ["Distance", ({ distance }) => `${distance.toFixed(1)} px`],
      ["Radius error", ({ radius }) => `${radius.toFixed(1)} px`],
      ["UGVs in view", ({ in_view: share }) => `${(100 * share).toFixed(1)} %`],
    ];
    say($("score-title"), `${name}: ${rows.toLocaleString("en")} rows`);
    $("score-rows").replaceChildren(...figures.map(([what, word]) => make(
      "tr",
      {},
      make("th", { scope: "row" }, what),
      make("td", {}, word(marks)),
      make("td", {}, synthetic ? word(synthetic) : "–"),
    )));
    $("score").hidden = false;
    $("record-help").hidden = true;
    this.#allow();
  }
}
