// The replay page: a recorded session at any moment, and all of it as plots and files.
//
// One moment is asked for at a time, the newest that is wanted; what is slow shows fewer, never older ones.

import { Live } from "./live.js";
import { find, isTyping, items, lines, ms, rows, watchLink, write } from "./page.js";
import { Plot } from "./plot.js";
import { stopWith } from "./stop.js";
import { draw } from "./views.js";

const live = new Live();
stopWith(live, find("stop"));
watchLink(live, find("link"));

// Moments a second while it plays, at most: the operator's computer has other work.
const PLAY_MS = 1000 / 15;
const SECOND_US = 1e6;
const BALLS = ["red", "green", "blue", "yellow"];

const slider = find("slider");
let session = null; // what is open: name, length_us, cameras ...
let opening = ""; // what is being opened
let at = null; // the moment that is shown
let wantedUs = null;
let placeUs = null; // what was wanted last
let asking = false;
let playing = null; // when it began to play, and from where

const seconds = (us) => `${(us / SECOND_US).toFixed(3)} s`;
const path = (name) => `/api/sessions/${encodeURIComponent(name)}`;

async function ask(address, options) {
  const answer = await fetch(address, options);
  if (!answer.ok) throw new Error((await answer.text()).trim() || `refused (${answer.status})`);
  return answer;
}

function tell(words, bad = false) {
  write(find("about"), words);
  find("about").classList.toggle("bad", bad);
}

// Which sessions there are; `again`: what is open may have grown.
async function list(again) {
  try {
    const { folder, why, sessions } = await (await ask("/api/sessions")).json();
    const texts = sessions.map((one) => {
      const when = new Date(one.changed_s * 1000).toLocaleString();
      return [one.name, `${one.name}, ${(one.bytes / 1e6).toFixed(1)} MB, ${when}`];
    });
    const choices = texts.length ? [["", "choose one ..."], ...texts] : [["", folder ? `none in ${folder} yet` : "none"]];
    find("session").replaceChildren(...choices.map(([value, text]) => new Option(text, value)));
    const wanted = opening || session?.name || (new URLSearchParams(location.search).get("session") ?? "");
    if (sessions.some((one) => one.name === wanted)) {
      find("session").value = wanted;
      if (session?.name === wanted ? again : !opening) await open(wanted);
    } else if (!session) {
      tell(why ?? (wanted ? `There is no session ${wanted} in ${folder}.` : ""), wanted !== "");
    }
  } catch (error) {
    tell(error.message, true);
  }
}

// Opens a session; one that is open already is gone on with where it was.
async function open(name) {
  const fromUs = session?.name === name ? placeUs : null;
  clear();
  opening = name;
  tell(`Looking through ${name} ...`);
  try {
    const one = await (await ask(path(name))).json();
    // who has chosen another meanwhile waits for that
    if (opening !== name) return;
    session = one;
  } catch (error) {
    if (opening === name) tell(error.message, true);
    return;
  } finally {
    if (opening === name) opening = "";
  }
  const some = session.length_us > 0;
  for (const id of ["play", "back", "on", "slider"]) find(id).disabled = !some;
  find("whole").disabled = false;
  const url = new URL(location.href);
  url.searchParams.set("session", name);
  history.replaceState(null, "", url);
  const pictures = session.cameras.map((one) => `${one.name}: ${one.pictures} pictures of ${one.source}`);
  const cut = session.cut ? " The file has no end: it was cut short, or is being written; this is as much of it as there is." : "";
  tell(`${(session.length_us / SECOND_US).toFixed(1)} s, ${session.mode} mode, tetrad ${session.version}; ${pictures.join("; ")}.${cut}`);
  slider.max = session.length_us;
  slider.value = 0;
  find("views").replaceChildren(...session.cameras.map(view));
  want(fromUs ?? session.first_us);
  follow(false);
}

// Nothing of a session that was open is shown under the name of another.
function clear() {
  pause();
  session = null;
  at = null;
  wantedUs = null;
  for (const id of ["play", "back", "on", "slider", "whole"]) find(id).disabled = true;
  for (const id of ["views", "plots", "limits", "arm", "hand", "cameras", "told", "files"]) find(id).replaceChildren();
  write(find("standing"), "nothing is open");
  write(find("time"), seconds(0));
  progress("");
}

// How far the reading of all of it is; readers of the screen are not told each share of it.
function progress(words, share = "") {
  write(find("progress"), words);
  write(find("share"), share);
}

