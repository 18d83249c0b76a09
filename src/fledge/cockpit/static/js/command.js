// The buttons by which a person commands: arm, take over, hand back, stop, land; and the two for the worst of days.

import { orderButton, sureButton } from "./orders.js";
import { $, say } from "./page.js";
import { FLYING } from "./words.js";

const ORDERS = { takeover: "switch", handback: "hand_back", stop: "stop", land: "land", "without-net": "dead_man" };

export function startCommand(link, sticks, orders) {
  for (const [id, name] of Object.entries(ORDERS)) orderButton($(id), orders, name);
  sureButton($("terminate"), orders, "terminate");
  $("arm").addEventListener("click", () => sticks.arm());
  const allow = () => {
    const mode = link.latest.frame?.vehicles[0].mode ?? "";
    const isFlying = sticks.isSending && FLYING.has(mode);
    for (const id of Object.keys(ORDERS)) $(id).disabled = !isFlying;
    $("terminate").disabled = !sticks.isSending;
    $("arm").disabled = !sticks.canArm;
    const isComing = sticks.isSending && ["INIT", "READY"].includes(mode) && !sticks.canArm;
    say($("arm-label"), FLYING.has(mode) ? "Armed" : isComing ? "Getting ready" : "Arm");
  };
  for (const kind of ["frame", "flight", "seat", "closed"]) link.on(kind, allow);
  document.addEventListener("visibilitychange", allow);
  allow();
}
