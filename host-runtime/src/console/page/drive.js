// The drive page: hold-to-run, the views, and in words what the arm does and why.

import { Controls } from "./controls.js";
import { Gauges } from "./gauges.js";
import { Live } from "./live.js";
import { find, items, lines, ms, rows, watchLink, write } from "./page.js";
import { DelayPlot } from "./plot-delays.js";
import { ENLARGED, Scene } from "./scene.js";
import { stopWith } from "./stop.js";
import { figureOf, Views } from "./views.js";

// What is read is written ten times a second, not thirty; what is pressed shows at once.
const READ_MS = 100;

// A scale may be small.
const SIGNIFICANT = new Intl.NumberFormat("en", { maximumSignificantDigits: 2 });

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
const controls = new Controls(live);
const gauges = new Gauges(find("gauges"));
const delays = new DelayPlot(find("delay-plot"));
let views = null;
let scene = null;
let readMs = -Infinity;

fetch("/api/arm")
  .then((answer) => answer.json())
  .then(({ links }) => {
    scene = new Scene(find("scene"), links);
  })
  .catch(() => write(find("scene-words"), "the arm's links did not come: load the page again"));

live.addEventListener("hello", ({ detail }) => {
  // a console that was started again has the same views
  views ??= new Views(places(detail.views), live);
});

function places(told) {
  const grid = find("views");
  return told.map((view, at) => {
    const figure = figureOf(view.kind === "eye" ? `arm, ${view.name}` : view.name);
    figure.classList.add(view.kind);
    grid.append(figure);
    return [at, figure];
  });
}

let due = false;
live.addEventListener("live", () => {
  if (due) return;
  due = true;
  requestAnimationFrame(() => {
    due = false;
    show(live.newest);
  });
});

function show({ control, snapshot }) {
  controls.show(control);
  showArm(snapshot.arm);
  const now = performance.now();
  if (now - readMs < READ_MS) return;
  readMs = now;
  scene?.show(snapshot);
  showHand(snapshot);
  gauges.show(snapshot.hand?.sigma_mm ?? null, snapshot.hand?.sigma_deg ?? null);
  showTables(snapshot);
  delays.show(snapshot.delays);
  lines(find("lines"), snapshot.lines);
}

function showArm(arm) {
  document.body.classList.toggle("engaged", arm?.state === "engaged");
  write(find("standing"), arm ? arm.standing : "not heard yet");
  items(find("limits"), arm ? arm.limits : []);
}

function showHand({ hand, engaged_share: share, arm, slave, pictures }) {
  const axes = (values, digits) => values.map((value) => value.toFixed(digits)).join(", ");
  const facts = [];
  if (hand) {
    facts.push(["hand known by", `${KNOWN[hand.state] ?? hand.state}, ${ms(hand.age_us)} ago`]);
    if (hand.position_mm) facts.push(["hand at", `${axes(hand.position_mm, 1)} mm`]);
  }
  if (arm) {
    facts.push(["tool at", `${axes(arm.tool_mm, 0)} mm`]);
    facts.push(["joints", `${axes(arm.joints_deg ?? arm.set_point_deg, 1)} deg${arm.joints_deg ? "" : " (as told)"}`]);
    facts.push(["controller", arm.controller]);
    facts.push(["asked speed", `${(arm.speed_share * 100).toFixed(0)} % of what is allowed`]);
    facts.push(["followed", `${(share * 100).toFixed(0)} % of the time`]);
    facts.push(["heard", `arm ${ms(arm.age_us)} ago; it heard the button ${ms(arm.button_age_us)} ago`]);
  }
  if (slave) {
    const least = arm ? ` (${SIGNIFICANT.format(slave.scale * 10)} mm at the most)` : "";
    facts.push(["scale", `10 mm of the hand are ${SIGNIFICANT.format((arm?.scale ?? slave.scale) * 10)} mm of the tool${least}`]);
    facts.push(["clutch", "let go, move the hand back, press again: the arm goes on from where it is"]);
  }
  for (const picture of pictures) {
    if (picture.count) facts.push([`${picture.name} eye`, `${ms(picture.age_us)} old${picture.stale ? ", STALE" : ""}`]);
  }
  const texts = facts.flat();
  const list = find("hand");
  while (list.children.length > texts.length) list.lastElementChild.remove();
  texts.forEach((text, at) => {
    write(list.children[at] ?? list.appendChild(document.createElement(at % 2 ? "dd" : "dt")), text);
  });
  const asked = arm?.state === "engaged" && !arm.goes_home ? "; dotted: asked by the hand" : "";
  const known = hand?.covariance_mm2 ? `; rings: how well the hand is known, x ${ENLARGED}` : "";
  write(find("scene-words"), `solid: measured; dashed: told${asked}${known}`);
}

function showTables({ cameras, links, delays: stages }) {
  const seen = (ball) => {
    const part = ball.state === "occluded" || ball.visible < 0.995 ? ` ${(ball.visible * 100).toFixed(0)} %` : "";
    return `${ball.state}${ball.state === "predicted" || ball.state === "lost" ? "" : part}`;
  };
  rows(
    find("cameras"),
    cameras.map((camera) => [camera.name, camera.rate ? `${camera.rate.toFixed(0)}/s` : "", ms(camera.age_us), ...camera.balls.map(seen)]),
  );
  rows(
    find("links"),
    links.map((link) => [
      link.name,
      link.connected ? ms(link.age_us) : "AWAY",
      link.loss === null ? "same program" : `${(link.loss * 100).toFixed(1)} %`,
      link.round_trip_us === null ? "" : `${(link.round_trip_us / 1000).toFixed(2)} ms`,
    ]),
  );
  rows(
    find("delays"),
    stages.map((delay) => [delay.stage, delay.p50_ms.toFixed(2), delay.p99_ms.toFixed(2), delay.max_ms.toFixed(2)]),
  );
}
