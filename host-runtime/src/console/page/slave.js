// The slave's view: what the arm's cameras see, for two eyes, with STOP and hold-to-run at hand.

import { Controls } from "./controls.js";
import { Live } from "./live.js";
import { find, isEngaged, isTyping, standingOf, viewsOf, watchLink, write } from "./page.js";
import { ageWords, Pictures, worstOf } from "./pictures.js";
import { MODES, size, Stereo } from "./stereo.js";
import { stopWith } from "./stop.js";

const SHIFT_STEP = 0.5;

const live = new Live();
const stop = stopWith(live, find("stop"));
watchLink(live, find("link"));
const controls = new Controls(live);
const canvas = find("stage");
const stereo = new Stereo(canvas);
let told = [];
// the views of the arm's cameras, the left one first; null: not told yet
let eyes = null;
// when each eye's newest picture was taken, by the operator's clock
let takenUs = [];
let pictures = null;

live.addEventListener("hello", ({ detail }) => {
  told = detail.views;
  // a console that was started again has another clock
  takenUs = takenUs.map(() => null);
});

function look(snapshot) {
  const now = viewsOf(told, snapshot).flatMap(({ kind, at }) => (kind === "eye" ? [at] : []));
  if (eyes?.join() === now.join()) return;
  eyes = now;
  takenUs = eyes.map(() => null);
  pictures?.close();
  stereo.forget();
  pictures = new Pictures(eyes, (view, picture, header) => {
    const eye = now.indexOf(view);
    stereo.keep(eye, picture);
    takenUs[eye] = header.taken_us;
    if (!stereo.isAlternating) redraw();
  });
  redraw();
}
live.addEventListener("live", () => {
  const { control, snapshot } = live.newest;
  controls.show(control);
  look(snapshot);
  const { arm } = snapshot;
  document.body.classList.toggle("engaged", isEngaged(arm));
  document.body.classList.toggle("unheard", Boolean(arm?.silent));
  write(find("standing"), [standingOf(arm), ...(arm && !arm.silent ? arm.limits : [])].join("; "));
});

// What is shown is as old as the older eye's picture, and not known where one eye's is not. Readers of the screen are
// told that it is old, and not how old it is ten times a second.
setInterval(() => {
  const none = eyes?.length === 0;
  const { stale, text } = none ? { stale: true, text: "no camera at the arm" } : ageWords(worstOf(takenUs, live.clock), live.clock);
  document.body.classList.toggle("stale", stale);
  write(find("stamp"), text);
  write(find("stamp-words"), none ? text : stale ? "The picture is old, or has not come." : "");
}, 100);

let due = false;
function redraw() {
  if (due) return;
  due = true;
  requestAnimationFrame(() => {
    due = false;
    stereo.draw();
    // one eye after the other, for as long as that is wanted
    if (stereo.isAlternating && !document.hidden) redraw();
  });
}
document.addEventListener("visibilitychange", redraw);

new ResizeObserver(([{ contentRect, devicePixelContentBoxSize: exact }]) => {
  const by = devicePixelRatio;
  const [width, height] = exact
    ? [exact[0].inlineSize, exact[0].blockSize]
    : [contentRect.width, contentRect.height].map((pixels) => Math.round(pixels * by));
  size(canvas, Math.max(1, width), Math.max(1, height));
  redraw();
}).observe(canvas);

// The ways of looking.
const radios = [...document.querySelectorAll("input[name=mode]")];
function choose(mode) {
  stereo.mode = mode;
  radios.find((radio) => radio.value === mode).checked = true;
  write(find("mode-words"), MODES[mode].words);
  redraw();
}
for (const radio of radios) radio.addEventListener("change", () => choose(radio.value));
choose("beside");
find("swap").addEventListener("change", ({ target }) => {
  stereo.swapped = target.checked;
  redraw();
});
function shift(percent) {
  find("shift").value = percent;
  const now = find("shift").valueAsNumber;
  stereo.shift = now / 100;
  write(find("shift-words"), `${now} %`);
  redraw();
}
find("shift").addEventListener("input", ({ target }) => shift(target.value));

const keys = {
  1: () => choose("beside"),
  2: () => choose("anaglyph"),
  3: () => choose("rows"),
  4: () => choose("flip"),
  x: () => find("swap").click(),
  f: () => find("full").click(),
  arrowleft: () => shift(find("shift").valueAsNumber - SHIFT_STEP),
  arrowright: () => shift(find("shift").valueAsNumber + SHIFT_STEP),
};
addEventListener("keydown", (event) => {
  const arrow = Boolean(event.key?.startsWith("Arrow"));
  // arrows are a radio button's and a slider's own
  if (event.ctrlKey || event.altKey || event.metaKey || isTyping(event) || (arrow && event.target.closest("input"))) return;
  if (event.repeat && !arrow) return;
  keys[event.key?.toLowerCase()]?.();
});

// Full screen. The browser keeps Esc for leaving it and tells the page of no key: so whoever leaves it in another
// way than by the page's own button has pressed Esc, and means STOP.
let leaving = false;
find("full").addEventListener("click", () => {
  if (document.fullscreenElement) {
    leaving = true;
    document.exitFullscreen().catch(() => {
      leaving = false;
    });
  } else {
    document.documentElement.requestFullscreen().catch(() => write(find("mode-words"), "The browser allows no full screen here."));
  }
});
document.addEventListener("fullscreenchange", () => {
  const full = document.fullscreenElement !== null;
  document.body.classList.toggle("full", full);
  if (!full && !leaving) stop();
  leaving = false;
});
