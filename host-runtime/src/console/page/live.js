// The socket /live: what the operator's loop knows comes in, thirty times a second; buttons go out.
//
// Events: "hello" (views), "live" (control, snapshot), "refused" (what, why), "lost".

const RETRY_MS = [200, 500, 1000, 2000];

// What is sent to a line that takes nothing would be old when it gets there.
const MOST_WAITING = 2048;

export class Live extends EventTarget {
  // Our newest knowledge of the operator's clock: it goes back with each "hold".
  shownUs = 0;
  // The newest message, and when it came by this page's clock.
  newest = null;
  heardMs = -Infinity;
  #socket = null;
  #tries = 0;

  constructor() {
    super();
    this.#connect();
  }

  get isOpen() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  // How long nothing has come, milliseconds.
  get silentMs() {
    return performance.now() - this.heardMs;
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
    socket.onmessage = (event) => this.#hear(JSON.parse(event.data));
    socket.onclose = () => {
      this.dispatchEvent(new Event("lost"));
      const wait = RETRY_MS[Math.min(this.#tries++, RETRY_MS.length - 1)];
      setTimeout(() => this.#connect(), wait);
    };
  }

  #hear(message) {
    if (message.type === "live") {
      this.shownUs = message.now_us;
      this.newest = message;
      this.heardMs = performance.now();
      this.#tries = 0;
    }
    this.dispatchEvent(new CustomEvent(message.type, { detail: message }));
  }
}
