// What the server's names mean, in plain words.

export const MODES = {
  INIT: ["Getting ready", "It waits until nothing is missing."],
  READY: ["Ready", "It waits to be armed."],
  AUTO: ["Auto", "The pilot is obeyed."],
  SHIELDED: ["Shielded", "The net held something back just now."],
  RECOVER: ["Handing back", "The pilot is faded in again."],
  HOLD: ["Holding", "It holds until the fault is gone."],
  STOPPED: ["Stopped", "It holds until a person decides."],
  MANUAL: ["Manual", "A person's sticks are obeyed."],
  LAND: ["Landing", "It comes straight down."],
  TERMINATED: ["Motors off", "For good; reset the flight to go on."],
};

// Modes in which a vehicle obeys, or holds itself in the air.
export const FLYING = new Set(["AUTO", "SHIELDED", "RECOVER", "HOLD", "STOPPED", "MANUAL", "LAND"]);

const REASONS = {
  WALL: "too near to a wall",
  OBSTACLE: "too near to an obstacle",
  VEHICLE: "too near to another vehicle",
  FLOOR: "too near to the floor",
  CEILING: "too near to the ceiling",
  NOT_FINITE: "the command was no number",
  STALE: "its position is too old",
  FUTURE: "its position claims to be from the future",
  BACKWARD: "its positions came in the wrong order",
  DUPLICATE: "the same position came again and again",
  BAD_POSE: "its position makes no sense",
  JUMP: "its position jumped",
  SWAP: "two vehicles' positions changed places",
  POLICY_LATE: "the pilot has not decided in time",
  LINK_LOST: "nobody is heard at the sticks",
  BATTERY_LOW: "the battery is low",
  INCONSISTENT: "position and velocity contradict each other",
  CLOCK: "a clock is not to be trusted",
  NOT_READY: "not armed yet",
  TAKE_OVER: "a person took over",
  STOPPED: "a person ordered a stop",
  LANDING: "ordered to land",
  TERMINATED: "motors were switched off",
  RECOVERING: "the commands fade back to the pilot's",
};

const NET = new Set(["WALL", "OBSTACLE", "VEHICLE", "FLOOR", "CEILING", "NOT_FINITE"]);
const SUPERVISOR = new Set(["NOT_READY", "TAKE_OVER", "STOPPED", "LANDING", "TERMINATED", "RECOVERING"]);

// Of the safety net, which layer a reason belongs to: "net", "watchdog", "person", or "" for none.
export function layer(reason) {
  if (NET.has(reason)) return "net";
  if (SUPERVISOR.has(reason)) return "person";
  return reason in REASONS ? "watchdog" : "";
}

export function why(reason) {
  const words = REASONS[reason];
  if (!words) return "Nothing is held back.";
  const [first, ...rest] = NET.has(reason) ? `net: ${words}` : words;
  return `${first.toUpperCase()}${rest.join("")}.`;
}

export function commander(name, flight) {
  if (name === "pilot") return `Pilot: ${title(flight.pilot)}`;
  return { person: "A person", net: "The net", guidance: "Guidance", nobody: "Nobody" }[name] ?? name;
}

export const STATES = { none: "None", running: "Running", paused: "Paused", over: "Over" };
export const WORLDS = { simulator: "Simulator", twin: "Digital twin", attached: "The running flight" };
export const AXES = ["forward", "left", "up", "turn"];

// "fixed-altitude" -> "Fixed altitude", "policies/primitive-003.onnx" -> "primitive-003".
// How far a flight is that another process flies; whatever else it notes is what it lacks.
const PHASES = {
  wait: "Waits to be armed.",
  "take-off": "Takes off.",
  climb: "Climbs.",
  join: "Comes to its place over the UGVs.",
  fly: "",
  land: "Lands.",
  over: "The flight is over.",
};

export function noted(note) {
  return PHASES[note] ?? note;
}

export function title(name) {
  if (/[/.]/.test(name) || !name) return name.split("/").at(-1).replace(/\.onnx$/, "");
  const words = name.replaceAll(/[-_]/g, " ");
  return words[0].toUpperCase() + words.slice(1);
}

export function clock(seconds) {
  const tenths = Math.max(0, Math.floor(seconds * 10));
  const minutes = Math.floor(tenths / 600);
  return `${minutes}:${((tenths % 600) / 10).toFixed(1).padStart(4, "0")}`;
}
