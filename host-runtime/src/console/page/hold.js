// Hold-to-run: the space bar or a button, told again and again while it is held.
//
// Whatever is doubtful lets go: the key up, the pointer lifted or lost, another of the mouse's buttons with it,
// the focus elsewhere, the window without focus, the tab hidden, the page left, the socket lost, a refusal. A press
// that has ended does not come back: the key has to be let go and pressed anew. Keys that repeat press nothing.
//
// The space bar is the arm's while the focus is on this button or nowhere. Elsewhere it belongs to what has the
// focus, as on every page: on STOP it stops.

const TELL_MS = 30;

// A pointer's main button, or its touch (Pointer Events, 3.1.1).
const MAIN = 1;

export class Hold extends EventTarget {
  #live;
  #button;
  #press = 0;
  #timer = null;
  // the pointer that holds the button
  #pointer = null;
  // whether the space bar went down for the arm
  #spaceIsOurs = false;

  constructor(live, button) {
    super();
    this.#live = live;
    this.#button = button;
    addEventListener("keydown", (event) => this.#key(event, true));
    addEventListener("keyup", (event) => this.#key(event, false));
    button.addEventListener("pointerdown", (event) => this.#point(event));
    // further buttons of a mouse that has one down, and all but the last that go up, are told as moves
    button.addEventListener("pointermove", (event) => {
      if (event.pointerId === this.#pointer?.id && !(event.buttons & MAIN)) this.end();
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      button.addEventListener(end, () => this.end());
    }
    button.addEventListener("contextmenu", (event) => {
      event.preventDefault();
      // a finger or pen that stays where it is asks for it too, and only holds the button
      if (this.#pointer?.type === "mouse") this.end();
    });
    addEventListener("focusin", ({ target }) => {
      if (target !== button) this.end();
    });
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

  // Whether the space bar would be the arm's.
  get hasSpaceBar() {
    return this.#isOurs(document.activeElement);
  }

  // Gives the space bar to the arm, whatever had it.
  takeFocus() {
    if (this.#button.disabled) document.activeElement?.blur();
    else this.#button.focus({ preventScroll: true });
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
    this.#pointer = null;
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

  #isOurs(element) {
    return element === null || element === document.body || element === document.documentElement || element === this.#button;
  }

  #point(event) {
    if (event.button !== 0 || event.buttons !== MAIN) return;
    event.preventDefault();
    this.takeFocus();
    this.#button.setPointerCapture(event.pointerId);
    this.begin();
    if (this.isHeld) this.#pointer ??= { id: event.pointerId, type: event.pointerType };
  }

  #key(event, down) {
    if (event.code !== "Space") return;
    // up is up, wherever it is heard
    if (!down) this.end();
    const fresh = down && !event.repeat;
    if (fresh) this.#spaceIsOurs = this.#isOurs(event.target);
    // nor does it scroll, or press what has got the focus meanwhile; STOP it may press
    if (this.#spaceIsOurs && !event.target.closest?.("#stop")) event.preventDefault();
    if (fresh && this.#spaceIsOurs && !event.ctrlKey && !event.altKey && !event.metaKey) this.begin();
  }
}