function view(camera) {
  const figure = document.createElement("figure");
  const canvas = document.createElement("canvas");
  canvas.width = camera.width || 640;
  canvas.height = camera.height || 480;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `The ${camera.name} camera's picture`);
  const caption = document.createElement("figcaption");
  const name = document.createElement("span");
  write(name, camera.name);
  const stamp = document.createElement("span");
  stamp.className = "stamp";
  caption.append(name, stamp);
  figure.append(canvas, caption);
  return figure;
}

// Shows that moment as soon as what is being asked for has come.
function want(us) {
  wantedUs = Math.min(Math.max(Math.round(us), 0), session?.length_us ?? 0);
  placeUs = wantedUs;
  if (document.activeElement !== slider || playing) slider.value = wantedUs;
  slider.setAttribute("aria-valuetext", seconds(wantedUs));
  if (!asking) show();
}

async function show() {
  asking = true;
  let one = null;
  try {
    while (wantedUs !== null && session) {
      one = session;
      const us = wantedUs;
      wantedUs = null;
      const moment = await (await ask(`${path(one.name)}/moment?t_us=${us}`)).json();
      const pictures = await Promise.all(moment.cameras.map((camera, number) => picture(one, camera, number, us)));
      if (session !== one) continue;
      at = moment;
      moment.cameras.forEach((camera, number) => paint(camera, number, pictures[number]));
      write(find("time"), `${seconds(us)} (${moment.number} of ${one.moments})`);
      facts(moment);
    }
  } catch (error) {
    if (session === one) {
      pause();
      tell(error.message, true);
    }
  } finally {
    asking = false;
  }
  // what was asked for while that failed, or another session
  if (wantedUs !== null) show();
}

async function picture(one, camera, number, us) {
  if (camera.age_us === null) return null;
  const answer = await ask(`${path(one.name)}/picture?camera=${number}&t_us=${us}`);
  return createImageBitmap(await answer.blob());
}

function paint(camera, number, bitmap) {
  const figure = find("views").children[number];
  const canvas = figure.querySelector("canvas");
  figure.classList.toggle("missing", bitmap === null);
  figure.classList.toggle("stale", bitmap !== null && camera.stale);
  if (bitmap) {
    draw(canvas, bitmap, camera.balls ?? []);
    bitmap.close();
  } else {
    canvas.getContext("2d").clearRect(0, 0, canvas.width, canvas.height);
  }
  write(figure.querySelector(".stamp"), camera.age_us === null ? "no picture" : `${camera.stale ? "STALE: " : ""}taken ${ms(camera.age_us)} before`);
}

const number = (value, digits) => (value === null || value === undefined ? "not known" : value.toFixed(digits));
const numbers = (values, digits, unit) => (values?.length ? `${values.map((value) => value.toFixed(digits)).join(", ")} ${unit}` : "not known");

function define(list, pairs) {
  while (list.children.length > 2 * pairs.length) list.lastElementChild.remove();
  pairs.flat().forEach((text, at) => {
    const child = list.children[at] ?? list.appendChild(document.createElement(at % 2 ? "dd" : "dt"));
    write(child, text);
  });
}

function facts({ cameras, hand, arm, buttons, lines: told }) {
  document.body.classList.toggle("unheard", Boolean(arm?.silent));
  write(find("standing"), arm ? arm.standing : "no arm is recorded by then");
  items(find("limits"), arm?.slowed ?? []);
  const held = buttons?.home ? "held for the way home" : "held";
  const button = !buttons ? "not recorded" : buttons.stop ? "STOP" : buttons.pressed ? held : "let go";
  const scale = buttons?.scale_percent ?? null;
  define(find("arm"), arm ? [
    ["Hold-to-run", button],
    ["Scale of the next press", scale === null ? "not recorded" : `${scale} % of the slave's`],
    ["Share of its speed", arm.speed_share === null ? "not known" : `${(arm.speed_share * 100).toFixed(0)} %`],
    ["Heard", `${ms(arm.age_us)} before`],
    ["Newest motion, age", ms(arm.command_age_us)],
    ["Joints", numbers(arm.joints_deg, 1, "deg")],
    ["Set-point", numbers(arm.set_point_deg, 1, "deg")],
  ] : [["Hold-to-run", button]]);
  define(find("hand"), hand ? [
    ["Known", hand.silent ? `nothing: not heard for ${ms(hand.age_us)}` : hand.state],
    [hand.silent ? "Place, last" : "Place", hand.position_mm ? numbers(hand.position_mm, 1, "mm") : `not known: ${hand.refusal || "no pose"}`],
    ["Fits to", hand.residual_px === null ? "not known" : `${number(hand.residual_px, 2)} px`],
    ["Of the instant", `${ms(hand.age_us)} before`],
  ] : [["Known", "nothing is recorded by then"]]);
  rows(find("cameras"), cameras.map((camera, at) => {
    const balls = BALLS.map((name) => {
      const ball = camera.balls?.find((one) => one.name === name);
      return ball && camera.stale ? "not known" : ball ? `${ball.state}${ball.state === "lost" ? "" : ` ${(ball.visible * 100).toFixed(0)} %`}` : "-";
    });
    return [session.cameras[at].name, camera.age_us === null ? "none" : `${ms(camera.age_us)} before`, ...balls];
  }));
  lines(find("told"), told.map((line) => ({ text: `${seconds(line.t_us)}: ${line.text}` })));
}

