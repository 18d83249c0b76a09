// Which flight it is to be, and its start, pause and reset.

import { launch, relaunch } from "./launch.js";
import { $, choices, remember, remembered, say } from "./page.js";
import { maySit } from "./seat.js";
import { WORLDS, title } from "./words.js";

const PREFERRED = { manoeuvre: "combined", pilot: "person", net: "stop-tube", world: "simulator" };
const CHOSEN = ["manoeuvre", "pilot", "net", "world", "speed", "scene"];

export class Fly {
  #link;

  constructor(link) {
    this.#link = link;
    const before = { ...PREFERRED, ...remembered("flight", {}) };
    $("speed").value = before.speed ?? "1";
    $("scene").value = before.scene ?? "0";
    link.on("welcome", (welcome) => this.#offer(welcome, before));
    link.on("flight", () => this.#allow());
    link.on("seat", () => this.#allow());
    link.on("closed", () => this.#allow());
    $("flight-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.start();
    });
    $("pause").addEventListener("click", () => link.send(link.latest.flight.state === "paused" ? "resume" : "pause"));
    $("reset").addEventListener("click", () => relaunch(link));
    this.#allow();
  }

  // With a policy that was just trained, say; otherwise as chosen.
  start(pilot = $("pilot").value) {
    $("pilot").value = pilot;
    remember("flight", Object.fromEntries(CHOSEN.map((id) => [id, $(id).value])));
    launch(this.#link, {
      manoeuvre: $("manoeuvre").value,
      pilot,
      net: $("net").value,
      world: $("world").value,
      speed: Number($("speed").value),
      seed: Number($("scene").value),
      record: $("record-flight").checked ? "flight" : "nothing",
    });
  }

  // A flight that another process flies can be joined, and no more.
  get #isOurs() {
    return !this.#link.latest.welcome?.worlds.includes("attached");
  }

  #join(flight) {
    for (const id of ["manoeuvre", "pilot", "net"]) choices($(id), [flight[id]], title, []);
  }

  #offer({ tasks, pilots, nets, worlds }, before) {
    const names = tasks.map(({ name }) => name);
    choices($("manoeuvre"), names, title, [before.manoeuvre, PREFERRED.manoeuvre]);
    choices($("pilot"), pilots, (name) => (name === "person" ? "Me" : title(name)), [before.pilot, PREFERRED.pilot]);
    choices($("net"), nets, title, [before.net, PREFERRED.net]);
    choices($("world"), worlds, (name) => WORLDS[name], [before.world, PREFERRED.world]);
    this.#allow();
  }

  #allow() {
    const { welcome, flight, seat } = this.#link.latest;
    const isOurs = this.#isOurs;
    const isMine = isOurs && seat?.seat === "mine";
    const isUnder = flight?.state === "running" || flight?.state === "paused";
    if (!isOurs && flight) this.#join(flight);
    for (const id of [...CHOSEN, "record-flight"]) $(id).disabled = !isOurs;
    $("start").disabled = !welcome || !isOurs || !maySit(this.#link);
    $("pause").disabled = !isMine || !isUnder;
    $("reset").disabled = !isMine || !flight || flight.state === "none";
    say($("pause-label"), flight?.state === "paused" ? "Resume" : "Pause");
  }
}
