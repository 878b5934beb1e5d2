// The drive page: hold-to-run, the views, and in words what the arm does and why.

import { Controls } from "./controls.js";
import { Gauges } from "./gauges.js";
import { Live } from "./live.js";
import {
  find, isEngaged, isHeard, items, keepName, keptName, knownBy, lines, ms, rows, standingOf, viewsOf, watchLink, write,
} from "./page.js";
import { DelayPlot } from "./plot-delays.js";
import { ENLARGED, Scene } from "./scene.js";
import { stopWith } from "./stop.js";
import { figureOf, Views } from "./views.js";

// What is read is written ten times a second, not thirty; what is pressed shows at once.
const READ_MS = 100;

// A scale may be small.
const SIGNIFICANT = new Intl.NumberFormat("en", { maximumSignificantDigits: 2 });

const live = new Live();
stopWith(live, find("stop"));
watchLink(live, find("link"));
const controls = new Controls(live);
const gauges = new Gauges(find("gauges"));
const delays = new DelayPlot(find("delay-plot"));
let told = [];
let views = null;
// the views that are shown
let shown = "";
let scene = null;
let readMs = -Infinity;

fetch("/api/arm")
  .then((answer) => answer.json())
  .then(({ links }) => {
    scene = new Scene(find("scene"), links);
    find("nearer").addEventListener("click", () => scene.nearer());
    find("farther").addEventListener("click", () => scene.farther());
  })
  .catch(() => write(find("scene-words"), "the arm's links did not come: load the page again"));

live.addEventListener("hello", ({ detail }) => {
  told = detail.views;
});

function look(snapshot) {
  const now = viewsOf(told, snapshot);
  const key = JSON.stringify(now);
  if (key !== shown) {
    shown = key;
    views?.close();
    views = new Views(places(now), live);
  }
  views.explain(snapshot.cameras);
}

// Whoever looks closely at the arm goes on holding the space bar.
for (const id of ["nearer", "farther"]) find(id).addEventListener("mousedown", (event) => event.preventDefault());

const name = find("name");
name.value = keptName();
// also where the page is left without another word
name.addEventListener("input", () => keepName(name.value));

function places(all) {
  const grid = find("views");
  grid.replaceChildren();
  return all.map((view) => {
    const figure = figureOf(view.kind === "eye" ? `arm, ${view.name}` : view.name);
    figure.classList.add(view.kind);
    grid.append(figure);
    return [view.at, figure];
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
  look(snapshot);
  scene?.show(snapshot);
  showHand(snapshot);
  const hand = isHeard(snapshot.hand?.age_us) ? snapshot.hand : null;
  gauges.show(hand?.sigma_mm ?? null, hand?.sigma_deg ?? null);
  showTables(snapshot);
  delays.show(snapshot.delays);
  lines(find("lines"), snapshot.lines);
}

function showArm(arm) {
  document.body.classList.toggle("engaged", isEngaged(arm));
  document.body.classList.toggle("unheard", Boolean(arm?.silent));
  write(find("standing"), standingOf(arm));
  items(find("limits"), arm && !arm.silent ? arm.limits : []);
}

function showHand({ hand, engaged_share: share, arm, slave, pictures, recording }) {
  const axes = (values, digits) => values.map((value) => value.toFixed(digits)).join(", ");
  const facts = [];
  const heard = isHeard(hand?.age_us);
  if (hand) {
    facts.push(["hand known by", knownBy(hand)]);
    if (hand.position_mm) facts.push([heard ? "hand at" : "hand was at", `${axes(hand.position_mm, 1)} mm`]);
  }
  if (arm) {
    facts.push(["tool at", `${axes(arm.tool_mm, 0)} mm`]);
    facts.push(["joints", `${axes(arm.joints_deg ?? arm.set_point_deg, 1)} deg${arm.joints_deg ? "" : " (as told)"}`]);
    facts.push(["controller", arm.controller]);
    if (!arm.silent) facts.push(["asked speed", `${(arm.speed_share * 100).toFixed(0)} % of what is allowed`]);
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
  if (recording) facts.push(["recorded", recorded(recording)]);
  const texts = facts.flat();
  const list = find("hand");
  while (list.children.length > texts.length) list.lastElementChild.remove();
  texts.forEach((text, at) => {
    write(list.children[at] ?? list.appendChild(document.createElement(at % 2 ? "dd" : "dt")), text);
  });
  const asked = isEngaged(arm) && !arm.goes_home ? "; dotted: asked by the hand" : "";
  const last = hand?.position_mm && !heard ? "; hollow hand: where it was last" : "";
  const known = heard && hand.covariance_mm2 ? `; rings: how well the hand is known, x ${ENLARGED}` : "";
  write(find("scene-words"), `${arm?.silent ? "hollow: as last measured; dashed: as last told" : "solid: measured; dashed: told"}${asked}${known}${last}`);
}

function recorded({ file, left_out: leftOut, failed }) {
  if (failed) return `${file}: WRITING HAS FAILED, nothing more is recorded`;
  return leftOut ? `${file}: ${leftOut} messages were LEFT OUT, the disk is behind` : file;
}

function showTables({ cameras, links, delays: stages }) {
  const seen = (ball) => {
    const part = ball.state === "occluded" || ball.visible < 0.995 ? ` ${(ball.visible * 100).toFixed(0)} %` : "";
    return `${ball.state}${ball.state === "predicted" || ball.state === "lost" ? "" : part}`;
  };
  rows(
    find("cameras"),
    cameras.map((camera) => {
      // of what a camera sees that is not heard any more nobody knows
      const heard = isHeard(camera.age_us);
      const rate = heard && camera.rate ? `${camera.rate.toFixed(0)}/s` : "";
      return [camera.name, rate, ms(camera.age_us), ...camera.balls.map((ball) => (heard ? seen(ball) : "not known"))];
    }),
  );
  rows(
    find("links"),
    links.map((link) => [
      link.name,
      link.connected ? ms(link.age_us) : "AWAY",
      lossOf(link),
      link.round_trip_us === null ? "" : `${(link.round_trip_us / 1000).toFixed(2)} ms`,
    ]),
  );
  rows(
    find("delays"),
    stages.map(({ stage, lately, ...all }) => [stage, ...[lately, all].flatMap(spread)]),
  );
}

const percent = (share) => (share === null || share === undefined ? "none sent" : `${(share * 100).toFixed(1)} %`);

// What was lost on the way to a station; one in the same program counts no packets, one that is away has got none.
function lossOf({ sent_packets: sent, loss, loss_lately: lately }) {
  if (sent === null) return "same program";
  return loss === null ? "none sent" : `${percent(lately)} (${percent(loss)} in all)`;
}

// Half within, 99 of 100 within, the longest, milliseconds; null where nothing was measured.
const spread = (of) => [of?.p50_ms, of?.p99_ms, of?.max_ms].map((value) => value?.toFixed(2) ?? "");
