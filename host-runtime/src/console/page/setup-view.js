// One camera of the set-up page: its pictures, live or still, a cross-hair, and what is known of its balls.

import { find, write } from "./page.js";

export const BALLS = ["red", "green", "blue", "yellow"];
const LETTERS = { red: "R", green: "G", blue: "B", yellow: "Y" };
// Pixels of the picture that an arrow key moves the cross-hair by.
const STEP = 8;

// One camera's picture with a cross-hair over it, and what was learnt in it.
export class SetUpView {
  #page;

  // `page` has the chosen ball, whether pictures stand still, and what can be asked for.
  constructor(page, name, at) {
    this.#page = page;
    this.name = name;
    this.at = at;
    this.camera = null;
    this.cross = null;
    this.under = false;
    this.bitmap = null;
    // the number of the still picture that is drawn, and the ball for which what is mistaken is marked in it
    this.drawn = null;
    this.shown = "";
    this.mistaken = null;
    this.#build();
  }

  #build() {
    const make = (tag, name, text = "") => Object.assign(document.createElement(tag), { className: name, textContent: text });
    const section = make("div", "learnt");
    this.figure = make("figure", "");
    const stack = make("div", "stack");
    const picture = make("canvas", "");
    this.over = make("canvas", "over");
    for (const canvas of [picture, this.over]) [canvas.width, canvas.height] = [640, 480];
    this.over.tabIndex = 0;
    this.over.setAttribute("role", "application");
    this.over.setAttribute("aria-label", `${this.name}: arrow keys move the cross-hair, Enter points`);
    stack.append(picture, this.over);
    const caption = make("figcaption", "", this.name);
    this.stamp = make("span", "stamp");
    this.still = make("strong", "still");
    caption.append(this.still, this.stamp);
    this.figure.append(stack, caption);
    this.note = make("p", "note");
    this.list = make("ul", "balls");
    section.append(this.figure, this.note, this.list);
    find("views").append(section);
    this.rows = BALLS.map((ball) => {
      const row = make("li", "");
      const name = make("strong", "", ball);
      const patches = ["reference", "background"].map(() => make("span", "patch"));
      const looks = ["reference", "background"].map(() => make("span", ""));
      const how = make("span", "how");
      const words = make("p", "words");
      const show = make("button", "small", "mistaken?");
      show.type = "button";
      show.setAttribute("aria-pressed", "false");
      show.setAttribute("aria-label", `${this.name}: show what would be mistaken for the ${ball} ball`);
      show.addEventListener("click", () => this.#toggle(ball));
      const line = make("div", "line");
      line.append(name, patches[0], looks[0], " before ", patches[1], looks[1], how);
      row.append(line, words, show);
      this.list.append(row);
      return { patches, looks, how, words, show };
    });
    this.#keep(make);
    this.over.addEventListener("pointermove", (event) => this.#move(this.#place(event)));
    this.over.addEventListener("pointerleave", () => this.#leave());
    this.over.addEventListener("click", (event) => this.#point(this.#place(event)));
    this.over.addEventListener("focus", () => this.#move(this.cross ?? [this.over.width / 2, this.over.height / 2]));
    this.over.addEventListener("blur", () => this.#leave());
    this.over.addEventListener("keydown", (event) => this.#key(event));
    setInterval(() => this.under && !this.#page.stands && this.ask(), 250);
  }

  // Download and upload of its colours.
  #keep(make) {
    this.files = make("p", "row");
    const get = make("a", "button small", "Download");
    get.href = `/api/setup/colours?camera=${this.at}`;
    get.download = "";
    get.setAttribute("aria-label", `${this.name}: download its colours`);
    const label = make("label", "button small", "Upload ");
    const file = make("input", "hidden");
    file.type = "file";
    file.accept = ".toml";
    file.setAttribute("aria-label", `${this.name}: upload a file of colours`);
    file.addEventListener("change", async () => {
      const [chosen] = file.files;
      if (!chosen) return;
      const text = await chosen.text();
      file.value = "";
      await this.#page.post("colours", { camera: this.at, file: chosen.name, text });
    });
    label.append(file);
    this.where = make("span", "note");
    this.files.append(make("span", "", this.name), get, label, this.where);
    find("files").append(this.files);
  }

  take(camera) {
    this.camera = camera;
    if (!camera) return;
    const use = camera.in_use ? "in use" : camera.here ? "not in use yet" : "";
    write(this.note, [camera.said, use].filter(Boolean).join("; "));
    this.note.classList.toggle("bad", camera.failed);
    this.list.hidden = !camera.here;
    this.files.hidden = !camera.here;
    write(this.where, camera.file ?? "no file keeps them");
    camera.balls.forEach((ball, at) => {
      const { patches, looks, how, words, show } = this.rows[at];
      [ball.reference, ball.background].forEach((colour, which) => {
        patches[which].style.background = colour ? `rgb(${colour.rgb.join(" ")})` : "none";
        write(looks[which], colour?.name ?? "not known");
      });
      write(how, ball.how ? `(${ball.how})` : "");
      write(words, ball.clash ?? "not looked at in a still picture yet");
      words.classList.toggle("bad", Boolean(ball.clash) && !ball.clash.startsWith("well apart"));
      show.hidden = !camera.still || !ball.how;
    });
    this.refresh();
  }

  // The still picture, or what would be mistaken in it, where it is not there yet.
  async refresh() {
    const still = this.#page.stands ? this.camera?.still : null;
    if (!still) {
      this.mistaken = null;
      this.shown = "";
      this.#drop();
      this.#caption();
      return;
    }
    const what = this.mistaken ? `mistaken?camera=${this.at}&ball=${this.mistaken}` : `still?camera=${this.at}`;
    // what is mistaken changes with what is learnt
    const wanted = `${what} ${still.number} ${this.mistaken ? JSON.stringify(this.camera.balls) : ""}`;
    if (this.shown !== wanted) {
      this.shown = wanted;
      const { mistaken } = this;
      try {
        const bitmap = await pictureOf(`/api/setup/${what}`);
        if (this.shown !== wanted) return;
        this.bitmap = bitmap;
        this.drawn = { number: still.number, mistaken };
      } catch (error) {
        if (this.shown !== wanted) return;
        // the next time it is asked for again; what is shown until then says what it is
        this.shown = "";
        if (this.drawn?.number !== still.number) this.#drop();
        this.mistaken = this.drawn?.mistaken ?? null;
        this.#page.say(`${this.name}: the picture did not come: ${error.message}`, true);
      }
    }
    this.#caption();
  }

  #drop() {
    this.bitmap = null;
    this.drawn = null;
  }

  // Says what is shown: of a picture that has come, and of no other.
  #caption() {
    const { drawn } = this;
    const words = drawn?.mistaken ? `mistaken for ${drawn.mistaken}` : "STILL";
    this.figure.classList.toggle("stands", drawn !== null);
    write(this.still, drawn ? words : "");
    for (const [at, { show }] of this.rows.entries()) {
      show.setAttribute("aria-pressed", String(drawn?.mistaken === BALLS[at]));
    }
    this.#draw();
  }

  async #toggle(ball) {
    this.mistaken = this.mistaken === ball && this.#page.stands ? null : ball;
    if (!this.#page.stands) this.#page.showStills(true);
    else await this.refresh();
  }

  #draw() {
    const { width, height } = this.camera?.still ?? { width: 640, height: 480 };
    if (this.bitmap && (this.over.width !== width || this.over.height !== height)) {
      [this.over.width, this.over.height] = [width, height];
    }
    const pen = this.over.getContext("2d");
    pen.clearRect(0, 0, this.over.width, this.over.height);
    if (this.bitmap) {
      pen.drawImage(this.bitmap, 0, 0);
      pen.font = "bold 20px system-ui, sans-serif";
      for (const ball of this.camera.balls) {
        if (!ball.found) continue;
        const { u, v, diameter } = ball.found;
        twice(pen, () => {
          pen.beginPath();
          pen.arc(u, v, diameter / 2 + 2, 0, 2 * Math.PI);
          pen.stroke();
        });
        letter(pen, LETTERS[ball.name], u + diameter / 2 + 5, v - diameter / 2);
      }
    }
    if (this.cross && (this.under || document.activeElement === this.over)) {
      const [u, v] = this.cross;
      twice(pen, () => {
        pen.beginPath();
        pen.moveTo(0, v);
        pen.lineTo(u - 6, v);
        pen.moveTo(u + 6, v);
        pen.lineTo(this.over.width, v);
        pen.moveTo(u, v - 24);
        pen.lineTo(u, v - 6);
        pen.moveTo(u, v + 6);
        pen.lineTo(u, v + 24);
        pen.stroke();
      });
    }
  }

  // Where in the picture an event is.
  #place(event) {
    const box = this.over.getBoundingClientRect();
    return [
      ((event.clientX - box.left) / box.width) * this.over.width - 0.5,
      ((event.clientY - box.top) / box.height) * this.over.height - 0.5,
    ];
  }

  #move([u, v]) {
    const within = (x, side) => Math.min(Math.max(x, 0), side - 1);
    this.cross = [within(u, this.over.width), within(v, this.over.height)];
    this.under = true;
    this.#draw();
    this.ask();
  }

  #leave() {
    this.under = document.activeElement === this.over;
    this.#draw();
  }

