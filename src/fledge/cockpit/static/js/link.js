// The line to the server: one WebSocket that comes back by itself, and the newest message of each kind.
//
// Whoever wants to know says so: `link.on("frame", (frame) => ...)`. Beside the server's kinds there are three of the
// line's own: `open`, `closed` (with the milliseconds until the next try), and `video` (a JPEG, as a Blob).

const FIRST_WAIT = 500; // [ms]; chosen: a server that is started again is back in about a second
const LONGEST_WAIT = 8_000; // [ms]

export class Link {
  latest = {};
  #listeners = new Map();
  #socket = null;
  #wait = FIRST_WAIT;
  #retry = 0;

  constructor(address) {
    this.address = address;
  }

  get isOpen() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  // What came before somebody listened is said once more, so that nobody depends on who was first.
  on(kind, listener) {
    this.#listeners.set(kind, [...(this.#listeners.get(kind) ?? []), listener]);
    if (kind in this.latest) listener(this.latest[kind]);
  }

  send(kind, fields = {}) {
    if (this.isOpen) this.#socket.send(JSON.stringify({ kind, ...fields }));
  }

  connect() {
    clearTimeout(this.#retry);
    const socket = new WebSocket(this.address);
    socket.binaryType = "blob";
    socket.onopen = () => {
      this.#wait = FIRST_WAIT;
      this.#tell("open");
    };
    socket.onmessage = ({ data }) => this.#hear(data);
    socket.onclose = () => this.#closed();
    this.#socket = socket;
  }

  connectNow() {
    if (this.#socket?.readyState === WebSocket.CLOSED) this.connect();
  }

  #hear(data) {
    if (typeof data !== "string") {
      this.#tell("video", data);
      return;
    }
    const { kind, ...message } = JSON.parse(data);
    this.latest[kind] = message;
    this.#tell(kind, message);
  }

  #closed() {
    // Half of the wait is chance: a hundred spectators do not come back in the same instant.
    const wait = this.#wait * (0.5 + 0.5 * Math.random());
    this.#wait = Math.min(2 * this.#wait, LONGEST_WAIT);
    this.latest = {};
    this.#tell("closed", wait);
    this.#retry = setTimeout(() => this.connect(), wait);
  }

  #tell(kind, message) {
    for (const listener of this.#listeners.get(kind) ?? []) listener(message);
  }
}
