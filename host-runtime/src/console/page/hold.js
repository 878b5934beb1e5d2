// Hold-to-run: a key or a button, told again and again while it is held. There are two: one to move the arm with the
// hand, one to have it go home.
//
// Whatever is doubtful lets go: the key up, the pointer lifted or lost, another of the mouse's buttons with it,
// the focus elsewhere, the window without focus, the tab hidden, the page left, the socket lost, a refusal, the other
// of the two, a key like Alt or Meta, which changes what others are, and what may keep a key's way up from the page:
// the browser's menu, or something that is dragged. A press that has ended does not come back: the key has to be let
// go and pressed anew. Keys that repeat press nothing.
//
// Keys are the arm's while the focus is on one of the two buttons or nowhere. Elsewhere they belong to what has the
// focus, as on every page: on STOP the space bar stops.

const TELL_MS = 30;

// A pointer's main button, or its touch (Pointer Events, 3.1.1).
const MAIN = 1;

const isSpace = (event) => event.code === "Space";
// no key at all is told by what fills in forms
const isH = (event) => event.key?.toLowerCase() === "h";
const CHANGE_KEYS = ["Alt", "AltGraph", "Control", "Meta", "OS"];

export class Hold extends EventTarget {
  #live;
  // to move with the hand, and to go home
  #move;
  #home;
  #press = 0;
  #timer = null;
  // the button that is held, by whatever
  #held = null;
  // the pointer that holds it, or the key that went down for it
  #pointer = null;
  #code = null;
  // whether the space bar went down for the arm
  #spaceIsOurs = false;

  constructor(live, move, home) {
    super();
    this.#live = live;
    this.#move = move;
    this.#home = home;
    addEventListener("keydown", (event) => this.#key(event, true));
    addEventListener("keyup", (event) => this.#key(event, false));
    for (const button of [move, home]) this.#listen(button);
    addEventListener("focusin", ({ target }) => {
      if (target !== move && target !== home) this.end();
    });
    addEventListener("blur", () => this.end());
    addEventListener("pagehide", () => this.end());
    document.addEventListener("visibilitychange", () => this.end());
    // wherever, and whatever else hears of it
    document.addEventListener("contextmenu", (event) => this.#menu(event), { capture: true });
    document.addEventListener("dragstart", () => this.end(), { capture: true });
    live.addEventListener("lost", () => this.end());
    live.addEventListener("refused", (event) => {
      if (event.detail.what === "hold") this.end();
    });
  }

  get isHeld() {
    return this.#timer !== null;
  }

  // Whether it is held to go home.
  get isForHome() {
    return this.#held === this.#home;
  }

  // Whether the keys would be the arm's.
  get hasKeys() {
    return this.#isOurs(document.activeElement);
  }

  // Whether the space bar would hold it to go home.
  get hasSpaceForHome() {
    return document.activeElement === this.#home;
  }

  // Gives the space bar to the arm, to move it with the hand, whatever had it.
  takeFocus() {
    this.#focus(this.#move);
  }

  end() {
    if (!this.isHeld) return;
    clearInterval(this.#timer);
    this.#timer = null;
    const pointed = this.#pointer !== null;
    this.#held = null;
    this.#pointer = null;
    this.#code = null;
    this.letGo();
    // whoever has held the way home by hand has not chosen it for the space bar
    if (pointed && this.hasSpaceForHome) this.takeFocus();
    this.dispatchEvent(new Event("change"));
  }

  // The button is not held: whoever has just taken control says so first.
  letGo() {
    this.#live.send({ type: "release" });
  }

  #begin(button) {
    // who holds both is not understood
    if (this.isHeld && this.#held !== button) this.end();
    else if (!this.isHeld && !document.hidden && document.hasFocus()) {
      this.#press += 1;
      this.#held = button;
      this.#timer = setInterval(() => this.#tell(), TELL_MS);
      this.#tell();
      this.dispatchEvent(new Event("change"));
    }
  }

  #tell() {
    const told = { type: "hold", press: this.#press, home: this.isForHome, shown_us: this.#live.shownUs };
    if (!this.#live.send(told)) this.end();
  }

  #isOurs(element) {
    const nowhere = element === null || element === document.body || element === document.documentElement;
    return nowhere || element === this.#move || element === this.#home;
  }

  #focus(button) {
    if (button.disabled) document.activeElement?.blur();
    else button.focus({ preventScroll: true });
  }

  #listen(button) {
    button.addEventListener("pointerdown", (event) => this.#point(event, button));
    // further buttons of a mouse that has one down, and all but the last that go up, are told as moves
    button.addEventListener("pointermove", (event) => {
      if (event.pointerId === this.#pointer?.id && event.buttons !== MAIN) this.end();
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      button.addEventListener(end, () => this.end());
    }
    // there is none for a button that is held
    button.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  // A finger or pen that stays where it is asks for a menu too, and only holds the button.
  #menu(event) {
    const touched = this.#pointer !== null && this.#pointer.type !== "mouse";
    if (!touched || !event.composedPath().includes(this.#held)) this.end();
  }

  #point(event, button) {
    if (event.button !== 0 || event.buttons !== MAIN) return;
    event.preventDefault();
    this.#focus(button);
    button.setPointerCapture(event.pointerId);
    this.#begin(button);
    if (this.isHeld) this.#pointer ??= { id: event.pointerId, type: event.pointerType };
  }

  #key(event, down) {
    // up is up, wherever it is heard, and whatever the key is called by then
    if (!down && (isSpace(event) || isH(event) || event.code === this.#code)) this.end();
    if (down && CHANGE_KEYS.includes(event.key)) this.end();
    if (!isSpace(event) && !isH(event)) return;
    const fresh = down && !event.repeat;
    const ours = this.#isOurs(event.target);
    if (isSpace(event)) {
      if (fresh) this.#spaceIsOurs = ours;
      // nor does it scroll, or press what has got the focus meanwhile; STOP it may press
      if (this.#spaceIsOurs && !event.target.closest?.("#stop")) event.preventDefault();
    }
    if (!fresh || !ours || event.ctrlKey || event.altKey || event.metaKey) return;
    // on the button for the way home the space bar presses that one, as on every page
    this.#begin(isH(event) || event.target === this.#home ? this.#home : this.#move);
    if (this.isHeld) this.#code ??= event.code;
  }
}
