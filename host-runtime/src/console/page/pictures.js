// The socket /pictures: each view's newest picture, and how old it is.
//
// The next picture of a view is asked for when the last one is drawn, so that a slow page gets fewer, never
// older ones.

// What is older is not to be steered by.
export const STALE_MS = 500;

const RETRY_MS = 1000;

export class Pictures {
  #views;
  #show;
  #socket = null;

  // `show(view, picture, header, takenMs)` draws one; the picture is closed after it.
  constructor(views, show) {
    this.#views = views;
    this.#show = show;
    document.addEventListener("visibilitychange", () => this.#attend());
    this.#attend();
  }

  // Nobody looks at a hidden tab.
  #attend() {
    if (document.hidden) {
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
    const takenMs = performance.now() - header.age_us / 1000;
    try {
      const picture = await createImageBitmap(new Blob([new Uint8Array(message, 4 + length)], { type: "image/jpeg" }));
      this.#show(header.view, picture, header, takenMs);
      picture.close();
    } finally {
      if (socket.readyState === WebSocket.OPEN) {
        socket.send(JSON.stringify({ type: "shown", view: header.view }));
      }
    }
  }
}

// How old a picture is, in words; with the age that the program tells where none has come to this page.
export function ageWords(takenMs) {
  if (takenMs === null) return { stale: true, text: "no picture yet" };
  const age = performance.now() - takenMs;
  const stale = age > STALE_MS;
  return { stale, text: stale ? `STALE: ${(age / 1000).toFixed(1)} s old` : `${age.toFixed(0)} ms` };
}
