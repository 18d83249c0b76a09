// Lines from the server, for people: they go by themselves, errors later.

import { $, icon, make } from "./page.js";

const SHOWN = { info: 5_000, warning: 8_000, error: 12_000 }; // [ms]; chosen
const MOST = 4;

export function notice(text, level = "info") {
  const line = make("li", { class: `notice ${level}` }, icon(level), make("span", {}, text));
  const shown = $("notices");
  shown.append(line);
  while (shown.children.length > MOST) shown.firstElementChild.remove();
  setTimeout(() => line.remove(), SHOWN[level]);
}
