// Views on canvases: each view's newest picture, with what was seen in it marked. One that is old is dimmed
// and says how old it is.

import { ageWords, Pictures } from "./pictures.js";
import { write } from "./page.js";

export class Views {
  #views = new Map();
  #live;
  #pictures;
  #timer;

  // `places`: view number -> figure with a canvas and a caption; `live` knows the operator's clock.
  constructor(places, live) {
    this.#live = live;
    for (const [view, figure] of places) {
      const canvas = figure.querySelector("canvas");
      const stamp = figure.querySelector(".stamp");
      this.#views.set(view, { figure, canvas, stamp, takenUs: null, why: null });
    }
    this.#pictures = new Pictures([...this.#views.keys()], (number, picture, header) => {
      const view = this.#views.get(number);
      draw(view.canvas, picture, header.balls);
      view.takenUs = header.taken_us;
    });
    // a console that was started again has another clock, by which none of these was taken
    live.addEventListener("hello", () => {
      for (const view of this.#views.values()) view.takenUs = null;
    });
    this.#timer = setInterval(() => this.#stamp(), 100);
  }

  // Why a camera sends no pictures, where that is known.
  explain(cameras) {
    cameras.forEach((camera, at) => {
      const view = this.#views.get(camera.view ?? at);
      if (view) view.why = camera.no_picture;
    });
  }

  // There are other views now.
  close() {
    this.#pictures.close();
    clearInterval(this.#timer);
  }

  #stamp() {
    for (const { figure, stamp, takenUs, why } of this.#views.values()) {
      const { stale, text } = ageWords(takenUs, this.#live.clock);
      figure.classList.toggle("stale", stale);
      write(stamp, takenUs === null && why ? why : text);
    }
  }
}

// A figure for a view, with a canvas and a caption that its age is written into.
export function figureOf(name) {
  const figure = document.createElement("figure");
  const canvas = document.createElement("canvas");
  canvas.width = 640;
  canvas.height = 480;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", name);
  const caption = document.createElement("figcaption");
  const stamp = document.createElement("span");
  stamp.className = "stamp";
  caption.append(`${name} `, stamp);
  figure.append(canvas, caption);
  return figure;
}

const LETTERS = { red: "R", green: "G", blue: "B", yellow: "Y" };
// Lines tell how a ball is known; colours do not.
const DASHES = { visible: [], occluded: [8, 4], predicted: [2, 4] };
const WINDOW_DASH = [1, 3];

export function draw(canvas, picture, balls) {
  if (canvas.width !== picture.width || canvas.height !== picture.height) {
    canvas.width = picture.width;
    canvas.height = picture.height;
  }
  const pen = canvas.getContext("2d");
  pen.drawImage(picture, 0, 0);
  // marks are as large on the screen whatever the picture's size is there
  const px = canvas.width / (canvas.clientWidth || canvas.width);
  const lost = balls.filter((ball) => ball.state === "lost");
  for (const ball of balls) {
    if (ball.window) {
      const [x0, y0, x1, y1] = ball.window;
      stroke(pen, px, 1, WINDOW_DASH, () => pen.rect(x0 - 0.5, y0 - 0.5, x1 - x0, y1 - y0));
    }
    if (!ball.centre) continue;
    const [u, v] = ball.centre;
    const radius = ball.diameter / 2;
    stroke(pen, px, 1.5, DASHES[ball.state] ?? [], () => pen.arc(u, v, radius, 0, 2 * Math.PI));
    stroke(pen, px, 1.5, [], () => {
      const arm = 3 * px;
      pen.moveTo(u - arm, v);
      pen.lineTo(u + arm, v);
      pen.moveTo(u, v - arm);
      pen.lineTo(u, v + arm);
    });
    const beside = { visible: "", occluded: ` ${(ball.visible * 100).toFixed(0)} %`, predicted: " predicted" };
    label(pen, px, LETTERS[ball.name] + (beside[ball.state] ?? ""), u + radius + 3 * px, v - radius);
  }
  if (lost.length) label(pen, px, `lost: ${lost.map((ball) => ball.name).join(", ")}`, 6 * px, canvas.height - 8 * px);
}

// A line twice, dark under light, so that it shows on any background.
function stroke(pen, px, width, dash, path) {
  for (const [extra, colour] of [[1.5, "#000"], [0, "#fff"]]) {
    pen.lineWidth = (width + extra) * px;
    pen.strokeStyle = colour;
    pen.setLineDash(dash.map((length) => length * px));
    pen.beginPath();
    path();
    pen.stroke();
  }
  pen.setLineDash([]);
}

function label(pen, px, text, x, y) {
  pen.font = `bold ${14 * px}px system-ui, "DejaVu Sans", sans-serif`;
  const at = Math.min(x, pen.canvas.width - pen.measureText(text).width - 4 * px);
  pen.lineWidth = 3 * px;
  pen.lineJoin = "round";
  pen.strokeStyle = "#000";
  pen.fillStyle = "#fff";
  const line = Math.max(y, 15 * px);
  pen.strokeText(text, at, line);
  pen.fillText(text, at, line);
}
