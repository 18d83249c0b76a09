// The operator's seat: one page at a time has it, all others look on.

import { $, say } from "./page.js";

const LABELS = {
  free: ["Take the seat", "Nobody has the sticks"],
  mine: ["Leave the seat", "You have the sticks"],
  taken: ["Ask for the seat", "Somebody else has the sticks"],
  waiting: ["Stop waiting", "The sticks are yours when they are given up"],
};

// Whether this page may order things: the seat is its own, or free and taken on the way.
export function maySit(link) {
  return ["mine", "free"].includes(link.latest.seat?.seat);
}

export function sitDown(link) {
  if (link.latest.seat?.seat === "free") link.send("seat", { want: true });
}

export function startSeat(link) {
  const button = $("seat");
  button.addEventListener("click", () => {
    const { seat } = link.latest.seat;
    link.send("seat", { want: seat === "free" || seat === "taken" });
  });
  link.on("seat", ({ seat, spectators }) => {
    const [label, meaning] = LABELS[seat];
    button.disabled = false;
    button.dataset.seat = seat;
    say($("seat-label"), label);
    const others = seat === "mine" ? spectators : spectators - 1;
    say($("seat-meaning"), others > 0 ? `${meaning} · ${others} looking on` : meaning);
    document.body.dataset.seat = seat;
  });
  link.on("closed", () => {
    button.disabled = true;
    document.body.dataset.seat = "";
  });
}
