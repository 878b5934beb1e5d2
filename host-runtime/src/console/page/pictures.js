// The socket /pictures: each view's newest picture, and when it was taken.
//
// The next picture of a view is asked for when the last one is drawn, so that a slow page gets fewer, never
// older ones.

import { inWords } from "./page.js";

// What is older is not to be steered by.
const STALE_MS = 500;

// An age that is known less well says so.
const VAGUE_MS = 100;

const RETRY_MS = 1000;

export class Pictures {
  #views;
  #show;
  #socket = null;
  #closed = false;

  // `show(view, picture, header)` draws one; the picture is closed after it.
  constructor(views, show) {
    this.#views = views;
    this.#show = show;
    document.addEventListener("visibilitychange", () => this.#attend());
    this.#attend();
  }

  // Nothing is shown any more.
  close() {
    this.#closed = true;
    this.#attend();
  }

  // Nobody looks at a hidden tab.
  #attend() {
    if (document.hidden || this.#closed) {
      this.#socket?.close();
      this.#socket = null;
    } else if (!this.#socket && this.#views.length) {
      const scheme = location.protocol === "https:" ? "wss" : "ws";
      const socket = new WebSocket(`${scheme}://${location.host}/pictures?views=${this.#views.join(",")}`);
      socket.binaryType = "arraybuffer";
      socket.onmessage = (event) => this.#hear(socket, event.data);
      socket.onclose = () => {
        if (this.#socket !== socket) return;
        this.#socket = null;
        setTimeout(() => this.#attend(), RETRY_MS);
      };
      this.#socket = socket;
    }
  }

  async #hear(socket, message) {
    const length = new DataView(message).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(message, 4, length)));
    try {
      const picture = await createImageBitmap(new Blob([new Uint8Array(message, 4 + length)], { type: "image/jpeg" }));
      // one of a console that is gone meanwhile is of another clock
      if (socket === this.#socket) this.#show(header.view, picture, header);
      picture.close();
    } finally {
      if (socket.readyState === WebSocket.OPEN) {
        socket.send(JSON.stringify({ type: "shown", view: header.view }));
      }
    }
  }
}

// Of the times at which several pictures were taken, the one to judge them all by; null where one has not come, or there
// are none.
export function worstOf(takenUs, clock) {
  if (!takenUs.length || takenUs.includes(null)) return null;
  return takenUs.find((us) => clock.age(us) === null) ?? Math.min(...takenUs);
}

// How old a picture is that was taken at a time of the operator's clock, in words; its way to this page included.
// One that may be too old counts as too old.
export function ageWords(takenUs, clock) {
  if (takenUs === null) return { stale: true, text: "no new picture yet" };
  const age = clock.age(takenUs);
  if (age === null) return { stale: true, text: "age not known yet" };
  const stale = age.ms + age.within > STALE_MS;
  const vague = age.within > VAGUE_MS ? `, give or take ${inWords(age.within)}` : "";
  return { stale, text: stale ? `STALE: ${(age.ms / 1000).toFixed(1)} s old${vague}` : `${age.ms.toFixed(0)} ms` };
}
