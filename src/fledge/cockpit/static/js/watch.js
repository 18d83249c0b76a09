// Stored flights: a list, and a player with a time line. A second flight can be laid over the first, by time since the
// beginning of each.

import { notice } from "./notices.js";
import { $, choices, make, say } from "./page.js";
import { Player } from "./player.js";
import { answer, Replay } from "./replay.js";
import { clock, title } from "./words.js";

export class Watch {
  #route;
  #player = new Player();
  #flights = [];
  #name = ""; // of what is shown
  #asked = ""; // of what is to be

  constructor(route) {
    this.#route = route;
    route.onChange((view) => (view === "watch" ? this.refresh() : this.#player.pause()));
    $("previous").addEventListener("click", () => this.#step(-1));
    $("next").addEventListener("click", () => this.#step(1));
    $("compare").addEventListener("change", () => this.#compare($("compare").value));
    addEventListener("keydown", (event) => this.#key(event));
  }

  redraw() {
    this.#player.redraw();
  }

  // The list anew; it may have grown while nobody looked.
  async refresh() {
    if (this.#route.view !== "watch") return;
    try {
      ({ flights: this.#flights } = await answer("/api/flights"));
    } catch (error) {
      notice(error.message, "error");
      return;
    }
    $("flights-empty").hidden = this.#flights.length > 0;
    $("flights").replaceChildren(...this.#flights.map((flight) => this.#item(flight)));
    const names = this.#flights.map(({ name }) => name);
    choices($("compare"), ["", ...names], (name) => name || "nothing");
    if (!names.includes(this.#name) && names.length) await this.#choose(names[0]);
    this.#mark();
  }

  #item({ name, manoeuvre, pilot, net, rows, seconds, modified }) {
    const when = new Date(1_000 * modified).toLocaleString([], { dateStyle: "medium", timeStyle: "short" });
    const button = make(
      "button",
      { type: "button", "data-flight": name, title: `${rows.toLocaleString("en")} rows, stored ${when}` },
      make("strong", {}, name),
      make("span", { class: "soft" }, `${title(manoeuvre)} · ${title(pilot)}`),
      make("span", { class: "soft" }, `${clock(seconds)} · behind ${title(net).toLowerCase()}`),
    );
    button.addEventListener("click", () => this.#choose(name));
    return make("li", {}, button);
  }

  // What was asked for last is shown, in whatever order the answers come; what is shown already does not begin again.
  async #choose(name) {
    if (name === this.#asked) return;
    this.#asked = name;
    const replay = await this.#fetched(name);
    if (this.#asked !== name) return;
    if (!replay) {
      this.#asked = this.#name;
      return;
    }
    this.#name = name;
    this.#player.show(replay);
    const { manoeuvre, pilot, net, marks } = replay.told;
    const about = [
      title(manoeuvre),
      `${title(pilot)} behind ${title(net).toLowerCase()}`,
      `distance ${marks.distance.toFixed(1)} px`,
      `radius error ${marks.radius.toFixed(1)} px`,
      `in view ${(100 * marks.in_view).toFixed(1)}\u00a0%`,
    ];
    say($("watched"), name);
    say($("watched-marks"), about.join(" · "));
    this.#mark();
  }

  async #compare(name) {
    this.#player.lay(name ? await this.#fetched(name) : null);
  }

  async #fetched(name) {
    try {
      return await Replay.fetch(name);
    } catch (error) {
      notice(`${name}: ${error.message}`, "error");
      return null;
    }
  }

  #mark() {
    for (const button of $("flights").querySelectorAll("button")) {
      const isChosen = button.dataset.flight === this.#name;
      button.setAttribute("aria-current", String(isChosen));
      if (isChosen) button.scrollIntoView({ block: "nearest" });
    }
  }

  #step(by) {
    const at = this.#flights.findIndex(({ name }) => name === this.#asked);
    const next = this.#flights[at + by];
    if (next) this.#choose(next.name);
  }

  #key(event) {
    const isOther = event.ctrlKey || event.altKey || event.metaKey || event.target.closest("select, dialog");
    if (isOther || this.#route.view !== "watch") return;
    const verbs = {
      " ": () => this.#player.toggle(),
      ArrowLeft: () => this.#player.move(event.shiftKey ? -20 : -1),
      ArrowRight: () => this.#player.move(event.shiftKey ? 20 : 1),
      Home: () => this.#player.seek(0),
      End: () => this.#player.seek(Infinity),
      PageUp: () => this.#step(-1),
      PageDown: () => this.#step(1),
    };
    const isButtons = event.key === " " && event.target.closest("button");
    if (!(event.key in verbs) || isButtons) return;
    event.preventDefault();
    verbs[event.key]();
  }
}
