// The bar of a flight that is recorded: how many rows there are, an end to it, and whether they are kept.

import { $, say } from "./page.js";

export class Tape {
  #link;
  #isSettled = false;

  constructor(link) {
    this.#link = link;
    $("finish").addEventListener("click", () => link.send("pause"));
    for (const verb of ["keep", "discard"]) {
      $(verb).addEventListener("click", () => {
        link.send(verb);
        this.#settle();
      });
    }
    for (const kind of ["flight", "frame", "seat", "closed"]) link.on(kind, () => this.#show());
    link.on("stored", () => this.#settle());
    this.#show();
  }

  // Whether something is recorded that is neither kept nor thrown away yet.
  get isOpen() {
    const { flight } = this.#link.latest;
    return Boolean(flight) && flight.record !== "nothing" && flight.state !== "none" && !this.#isSettled;
  }

  #settle() {
    this.#isSettled = true;
    this.#show();
  }

  #show() {
    const { flight, frame, seat } = this.#link.latest;
    const isRunning = flight?.state === "running";
    const isMine = seat?.seat === "mine";
    if (isRunning) this.#isSettled = false;
    $("tape").hidden = !this.isOpen;
    $("tape").dataset.state = flight?.state ?? "none";
    say($("rows"), String(this.isOpen ? (frame?.rows ?? 0) : 0));
    $("finish").hidden = !isRunning;
    $("finish").disabled = !isMine;
    for (const id of ["keep", "discard"]) $(id).hidden = isRunning;
    $("keep").disabled = !isMine || !frame?.rows;
    $("discard").disabled = !isMine;
  }
}
