// What is wrong, in words, where nobody can miss it: the worst thing only, and what to do about it.

import { $, say } from "./page.js";

const PERIOD = 200; // [ms]
const STALE = 1_000; // [ms] without a frame while a flight runs
const UNHEARD = 0.4; // [s], as the server's watchdog

export function startBanner(link, stage, sticks, pads) {
  let nextTry = 0;
  let wasOpen = false;
  link.on("open", () => (wasOpen = true));
  link.on("closed", (wait) => (nextTry = performance.now() + wait));
  $("banner-act").addEventListener("click", () => link.connectNow());
  addEventListener("online", () => link.connectNow());
  setInterval(() => {
    const trouble = link.isOpen ? inFlight(link.latest, stage, sticks, pads) : disconnected(wasOpen, nextTry);
    $("banner").hidden = !trouble;
    if (!trouble) return;
    say($("banner-title"), trouble.title);
    say($("banner-text"), trouble.text);
    $("banner-act").hidden = link.isOpen;
  }, PERIOD);
}

function disconnected(wasOpen, nextTry) {
  if (!wasOpen) return { title: "No connection to the cockpit's server yet", text: "Is fledge cockpit running?" };
  const seconds = Math.max(0, Math.ceil((nextTry - performance.now()) / 1_000));
  const next = seconds ? `The next try is in ${seconds} s.` : "Trying again now.";
  return { title: "Connection lost", text: `${next} Without your sticks the vehicles brake and hold.` };
}

function inFlight({ flight, frame }, stage, sticks, pads) {
  const isRunning = flight?.state === "running";
  const age = performance.now() - stage.arrived;
  if (isRunning && age > STALE) {
    return { title: "The picture stands still", text: `It is ${(age / 1_000).toFixed(0)} s old. Do not fly by it.` };
  }
  if (pads.lost && sticks.isMine) {
    const text = `The sticks are in the middle. Plug it in again, or use the keyboard: ${pads.lost}`;
    return { title: "Gamepad unplugged", text };
  }
  if (isRunning && sticks.isMine && frame?.silent > UNHEARD) {
    return { title: "The server does not hear your sticks", text: "The vehicles brake and hold until it does." };
  }
  return null;
}
