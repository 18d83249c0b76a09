// Light or dark: as the system has it, until somebody says otherwise. And the colours, for those who paint.

import { remember, remembered } from "./page.js";

const dark = matchMedia("(prefers-color-scheme: dark)");
const root = document.documentElement;
let colours = null;

export function startTheme(button, changed) {
  const show = () => {
    const chosen = remembered("theme", "");
    const isDark = chosen ? chosen === "dark" : dark.matches;
    root.dataset.theme = isDark ? "dark" : "light";
    button.setAttribute("aria-pressed", String(isDark));
    colours = null;
    changed();
  };
  button.addEventListener("click", () => {
    remember("theme", root.dataset.theme === "dark" ? "light" : "dark");
    show();
  });
  dark.addEventListener("change", show);
  show();
}

// `palette().floor` is the style sheet's `--floor`.
export function palette() {
  if (!colours) {
    const style = getComputedStyle(root);
    colours = new Proxy({}, {
      get(known, name) {
        const property = `--${name.replaceAll(/[A-Z]/g, (letter) => `-${letter.toLowerCase()}`)}`;
        return (known[name] ??= style.getPropertyValue(property).trim());
      },
    });
  }
  return colours;
}
