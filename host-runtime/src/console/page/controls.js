// The operator's buttons, as the drive page and the slave's view have them: control, hold-to-run, the way home, reset,
// scale.
//
// A page with them has the elements take, give, reset, hold, hold-home, less, more, scale and control, and may have
// homed.

import { Hold } from "./hold.js";
import { find, isTyping, keptName, write } from "./page.js";

const HERE_MS = 500;

// STOP, for one, has the focus once it was clicked.
const SPACE_ELSEWHERE = " The space bar is now for what has the focus: M gives it to the arm.";
const SPACE_TO_MOVE = " Hold the space bar to move the arm.";
const SPACE_FOR_HOME = " The space bar is now for the way home: M gives it to moving.";

export class Controls {
  #live;
  #hold;
  #control = null;
  #message = "";
  // percent of the slave's scale that can be chosen, as at the terminal
  #scales = [100];

  constructor(live) {
    this.#live = live;
    this.#hold = new Hold(live, find("hold"), find("hold-home"));
    const actions = {
      take: () => this.#take(),
      give: () => this.#give(),
      reset: () => this.#reset(),
      less: () => this.#scale(-1),
      more: () => this.#scale(1),
    };
    for (const [name, act] of Object.entries(actions)) find(name).addEventListener("click", act);
    find("homed")?.addEventListener("click", () => live.send({ type: "homed" }));
    const keys = {
      t: actions.take,
      g: actions.give,
      r: actions.reset,
      m: () => this.#hold.takeFocus(),
      "-": actions.less,
      "+": actions.more,
      // the same key, where plus is above it
      "=": actions.more,
    };
    addEventListener("keydown", (event) => {
      if (event.repeat || event.ctrlKey || event.altKey || event.metaKey || isTyping(event)) return;
      // what has keys of its own has prevented what they are for elsewhere
      if (event.defaultPrevented) return;
      keys[event.key?.toLowerCase()]?.();
    });
    // who is in control and silent for three seconds is not any more
    setInterval(() => {
      if (this.#control?.yours && !this.#hold.isHeld) live.send({ type: "here" });
    }, HERE_MS);
    live.addEventListener("hello", ({ detail }) => {
      this.#scales = detail.scales;
    });
    live.addEventListener("refused", ({ detail }) => {
      this.#message = detail.why;
    });
    live.addEventListener("lost", () => {
      this.#control = null;
    });
    live.addEventListener("live", ({ detail }) => {
      // why nothing came of what was asked for without control
      if (detail.control.yours && !this.#control?.yours) this.#message = "";
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
    if (!control.yours && isButton(document.activeElement)) document.activeElement.blur();
    find("take").disabled = !control.drives || control.yours;
    for (const name of ["give", "reset", "hold", "hold-home", "homed"]) {
      const button = find(name);
      if (button) button.disabled = !control.yours;
    }
    if (hasTaken) this.#hold.takeFocus();
    const counts = held && control.pressed;
    find("hold").setAttribute("aria-pressed", String(counts && !this.#hold.isForHome));
    find("hold-home").setAttribute("aria-pressed", String(counts && this.#hold.isForHome));
    find("less").disabled = !control.yours || control.scale_percent <= this.#scales[0];
    find("more").disabled = !control.yours || control.scale_percent >= this.#scales.at(-1);
    write(find("scale"), `${control.scale_percent} %`);
    document.body.classList.toggle("stopped", control.stopped);
    // that somebody has stopped the arm is more than why a press did not count
    const stopped = control.yours && control.stopped;
    const words = standing(control, held, this.#hold.isForHome) + this.#spaceBar(control, held);
    write(find("control"), (!stopped && this.#message) || words);
  }

  // What the space bar is for.
  #spaceBar(control, held) {
    if (!control.yours || held) return "";
    if (!this.#hold.hasKeys) return SPACE_ELSEWHERE;
    if (this.#hold.hasSpaceForHome) return SPACE_FOR_HOME;
    return control.stopped ? "" : SPACE_TO_MOVE;
  }

  #take() {
    this.#message = "";
    // a press is begun in control, or is none
    this.#hold.end();
    this.#live.send({ type: "take", name: keptName() });
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

  // One step finer or coarser, from the next press on.
  #scale(step) {
    if (!this.#control?.yours) return;
    this.#message = "";
    const now = this.#control.scale_percent;
    const percent = step < 0 ? this.#scales.findLast((percent) => percent < now) : this.#scales.find((percent) => percent > now);
    if (percent !== undefined) this.#live.send({ type: "scale", percent });
    // a button that was pressed has done its work, and leaves the space bar to the arm
    if (document.activeElement === find("less") || document.activeElement === find("more")) this.#hold.takeFocus();
  }
}

// Whether it is a button that is held.
const isButton = (element) => element === find("hold") || element === find("hold-home");

function standing(control, held, forHome) {
  if (!control.drives) return "The buttons are not in the console. STOP works from here.";
  if (control.stopped) return control.yours ? "Stopped. Reset (R), then press anew." : "Stopped.";
  if (!control.holder) return "Nobody is in control: take it (T).";
  if (!control.yours) return `${control.holder} is in control. STOP works from here too.`;
  if (held && !control.pressed) return "Held, but not in time: the arm does not move.";
  if (held) return forHome ? "You hold the button for the way home." : "You hold the button.";
  return "You are in control; letting go is the clutch.";
}