  // The scan of the row under the cross-hair.
  ask() {
    if (!this.under || !this.cross || !this.camera?.here) return;
    const [u, v] = this.cross.map((x) => x.toFixed(1));
    const still = this.#page.stands && this.camera.still;
    this.#page.scan.ask(this.name, this.cross[0], `camera=${this.at}&ball=${this.#page.chosen ?? "red"}&u=${u}&v=${v}&live=${!still}`);
  }

  #key(event) {
    const by = event.shiftKey ? 1 : STEP;
    const moves = { ArrowLeft: [-by, 0], ArrowRight: [by, 0], ArrowUp: [0, -by], ArrowDown: [0, by] };
    const move = moves[event.key];
    if (move) {
      event.preventDefault();
      const [u, v] = this.cross;
      this.#move([u + move[0], v + move[1]]);
    } else if (event.key === "Enter") {
      event.preventDefault();
      this.#point(this.cross);
    }
  }

  async #point(place) {
    if (!this.camera?.here) return;
    if (!this.#page.chosen) {
      this.#page.say("choose a colour first (1 to 4), then point at its ball", true);
      return;
    }
    // what is pointed at has to stand still
    if (!this.#page.stands && !(await this.#page.stand(true))) return;
    const ball = this.#page.chosen;
    if (await this.#page.post("point", { camera: this.at, ball, u: Number(place[0].toFixed(1)), v: Number(place[1].toFixed(1)) })) {
      this.#page.choose(BALLS[(BALLS.indexOf(ball) + 1) % BALLS.length]);
    }
  }
}

// A picture of the console, or why there is none.
async function pictureOf(address) {
  const answer = await fetch(address).catch(() => null);
  if (!answer) throw new Error("the console does not answer");
  if (!answer.ok) throw new Error((await answer.json().catch(() => ({}))).why ?? `refused (${answer.status})`);
  return createImageBitmap(await answer.blob());
}

// Black under white, so that it shows on any picture.
function twice(pen, draw) {
  for (const [width, colour] of [[4, "#000"], [2, "#fff"]]) {
    pen.lineWidth = width;
    pen.strokeStyle = colour;
    draw();
  }
}

function letter(pen, text, x, y) {
  pen.lineWidth = 4;
  pen.strokeStyle = "#000";
  pen.fillStyle = "#fff";
  pen.strokeText(text, x, y);
  pen.fillText(text, x, y);
}