function pause() {
  playing = null;
  write(find("play").firstChild, "Play ");
}

function play() {
  if (!session) return;
  if (playing) return pause();
  // the slider's own steps may leave it a little before the end
  const fromUs = at?.next_us === null || here() >= session.length_us ? 0 : here();
  playing = { fromUs, sinceMs: performance.now(), lastMs: -Infinity };
  write(find("play").firstChild, "Pause ");
  requestAnimationFrame(tick);
}

function tick(nowMs) {
  if (!playing) return;
  const us = playing.fromUs + (nowMs - playing.sinceMs) * 1000;
  if (!asking && nowMs - playing.lastMs >= PLAY_MS) {
    playing.lastMs = nowMs;
    want(us);
  }
  if (us >= session.length_us) return pause();
  requestAnimationFrame(tick);
}

function step(us) {
  pause();
  if (session && us !== null && us !== undefined) want(us);
}

const here = () => wantedUs ?? at?.t_us ?? 0;

const KEYS = {
  ArrowLeft: (event) => (event.shiftKey ? here() - SECOND_US : at?.previous_us ?? 0),
  ArrowRight: (event) => (event.shiftKey ? here() + SECOND_US : at?.next_us ?? session.length_us),
  PageUp: () => here() + 10 * SECOND_US,
  PageDown: () => here() - 10 * SECOND_US,
  Home: () => 0,
  End: () => session.length_us,
};

addEventListener("keydown", (event) => {
  if (!session || event.ctrlKey || event.altKey || event.metaKey || isTyping(event)) return;
  if (event.key?.toLowerCase() === "p") return play();
  const to = KEYS[event.key];
  if (!to) return;
  // the slider's own steps are not frames
  event.preventDefault();
  step(to(event));
  slider.value = wantedUs ?? slider.value;
});

slider.addEventListener("input", () => step(Number(slider.value)));
find("play").addEventListener("click", play);
find("back").addEventListener("click", () => step(at?.previous_us ?? 0));
find("on").addEventListener("click", () => step(at?.next_us));
find("again").addEventListener("click", () => list(true));
find("session").addEventListener("change", (event) => event.target.value && open(event.target.value));
find("whole").addEventListener("click", () => follow(true));

// Asks how far the reading of all of it is, until it is done; `begin`: begins it.
async function follow(begin) {
  const one = session;
  try {
    let told = await (await ask(`${path(one.name)}/whole`, { method: begin ? "POST" : "GET" })).json();
    while (told.state === "reading" && session === one) {
      progress("reading:", `${(told.share * 100).toFixed(0)} %`);
      await new Promise((done) => setTimeout(done, 300));
      told = await (await ask(`${path(one.name)}/whole`)).json();
    }
    if (session !== one) return;
    if (told.state === "failed") throw new Error(told.why);
    if (told.state === "ready") await plots(one, told);
  } catch (error) {
    if (session === one) progress(error.message);
  }
}

async function plots(one, { files, sections }) {
  progress("Read. To be saved:");
  find("files").replaceChildren(...files.map((file) => {
    const link = document.createElement("a");
    link.href = `${path(one.name)}/files/${file.name}`;
    link.download = "";
    link.textContent = `${file.name} (${(file.bytes / 1000).toFixed(0)} kB)`;
    const item = document.createElement("li");
    item.append(link);
    return item;
  }));
  find("plots").replaceChildren();
  for (const { title, text, panels } of sections) {
    const panel = document.createElement("div");
    panel.className = "panel";
    const heading = document.createElement("h2");
    write(heading, title);
    const note = document.createElement("p");
    note.className = "note";
    write(note, text);
    const pair = document.createElement("div");
    pair.className = "pair";
    panel.append(heading, note, pair);
    find("plots").append(panel);
    // all have their places before the first is drawn as wide as its own
    const places = panels.map(() => document.createElement("div"));
    for (const place of places) place.className = "plot";
    pair.append(...places);
    for (const [at, { data, layout }] of panels.entries()) {
      // what hides and shows curves is a click on their names
      await new Plot(places[at]).draw(() => ({ traces: data, layout }));
      if (session !== one) return;
    }
  }
}

list(false);
