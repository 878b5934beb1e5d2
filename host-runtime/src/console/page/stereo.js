// Two pictures on one canvas, in the ways that reach two eyes.
//
// Each way is drawn in the screen's own pixels: row by row works only where a row of the canvas is a row of the
// screen.

// Of each way: how wide it is of the two pictures, and what a person has to know.
export const MODES = {
  beside: { pictures: 2, words: "The left eye's picture at the left: for a head-mounted screen, or for crossing one's eyes with the eyes swapped." },
  anaglyph: { pictures: 1, words: "Red glass before the left eye, cyan before the right." },
  rows: { pictures: 1, words: "Even rows of the screen for the left eye, odd rows for the right: for polarised screens. Full screen, without zoom; swap the eyes where near and far are the wrong way round." },
  flip: { pictures: 1, words: "Left and right in turn at the rate of the screen: for shutter glasses that follow it. It flickers." },
};

export class Stereo {
  mode = "beside";
  swapped = false;
  // How far both pictures are moved against each other, of their width.
  shift = 0;
  #canvas;
  #pen;
  #eyes = [null, null];
  #spare = [document.createElement("canvas"), document.createElement("canvas")];
  #stripes = null;
  #second = false;

  constructor(canvas) {
    this.#canvas = canvas;
    this.#pen = canvas.getContext("2d", { alpha: false });
  }

  get isAlternating() {
    return this.mode === "flip";
  }

  // Keeps a copy of an eye's newest picture; 0 is the left one.
  keep(eye, picture) {
    const kept = (this.#eyes[eye] ??= document.createElement("canvas"));
    size(kept, picture.width, picture.height);
    kept.getContext("2d").drawImage(picture, 0, 0);
  }

  // Keeps none: there are other eyes now.
  forget() {
    this.#eyes = [null, null];
  }

  // Draws what is kept; a slave with one camera shows both eyes the same.
  draw() {
    const [first, second] = this.swapped ? [1, 0] : [0, 1];
    const eyes = [this.#eyes[first] ?? this.#eyes[second], this.#eyes[second] ?? this.#eyes[first]];
    const { width, height } = this.#canvas;
    const pen = this.#pen;
    pen.globalCompositeOperation = "source-over";
    pen.fillStyle = "#000";
    pen.fillRect(0, 0, width, height);
    if (!eyes[0]) return;
    const whole = { x: 0, y: 0, width, height };
    if (this.mode === "beside") {
      const half = width / 2;
      this.#place(pen, eyes[0], { ...whole, width: half }, this.shift / 2);
      this.#place(pen, eyes[1], { ...whole, x: half, width: half }, -this.shift / 2);
    } else if (this.mode === "flip") {
      this.#second = !this.#second;
      this.#place(pen, eyes[this.#second ? 1 : 0], whole, this.#second ? -this.shift / 2 : this.shift / 2);
    } else {
      const [left, right] = eyes.map((eye, at) => this.#apart(eye, at, whole));
      if (this.mode === "anaglyph") {
        tint(left, "#f00");
        tint(right, "#0ff");
        pen.drawImage(left, 0, 0);
        pen.globalCompositeOperation = "lighter";
        pen.drawImage(right, 0, 0);
      } else {
        this.#everyOtherRow(right);
        pen.drawImage(left, 0, 0);
        pen.drawImage(right, 0, 0);
      }
    }
  }

  // An eye's picture on a canvas of its own, as it is placed on the screen.
  #apart(eye, at, whole) {
    const canvas = this.#spare[at];
    size(canvas, whole.width, whole.height);
    const pen = canvas.getContext("2d");
    pen.globalCompositeOperation = "source-over";
    pen.fillStyle = "#000";
    pen.fillRect(0, 0, whole.width, whole.height);
    this.#place(pen, eye, whole, at ? -this.shift / 2 : this.shift / 2);
    return canvas;
  }

  // A picture as large as fits, in the middle, moved aside by a share of its width; nothing beyond its place.
  #place(pen, picture, { x, y, width, height }, aside) {
    const scale = Math.min(width / picture.width, height / picture.height);
    const [w, h] = [picture.width * scale, picture.height * scale];
    pen.save();
    pen.beginPath();
    pen.rect(x, y, width, height);
    pen.clip();
    pen.drawImage(picture, x + (width - w) / 2 + aside * w, y + (height - h) / 2, w, h);
    pen.restore();
  }

  // Leaves the odd rows of a canvas.
  #everyOtherRow(canvas) {
    const pen = canvas.getContext("2d");
    if (!this.#stripes) {
      const tile = document.createElement("canvas");
      size(tile, 1, 2);
      tile.getContext("2d").fillRect(0, 1, 1, 1);
      this.#stripes = pen.createPattern(tile, "repeat");
    }
    pen.globalCompositeOperation = "destination-in";
    pen.fillStyle = this.#stripes;
    pen.fillRect(0, 0, canvas.width, canvas.height);
  }
}

// Leaves the light of one colour.
function tint(canvas, colour) {
  const pen = canvas.getContext("2d");
  pen.globalCompositeOperation = "multiply";
  pen.fillStyle = colour;
  pen.fillRect(0, 0, canvas.width, canvas.height);
}

export function size(canvas, width, height) {
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
}
