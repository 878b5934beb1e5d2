// The set-up page: find the balls or point at them, see what was learnt, use it, keep it.

import { Live } from "./live.js";
import { find, isHeard, isTyping, items, ms, watchLink, write } from "./page.js";
import { Scan } from "./scan.js";
import { BALLS, SetUpView } from "./setup-view.js";
import { stopWith } from "./stop.js";
import { Views } from "./views.js";

const live = new Live();
stopWith(live, find("stop"));
watchLink(live, find("link"));
const scan = new Scan(find("scan"), find("row"));

// The number by which the console knows this page.
let number = null;
let state = null;
const views = [];
let pictures = null;
let busy = false;

// What the views know of the page.
const page = { chosen: null, stands: false, scan, say, post, stand, showStills, choose };

live.addEventListener("hello", ({ detail }) => {
  number = detail.page;
  if (!views.length) {
    detail.views.forEach((view, at) => view.kind === "hand" && views.push(new SetUpView(page, view.name, at)));
    pictures ??= new Views(views.map((view) => [view.at, view.figure]), live);
  }
  refresh();
});
live.addEventListener("live", ({ detail: { snapshot } }) => {
  pictures?.explain(snapshot.cameras);
  items(
    find("tracked"),
    snapshot.cameras.map((camera) => {
      const seen = camera.balls.filter((ball) => ball.state === "visible" || ball.state === "occluded");
      const missing = camera.balls.filter((ball) => !seen.includes(ball)).map((ball) => ball.name);
      const mark = seen.length === 4 && isHeard(camera.age_us) ? "\u2713" : "\u2717";
      const rest = missing.length ? `, not ${missing.join(", ")}` : "";
      return `${mark} ${camera.name}: ${seen.length} of 4 balls${rest}; heard ${ms(camera.age_us)} ago`;
    }),
  );
});

// What `tetrad check` notes of the file and this computer.
async function look() {
  const answer = await fetch("/api/checklist").catch(() => null);
  if (!answer?.ok) return;
  const { notes } = await answer.json();
  items(find("notes"), notes.length ? notes.map((note) => `\u2717 ${note}`) : ["\u2713 nothing to note on this computer"]);
}
look();

async function refresh() {
  const answer = await fetch(`/api/setup?page=${number}`).catch(() => null);
  if (answer?.ok) {
    take(await answer.json());
  } else {
    if (answer) say((await answer.json().catch(() => ({}))).why ?? "", true);
    setTimeout(refresh, 1000);
  }
}

function take(told) {
  state = told;
  views.forEach((view) => view.take(told.cameras.find((camera) => camera.view === view.at)));
  const arm = find("arm_mm");
  if (document.activeElement !== arm) arm.value = told.arm_mm;
  write(find("arm_file"), told.arm_file ? `Kept in ${told.arm_file}.` : "No file keeps it: it is as long as this run.");
  if (told.said) say(told.said);
  else if (told.not_now) say(told.not_now, true);
  enable();
}

function say(text, bad = false) {
  find("said").classList.toggle("bad", bad);
  write(find("said"), text);
}

function enable() {
  for (const button of document.querySelectorAll("main button")) {
    button.disabled = !state;
    // a button that is disabled would lose the focus
    button.setAttribute("aria-disabled", String(busy));
  }
}

// Asks for something; the answer is the whole set-up, or why not.
async function post(what, body = {}) {
  if (busy || !state) return false;
  busy = true;
  enable();
  try {
    const sent = JSON.stringify({ page: number, ...body });
    const answer = await fetch(`/api/setup/${what}`, { method: "POST", body: sent });
    const text = await answer.text();
    let told = {};
    try {
      told = JSON.parse(text);
    } catch {
      told = { why: text };
    }
    if (answer.ok) take(told);
    else say(told.why, true);
    return answer.ok;
  } catch {
    say("the console does not answer", true);
    return false;
  } finally {
    busy = false;
    enable();
  }
}

async function stand(wanted) {
  if (wanted && !(await post("still"))) return false;
  showStills(wanted);
  return true;
}

function showStills(wanted) {
  page.stands = wanted;
  find("still").setAttribute("aria-pressed", String(page.stands));
  views.forEach((view) => view.refresh());
}

const actions = {
  async find() {
    if (!(await post("find"))) return;
    showStills(true);
    say(state.said, state.cameras.some((camera) => camera.failed));
  },
  still: () => stand(!page.stands),
  async use() {
    if (await post("use")) showStills(false);
  },
  save: () => post("save"),
  load: () => post("load"),
};
for (const [name, act] of Object.entries(actions)) find(name).addEventListener("click", act);
find("arm").addEventListener("submit", (event) => {
  event.preventDefault();
  post("arm", { arm_mm: find("arm_mm").valueAsNumber });
});

function choose(ball) {
  page.chosen = ball;
  document.querySelector(`input[value=${ball}]`).checked = true;
  views.forEach((view) => view.ask());
  if (!views.some((view) => view.over === document.activeElement)) views[0]?.over.focus();
}
for (const radio of document.querySelectorAll("input[name=ball]")) {
  radio.addEventListener("click", (event) => event.detail && choose(radio.value));
  radio.addEventListener("change", () => {
    page.chosen = radio.value;
    views.forEach((view) => view.ask());
  });
}

const keys = { f: actions.find, l: actions.still, u: actions.use };
addEventListener("keydown", (event) => {
  if (event.repeat || event.ctrlKey || event.altKey || event.metaKey || isTyping(event)) return;
  const ball = BALLS[Number(event.key) - 1];
  if (ball) choose(ball);
  else keys[event.key?.toLowerCase()]?.();
});
