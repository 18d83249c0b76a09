// Figures that are read in passing: four times a second is as often as anybody can.

import { $, say } from "./page.js";
import { STATES, clock } from "./words.js";

const PERIOD = 250; // [ms]
const SLOW = 0.9; // of the wanted speed; chosen
const LOW = 0.25; // of the battery; chosen
const LATE = 150; // [ms] from stick to picture; chosen: about when flying by hand gets hard

export function startInstruments(link, stage, sticks) {
  const state = () => {
    const { flight, frame } = link.latest;
    const isDone = flight?.state === "running" && frame?.over;
    say($("state"), isDone ? "Manoeuvre over" : STATES[flight?.state ?? "none"], flight?.state ?? "none");
  };
  for (const kind of ["flight", "frame", "closed"]) link.on(kind, state);
  setInterval(() => show(link.latest, stage, sticks), PERIOD);
}

function show({ flight, frame }, stage, sticks) {
  const isFlying = flight?.state === "running" && Boolean(frame);
  const latency = sticks.isMine ? stage.latency.value : null;
  const updates = stage.updates.at(performance.now());
  tell("latency", isFlying && latency !== null, () => [`${latency.toFixed(0)} ms`, latency], latency > LATE);
  tell("answer", frame?.answer != null, () => [`${frame.answer.toFixed(1)} ms`, frame.answer]);
  tell("silent", frame?.silent != null, () => [`${frame.silent.toFixed(2)} s`, frame.silent], frame?.silent > 0.4);
  tell("factor", isFlying, () => [`× ${frame.factor.toFixed(2)}`, frame.factor], frame?.factor < SLOW * flight?.speed);
  tell("updates", isFlying, () => [`${updates.toFixed(0)} /s`, updates], updates < 20);
  const battery = frame?.battery ?? null;
  tell("battery", battery !== null, () => [`${(100 * battery).toFixed(0)} %`, battery], battery < LOW);
  tell("time", Boolean(frame), () => [clock(frame.t), frame.t]);
}

function tell(id, isKnown, value, isBad = false) {
  const output = $(id);
  const [text, raw] = isKnown ? value() : ["–", ""];
  say(output, text, raw);
  output.classList.toggle("bad", isKnown && isBad);
}
