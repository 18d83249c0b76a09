// The four views of one page: its address says which; nothing is loaded anew, so the flight goes on.

import { title } from "./words.js";

const VIEWS = ["fly", "demonstrate", "watch", "train"];

export class Route {
  #listeners = [];

  constructor() {
    for (const link of document.querySelectorAll("a[data-view]")) {
      link.addEventListener("click", (event) => {
        if (event.ctrlKey || event.metaKey || event.shiftKey) return;
        event.preventDefault();
        this.go(link.dataset.view);
      });
    }
    addEventListener("popstate", () => this.#show());
  }

  get view() {
    const name = location.pathname.split("/")[1];
    return VIEWS.includes(name) ? name : "fly";
  }

  onChange(listener) {
    this.#listeners.push(listener);
  }

  go(view) {
    if (view !== this.view) history.pushState(null, "", `/${view}`);
    this.#show();
  }

  start() {
    this.#show();
  }

  #show() {
    const { view } = this;
    document.body.dataset.room = view;
    document.title = `${title(view)} · fledge cockpit`;
    for (const section of document.querySelectorAll("[data-in]")) {
      section.hidden = !section.dataset.in.split(" ").includes(view);
    }
    for (const link of document.querySelectorAll("a[data-view]")) {
      if (link.dataset.view === view) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
    for (const listener of this.#listeners) listener(view);
  }
}
