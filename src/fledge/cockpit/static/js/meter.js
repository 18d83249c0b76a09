// What is measured of late: the median of values, and how often something happens.

const KEPT = 60;
const WINDOW = 2_000; // [ms]

export class Median {
  #values = [];

  add(value) {
    this.#values.push(value);
    if (this.#values.length > KEPT) this.#values.shift();
  }

  clear() {
    this.#values = [];
  }

  get value() {
    const sorted = this.#values.toSorted((a, b) => a - b);
    return sorted.length ? sorted[sorted.length >> 1] : null;
  }
}

export class Rate {
  #times = [];

  count(now) {
    this.#times.push(now);
  }

  // Per second.
  at(now) {
    this.#times = this.#times.filter((time) => now - time < WINDOW);
    return this.#times.length > 1 ? ((this.#times.length - 1) * 1_000) / (now - this.#times[0]) : 0;
  }
}
