// The beginning of a flight: the server prepares it for a second or two, and says meanwhile that there is none.

import { $, say } from "./page.js";
import { sitDown } from "./seat.js";

const NONE = ["No flight yet", "Choose one below and start it; then arm, and it flies."];
const SOON = ["The flight is being prepared", "In a moment it can be armed."];

export function startLaunch(link) {
  link.on("flight", ({ state }) => {
    $("empty").hidden = state !== "none";
    if (state !== "none") tell(NONE);
  });
  link.on("notice", ({ level }) => level === "error" && tell(NONE));
  link.on("closed", () => tell(NONE));
  tell(NONE);
}

export function launch(link, flight) {
  sitDown(link);
  link.send("fly", flight);
  tell(SOON);
}

export function relaunch(link) {
  link.send("reset");
  tell(SOON);
}

function tell([title, text]) {
  say($("empty-title"), title);
  say($("empty-text"), text);
}
