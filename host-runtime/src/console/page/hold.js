// Hold-to-run: the space bar or a button, told again and again while it is held.
//
// Whatever is doubtful lets go: the key up, the pointer lifted or lost, the window without focus, the tab
// hidden, the page left, the socket lost, a refusal. A press that has ended does not come back: the key has
// to be let go and pressed anew. Keys that repeat press nothing.

import { isTyping } from "./page.js";

const TELL_MS = 30;

export class Hold extends EventTarget {
  #live;
  #press = 0;
  #timer = null;

  constructor(live, button) {
    super();
    this.#live = live;
    addEventListener("keydown", (event) => this.#key(event, true));
    addEventListener("keyup", (event) => this.#key(event, false));
    button.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      button.setPointerCapture(event.pointerId);
      this.begin();
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      button.addEventListener(end, () => this.end());
    }
    button.addEventListener("contextmenu", (event) => event.preventDefault());
    addEventListener("blur", () => this.end());
    addEventListener("pagehide", () => this.end());
    document.addEventListener("visibilitychange", () => this.end());
    live.addEventListener("lost", () => this.end());
    live.addEventListener("refused", (event) => {
      if (event.detail.what === "hold") this.end();
    });
  }

  get isHeld() {
    return this.#timer !== null;
  }

  begin() {
    if (this.isHeld || document.hidden || !document.hasFocus()) return;
    this.#press += 1;
    this.#timer = setInterval(() => this.#tell(), TELL_MS);
    this.#tell();
    this.dispatchEvent(new Event("change"));
  }

  end() {
    if (!this.isHeld) return;
    clearInterval(this.#timer);
    this.#timer = null;
    this.letGo();
    this.dispatchEvent(new Event("change"));
  }

  // The button is not held: whoever has just taken control says so first.
  letGo() {
    this.#live.send({ type: "release" });
  }

  #tell() {
    if (!this.#live.send({ type: "hold", press: this.#press, shown_us: this.#live.shownUs })) this.end();
  }

  #key(event, down) {
    if (event.code !== "Space" || isTyping(event)) return;
    // nor does it press a button that has the focus, or scroll
    event.preventDefault();
    if (!down) this.end();
    else if (!event.repeat && !event.ctrlKey && !event.altKey && !event.metaKey) this.begin();
  }
}
