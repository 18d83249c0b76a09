// Small verbs for the document.

export const $ = (id) => document.getElementById(id);

// Text changes only when it does: a screen reader would say everything thirty times a second.
export function say(element, text, value = text) {
  if (element.textContent !== text) element.textContent = text;
  if (element.dataset.value !== String(value)) element.dataset.value = value;
}

export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

export function icon(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const use = document.createElementNS("http://www.w3.org/2000/svg", "use");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  use.setAttribute("href", `#i-${name}`);
  svg.append(use);
  return svg;
}

// Fills a select; what was chosen stays chosen, or else what is preferred, or else the first.
export function choices(select, values, word, preferred) {
  const wanted = [select.value, ...[preferred].flat()].find((value) => values.includes(value)) ?? values[0] ?? "";
  const now = [...select.options].map((option) => option.value);
  if (now.join("\n") !== values.join("\n")) {
    select.replaceChildren(...values.map((value) => new Option(word(value), value)));
  }
  select.value = wanted;
}

// What this browser remembers; it may be forbidden to.
export function remembered(key, otherwise) {
  try {
    return JSON.parse(localStorage.getItem(`fledge.${key}`)) ?? otherwise;
  } catch {
    return otherwise;
  }
}

export function remember(key, value) {
  try {
    localStorage.setItem(`fledge.${key}`, JSON.stringify(value));
  } catch {
    // Private windows refuse; then it is forgotten with the page.
  }
}
