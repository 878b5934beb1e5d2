// The operator's buttons, as the drive page and the slave's view have them: control, hold-to-run, reset.
//
// A page with them has the elements take, give, reset, hold and control, and may have homed.

import { Hold } from "./hold.js";
import { find, isTyping, write } from "./page.js";

const HERE_MS = 500;

// STOP, for one, has the focus once it was clicked.
const SPACE_ELSEWHERE = " The space bar is now for what has the focus: M gives it to the arm.";

export class Controls {
  #live;
  #hold;
  #control = null;
  #message = "";

  constructor(live) {
    this.#live = live;
    this.#hold = new Hold(live, find("hold"));
    const actions = { take: () => this.#take(), give: () => this.#give(), reset: () => this.#reset() };
    for (const [name, act] of Object.entries(actions)) find(name).addEventListener("click", act);
    find("homed")?.addEventListener("click", () => live.send({ type: "homed" }));
    const keys = { t: actions.take, g: actions.give, r: actions.reset, m: () => this.#hold.takeFocus() };
    addEventListener("keydown", (event) => {
      if (event.repeat || event.ctrlKey || event.altKey || event.metaKey || isTyping(event)) return;
      keys[event.key.toLowerCase()]?.();
    });
    // who is in control and silent for three seconds is not any more
    setInterval(() => {
      if (this.#control?.yours && !this.#hold.isHeld) live.send({ type: "here" });
    }, HERE_MS);
    live.addEventListener("refused", ({ detail }) => {
      this.#message = detail.why;
    });
    live.addEventListener("lost", () => {
      this.#control = null;
    });
    live.addEventListener("live", ({ detail }) => {
      this.#control = detail.control;
    });
    this.#hold.addEventListener("change", () => {
      if (this.#hold.isHeld) this.#message = "";
      if (live.newest) this.show(live.newest.control);
    });
  }

  // Which buttons can be used, and in words who is in control.
  show(control) {
    const held = this.#hold.isHeld;
    // a button that is pressed once and has done its work leaves the space bar to the arm
    const hasTaken = control.yours && document.activeElement === find("take");
    if (!control.yours && document.activeElement === find("hold")) find("hold").blur();
    find("take").disabled = !control.drives || control.yours;
    for (const name of ["give", "reset", "hold", "homed"]) {
      const button = find(name);
      if (button) button.disabled = !control.yours;
    }
    if (hasTaken) this.#hold.takeFocus();
    find("hold").setAttribute("aria-pressed", String(held && control.pressed));
    document.body.classList.toggle("stopped", control.stopped);
    // that somebody has stopped the arm is more than why a press did not count
    const stopped = control.yours && control.stopped;
    const elsewhere = control.yours && !held && !this.#hold.hasSpaceBar;
    write(find("control"), (!stopped && this.#message) || standing(control, held) + (elsewhere ? SPACE_ELSEWHERE : ""));
  }

  #take() {
    this.#message = "";
    this.#live.send({ type: "take", name: "" });
    this.#hold.letGo();
  }

  #give() {
    this.#hold.end();
    this.#live.send({ type: "give" });
  }

  #reset() {
    this.#message = "";
    this.#hold.end();
    this.#live.send({ type: "reset" });
    // what comes next is a press, by whichever key or button this was asked for
    if (this.#control?.yours) this.#hold.takeFocus();
  }
}

function standing(control, held) {
  if (!control.drives) return "The buttons are not in the console. STOP works from here.";
  if (control.stopped) return control.yours ? "Stopped. Reset (R), then press anew." : "Stopped.";
  if (!control.holder) return "Nobody is in control: take it (T).";
  if (!control.yours) return `${control.holder} is in control. STOP works from here too.`;
  if (held) return control.pressed ? "You hold the button." : "Held, but not in time: the arm does not move.";
  return "You are in control. Hold the space bar to move the arm; letting go is the clutch.";
}
