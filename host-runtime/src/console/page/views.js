// The socket /pictures: each view's newest picture on a canvas, with what was seen in it marked.
//
// The next picture of a view is asked for when the last one is drawn, so that a slow page gets fewer, never
// older ones. A picture that is old is dimmed and says how old it is.

const STALE_MS = 500;
const RETRY_MS = 1000;

export class Views {
  #socket = null;
  #views = new Map();

  // `places`: view number -> figure with a canvas and a caption.
  constructor(places) {
    for (const [view, figure] of places) {
      const canvas = figure.querySelector("canvas");
      const stamp = figure.querySelector(".stamp");
      this.#views.set(view, { figure, canvas, stamp, takenMs: null });
    }
    document.addEventListener("visibilitychange", () => this.#attend());
    setInterval(() => this.#stamp(), 100);
    this.#attend();
  }

  // Nobody looks at a hidden tab.
  #attend() {
    if (document.hidden) {
      this.#socket?.close();
      this.#socket = null;
    } else if (!this.#socket) {
      const scheme = location.protocol === "https:" ? "wss" : "ws";
      const views = [...this.#views.keys()].join(",");
      const socket = new WebSocket(`${scheme}://${location.host}/pictures?views=${views}`);
      socket.binaryType = "arraybuffer";
      socket.onmessage = (event) => this.#show(socket, event.data);
      socket.onclose = () => {
        if (this.#socket !== socket) return;
        this.#socket = null;
        setTimeout(() => this.#attend(), RETRY_MS);
      };
      this.#socket = socket;
    }
  }

  async #show(socket, message) {
    const length = new DataView(message).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(message, 4, length)));
    const takenMs = performance.now() - header.age_us / 1000;
    try {
      const picture = await createImageBitmap(new Blob([new Uint8Array(message, 4 + length)], { type: "image/jpeg" }));
      const view = this.#views.get(header.view);
      draw(view.canvas, picture, header.balls);
      view.takenMs = takenMs;
      picture.close();
    } finally {
      if (socket.readyState === WebSocket.OPEN) {
        socket.send(JSON.stringify({ type: "shown", view: header.view }));
      }
    }
  }

  #stamp() {
    const now = performance.now();
    for (const { figure, stamp, takenMs } of this.#views.values()) {
      const age = takenMs === null ? null : now - takenMs;
      const stale = age === null || age > STALE_MS;
      figure.classList.toggle("stale", stale);
      stamp.textContent =
        age === null ? "no picture yet" : stale ? `STALE: ${(age / 1000).toFixed(1)} s old` : `${age.toFixed(0)} ms`;
    }
  }
}

const LETTERS = { red: "R", green: "G", blue: "B", yellow: "Y" };
// Lines tell how a ball is known; colours do not.
const DASHES = { visible: [], occluded: [10, 5], predicted: [2, 5] };

function draw(canvas, picture, balls) {
  if (canvas.width !== picture.width || canvas.height !== picture.height) {
    canvas.width = picture.width;
    canvas.height = picture.height;
  }
  const pen = canvas.getContext("2d");
  pen.drawImage(picture, 0, 0);
  pen.font = "bold 18px system-ui, sans-serif";
  for (const ball of balls) {
    if (!ball.centre) continue;
    const [u, v] = ball.centre;
    const radius = ball.diameter / 2;
    // twice, so that it shows on any background
    for (const [width, colour] of [[4, "#000"], [2, "#fff"]]) {
      pen.lineWidth = width;
      pen.strokeStyle = colour;
      pen.setLineDash(DASHES[ball.state] ?? []);
      pen.beginPath();
      pen.arc(u, v, radius, 0, 2 * Math.PI);
      pen.moveTo(u - 4, v);
      pen.lineTo(u + 4, v);
      pen.moveTo(u, v - 4);
      pen.lineTo(u, v + 4);
      pen.stroke();
    }
    pen.setLineDash([]);
    pen.lineWidth = 4;
    pen.strokeStyle = "#000";
    pen.fillStyle = "#fff";
    const place = [u + radius + 4, v - radius];
    pen.strokeText(LETTERS[ball.name], ...place);
    pen.fillText(LETTERS[ball.name], ...place);
  }
}
