// Who is in command of a vehicle, in which mode it is, and why it is not sent what was proposed: said as soon as it
// changes. The vehicle is the one whose sticks this page has; one may choose another.

import { $, icon, make, say } from "./page.js";
import { MODES, commander, layer, noted, why } from "./words.js";

const GROUNDED = new Set(["INIT", "READY"]);

export function startSituation(link, sticks) {
  const choose = (vehicle) => {
    sticks.vehicle = vehicle;
    if (link.latest.frame) show(link.latest, vehicle);
  };
  link.on("flight", ({ names }) => offer(names, sticks, choose));
  link.on("frame", () => show(link.latest, sticks.vehicle));
  link.on("closed", () => forget("Nobody knows"));
  link.on("flight", ({ state }) => state === "none" && forget("Nobody"));
}

function offer(names, sticks, choose) {
  const group = $("vehicles");
  const shown = [...group.children].map((button) => button.dataset.name);
  if (shown.join("\n") === names.join("\n")) return;
  group.replaceChildren(...names.map((name, vehicle) => {
    const title = `Sticks to ${name} (key ${vehicle})`;
    const button = make("button", { type: "button", "data-name": name, title }, icon("person"), name);
    button.addEventListener("click", () => choose(vehicle));
    return button;
  }));
  if (sticks.vehicle >= names.length) choose(0);
}

function forget(who) {
  say($("commander"), who, "nobody");
  say($("mode"), "–", "");
  say($("why"), "–", "");
  $("situation").dataset.commander = "nobody";
  $("commander-icon").firstElementChild.setAttribute("href", "#i-nobody");
}

function show({ flight, frame }, chosen) {
  const { mode, reason, commander: who } = frame.vehicles[chosen] ?? frame.vehicles[0];
  const [name, meaning] = MODES[mode] ?? [mode, ""];
  say($("mode"), name, mode);
  $("mode").title = meaning;
  say($("commander"), commander(who, flight), who);
  $("commander-icon").firstElementChild.setAttribute("href", `#i-${who}`);
  $("situation").dataset.commander = who;
  const isMine = mode === "AUTO" && who === "person";
  const calm = isMine ? "The sticks are obeyed." : meaning;
  // On the ground what is missing comes first, in the air what the vehicle is kept from.
  const because = reason === "NONE" ? "" : why(reason);
  const note = noted(frame.note);
  say($("why"), (GROUNDED.has(mode) ? note || because : because || note) || calm, reason);
  $("why").title = $("why").textContent;
  $("why").dataset.layer = layer(reason);
  [...$("vehicles").children].forEach((button, vehicle) => {
    const by = frame.vehicles[vehicle]?.commander ?? "nobody";
    button.setAttribute("aria-pressed", String(vehicle === chosen));
    if (button.dataset.commander === by) return;
    button.dataset.commander = by;
    button.firstElementChild.firstElementChild.setAttribute("href", `#i-${by}`);
  });
}
