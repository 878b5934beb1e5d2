// The drive page: hold-to-run, the views, and in words what the arm does and why.

import { Hold } from "./hold.js";
import { Live } from "./live.js";
import { find, items, lines, ms, rows, watchLink, write } from "./page.js";
import { stopWith } from "./stop.js";
import { Views } from "./views.js";

const HERE_MS = 500;

// How the hand's pose is known.
const KNOWN = {
  both: "all balls in two cameras",
  three: "two cameras, not all balls",
  one: "one camera alone",
  predicted: "its past motion: not seen",
  held: "its last place: not seen",
  lost: "nothing: lost",
};

const live = new Live();
stopWith(live, find("stop"));
watchLink(live, find("link"));
const hold = new Hold(live, find("hold"));
let views = null;
let control = null;
let message = "";

live.addEventListener("hello", ({ detail }) => {
  // a console that was started again has the same views
  views ??= new Views(places(detail.views));
});

function places(told) {
  const grid = find("views");
  return told.map((view, at) => {
    const figure = document.createElement("figure");
    const canvas = document.createElement("canvas");
    canvas.width = 640;
    canvas.height = 480;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", view.name);
    const caption = document.createElement("figcaption");
    const stamp = document.createElement("span");
    stamp.className = "stamp";
    caption.append(`${view.kind === "eye" ? "arm, " : ""}${view.name} `, stamp);
    figure.append(canvas, caption);
    grid.append(figure);
    return [at, figure];
  });
}

const actions = {
  take() {
    message = "";
    live.send({ type: "take", name: "" });
    hold.letGo();
  },
  give() {
    hold.end();
    live.send({ type: "give" });
  },
  reset() {
    message = "";
    hold.end();
    live.send({ type: "reset" });
  },
  homed: () => live.send({ type: "homed" }),
};
for (const [name, act] of Object.entries(actions)) find(name).addEventListener("click", act);
const keys = { t: actions.take, g: actions.give, r: actions.reset };
addEventListener("keydown", (event) => {
  if (event.repeat || event.ctrlKey || event.altKey || event.metaKey || event.target.closest("input")) return;
  keys[event.key.toLowerCase()]?.();
});
// who is in control and silent for three seconds is not any more
setInterval(() => {
  if (control?.yours && !hold.isHeld) live.send({ type: "here" });
}, HERE_MS);

live.addEventListener("refused", ({ detail }) => {
  message = detail.why;
});
live.addEventListener("lost", () => {
  control = null;
});
let due = false;
live.addEventListener("live", ({ detail }) => {
  control = detail.control;
  if (due) return;
  due = true;
  requestAnimationFrame(() => {
    due = false;
    show(live.newest);
  });
});
hold.addEventListener("change", () => {
  if (hold.isHeld) message = "";
  if (live.newest) showControl(live.newest.control);
});

function show({ control, snapshot }) {
  showControl(control);
  showArm(snapshot.arm);
  showHand(snapshot);
  rows(
    find("cameras"),
    snapshot.cameras.map((camera) => [
      camera.name,
      camera.rate ? `${camera.rate.toFixed(0)}/s` : "",
      ms(camera.age_us),
      ...camera.balls.map((ball) => `${ball.state}${ball.state === "occluded" ? ` ${(ball.visible * 100).toFixed(0)} %` : ""}`),
    ]),
  );
  rows(
    find("links"),
    snapshot.links.map((link) => [
      link.name,
      link.connected ? ms(link.age_us) : "AWAY",
      link.loss === null ? "" : `${(link.loss * 100).toFixed(1)} %`,
      link.round_trip_us === null ? "" : `${(link.round_trip_us / 1000).toFixed(2)} ms`,
    ]),
  );
  rows(
    find("delays"),
    snapshot.delays.map((delay) => [delay.stage, delay.p50_ms.toFixed(2), delay.p99_ms.toFixed(2)]),
  );
  lines(find("lines"), snapshot.lines);
}

function showControl(control) {
  const held = hold.isHeld;
  find("take").disabled = !control.drives || control.yours;
  find("give").disabled = !control.yours;
  find("reset").disabled = !control.yours;
  find("homed").disabled = !control.yours;
  find("hold").disabled = !control.yours;
  find("hold").setAttribute("aria-pressed", String(held && control.pressed));
  document.body.classList.toggle("stopped", control.stopped);
  write(find("control"), message || standing(control, held));
}

function standing(control, held) {
  if (!control.drives) return "The buttons are not in the console. STOP works from here.";
  if (control.stopped) return control.yours ? "Stopped. Reset (R), then press anew." : "Stopped.";
  if (!control.holder) return "Nobody is in control: take it (T).";
  if (!control.yours) return `${control.holder} is in control. STOP works from here too.`;
  if (held) return control.pressed ? "You hold the button." : "Held, but not in time: the arm does not move.";
  return "You are in control. Hold the space bar to move the arm.";
}

function showArm(arm) {
  const held = arm?.state === "engaged";
  document.body.classList.toggle("engaged", held);
  write(find("standing"), arm ? arm.standing : "not heard yet");
  items(find("limits"), arm ? arm.limits : []);
}

function showHand({ hand, engaged_share: share, arm, pictures }) {
  const axes = (values, digits) => values.map((value) => value.toFixed(digits)).join(", ");
  const facts = [];
  if (hand) {
    facts.push(["known by", `${KNOWN[hand.state] ?? hand.state}, ${ms(hand.age_us)} ago`]);
    if (hand.position_mm) facts.push(["at", `${axes(hand.position_mm, 1)} mm`]);
    if (hand.sigma_mm) facts.push(["known to", `${axes(hand.sigma_mm, 2)} mm, ${axes(hand.sigma_deg, 2)} deg`]);
  }
  if (arm) {
    facts.push(["tool at", `${axes(arm.tool_mm, 0)} mm`]);
    facts.push(["joints", `${axes(arm.joints_deg ?? arm.set_point_deg, 1)} deg`]);
    facts.push(["asked speed", `${(arm.speed_share * 100).toFixed(0)} % of what is allowed`]);
    facts.push(["followed", `${(share * 100).toFixed(0)} % of the time`]);
    facts.push(["heard", `arm ${ms(arm.age_us)} ago; it has heard the button ${ms(arm.button_age_us)} ago`]);
  }
  for (const picture of pictures) {
    if (picture.count) facts.push([`${picture.name} eye`, `${ms(picture.age_us)} old${picture.stale ? ", STALE" : ""}`]);
  }
  items(find("hand"), facts.map(([name, text]) => `${name}: ${text}`), "dd");
}
