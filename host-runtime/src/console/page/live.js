// The socket /live: what the operator's loop knows comes in, thirty times a second; buttons go out.
//
// Events: "hello" (views), "live" (control, snapshot), "refused" (what, why), "echo", "lost".

import { LineClock } from "./line-clock.js";

const RETRY_MS = [200, 500, 1000, 2000];

// What is sent to a line that takes nothing would be old when it gets there.
const MOST_WAITING = 2048;

// How often the console is asked for an echo, by which the line is measured, and how many may be on their way.
const ECHO_MS = 250;
const MOST_ECHOES = 60;

export class Live extends EventTarget {
  // Our newest knowledge of the operator's clock: it goes back with each "hold".
  shownUs = 0;
  // The newest message, and when it came by this page's clock.
  newest = null;
  heardMs = -Infinity;
  // The operator's clock.
  clock = new LineClock();
  #tripMs = null;
  // when echoes that have not come were asked for
  #asked = [];
  #socket = null;
  #tries = 0;
  // Why there is no connection, in words, where the console says so.
  why = null;

  constructor() {
    super();
    this.#connect();
    setInterval(() => this.#ask(), ECHO_MS);
  }

  get isOpen() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  // How long nothing has come, milliseconds.
  get silentMs() {
    return performance.now() - this.heardMs;
  }

  // There and back, milliseconds: of the last echo, or of one that has taken longer already; null: none came yet.
  get tripMs() {
    return this.#tripMs === null ? null : Math.max(this.#tripMs, this.#asked.length ? performance.now() - this.#asked[0] : 0);
  }

  // How old the newest of what the page shows is, milliseconds, its way here included; null where that is not known.
  get age() {
    return this.newest ? this.clock.age(this.newest.now_us) : null;
  }

  // Whether it was sent.
  send(message) {
    if (!this.isOpen || this.#socket.bufferedAmount > MOST_WAITING) return false;
    this.#socket.send(JSON.stringify(message));
    return true;
  }

  #connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/live`);
    this.#socket = socket;
    // a console that was started again has another clock
    this.clock = new LineClock();
    this.#tripMs = null;
    this.#asked = [];
    let opened = false;
    socket.onopen = () => {
      opened = true;
      this.why = null;
      this.#ask();
    };
    socket.onmessage = (event) => this.#hear(JSON.parse(event.data));
    socket.onclose = () => {
      this.dispatchEvent(new Event("lost"));
      if (!opened) this.#askWhy();
      const wait = RETRY_MS[Math.min(this.#tries++, RETRY_MS.length - 1)];
      setTimeout(() => this.#connect(), wait);
    };
  }

  // A browser says of a socket that was refused only that it failed.
  async #askWhy() {
    let why = null;
    try {
      const answer = await fetch("/api/room", { cache: "no-store" });
      if (answer.status === 401) why = "signed out: load this page again";
      else if (!answer.ok) why = (await answer.text()).trim();
    } catch {
      // it is not there
    }
    if (!this.isOpen) this.why = why;
  }

  #ask() {
    const nowMs = performance.now();
    if (this.#asked.length >= MOST_ECHOES) return;
    if (this.send({ type: "echo", sent_us: Math.round(nowMs * 1000) })) this.#asked.push(nowMs);
  }

  #hear(message) {
    if (message.type === "echo") {
      const nowMs = performance.now();
      const sentMs = message.sent_us / 1000;
      this.#tripMs = nowMs - sentMs;
      this.#asked = this.#asked.filter((askedMs) => askedMs > sentMs + 0.5);
      this.clock.answered(sentMs, message.now_us, nowMs);
    } else if (message.type === "live") {
      this.clock.heard(message.now_us);
      this.shownUs = message.now_us;
      this.newest = message;
      this.heardMs = performance.now();
      this.#tries = 0;
    }
    this.dispatchEvent(new CustomEvent(message.type, { detail: message }));
  }
}
