// The arm and the hand in one scene, drawn on a canvas: where the joints were measured, as a ghost where they
// were told to be, where the hand asks the tool to be, and the hand with its four balls.

import { isHeard } from "./page.js";
import { colour, whenRecoloured } from "./palette.js";
import { add, column, compose, Eye, IDENTITY, inverse, product, skeleton, times, triangle, turn } from "./scene-space.js";

// The hand stands beside the arm; its balls are drawn larger than they are.
const STAND = [0.35, -0.95, 0.45];
const HAND_ARM_M = 0.16;
const BALL_M = 0.03;
const LETTERS = ["R", "G", "B", "Y"];
const COLOURS = ["--red", "--green", "--blue", "--yellow"];

// A deviation of a millimetre is drawn as so many.
export const ENLARGED = 100;

const GRID_M = 1;
const CELL_M = 0.25;
const TOOL_M = 0.12;

export class Scene {
  #canvas;
  #eye;
  #links;
  #newest = null;
  #due = false;

  // `links`: the arm's link table, as /api/arm tells it.
  constructor(canvas, links) {
    this.#canvas = canvas;
    this.#links = links;
    this.#eye = new Eye(canvas, () => this.#again());
    new ResizeObserver(() => this.#again()).observe(canvas);
    whenRecoloured(() => this.#again());
  }

  show(snapshot) {
    this.#newest = snapshot;
    this.#again();
  }

  // For who has neither wheel nor keys.
  nearer() {
    this.#eye.nearer();
  }

  farther() {
    this.#eye.farther();
  }

  #again() {
    if (this.#due || !this.#newest) return;
    this.#due = true;
    requestAnimationFrame(() => {
      this.#due = false;
      this.#draw(this.#newest);
    });
  }

  #draw({ arm, hand, slave, goal }) {
    const pen = this.#fit();
    const width = this.#canvas.clientWidth;
    const height = this.#canvas.clientHeight;
    const see = this.#eye.projection(width, height);
    const page = new Page(pen, see);
    floor(page, slave);
    if (arm) drawArm(page, this.#links, arm, goal);
    if (hand?.position_mm) drawHand(page, hand, slave?.robot_from_hand ?? IDENTITY);
    page.finish();
  }

  // The canvas has the screen's own pixels; the pen draws in those of the page.
  #fit() {
    const by = devicePixelRatio;
    const [width, height] = [this.#canvas.clientWidth, this.#canvas.clientHeight].map((size) => Math.round(size * by));
    if (this.#canvas.width !== width || this.#canvas.height !== height) {
      this.#canvas.width = width;
      this.#canvas.height = height;
    }
    const pen = this.#canvas.getContext("2d");
    pen.setTransform(by, 0, 0, by, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.lineCap = "round";
    pen.lineJoin = "round";
    return pen;
  }
}

// What is drawn: flat things at once, what hides other things from far to near, words last.
class Page {
  #solid = [];
  #words = [];

  constructor(pen, see) {
    this.pen = pen;
    this.see = see;
  }

  // A line at once, of a width in pixels.
  line(from, to, style, width = 1, dash = []) {
    const { pen, see } = this;
    const [a, b] = [see(from), see(to)];
    pen.strokeStyle = style;
    pen.lineWidth = width;
    pen.setLineDash(dash);
    pen.beginPath();
    pen.moveTo(a.x, a.y);
    pen.lineTo(b.x, b.y);
    pen.stroke();
    pen.setLineDash([]);
  }

  // A rod with an outline, of a width in metres.
  rod(from, to, style, edge, width) {
    const middle = this.see(times(add(from, to), 0.5));
    this.#solid.push([middle.depth, () => {
      const px = Math.max(2, width * middle.scale);
      this.line(from, to, edge, px + 2.5);
      this.line(from, to, style, px);
    }]);
  }

  // A ball, with a letter in it where it has one.
  ball(at, radius, style, edge, letter = "", ink = "") {
    const seen = this.see(at);
    // a little nearer than the rods that meet in it
    this.#solid.push([seen.depth - radius, () => {
      const { pen } = this;
      const px = Math.max(2.5, radius * seen.scale);
      pen.beginPath();
      pen.arc(seen.x, seen.y, px, 0, 2 * Math.PI);
      pen.fillStyle = style;
      pen.fill();
      pen.lineWidth = 1.2;
      pen.strokeStyle = edge;
      pen.stroke();
      if (!letter) return;
      pen.fillStyle = ink;
      pen.font = `bold ${Math.max(11, px * 1.2)}px system-ui, "DejaVu Sans", sans-serif`;
      pen.textAlign = "center";
      pen.textBaseline = "middle";
      pen.fillText(letter, seen.x, seen.y + 0.5);
      pen.textAlign = "start";
      pen.textBaseline = "alphabetic";
    }]);
  }

  // Words beside a place.
  word(at, text, style, dx = 8, dy = -8) {
    this.#words.push([this.see(at), text, style, dx, dy]);
  }

  finish() {
    this.#solid.sort(([a], [b]) => b - a).forEach(([, draw]) => draw());
    const { pen } = this;
    pen.font = 'bold 13px system-ui, "DejaVu Sans", sans-serif';
    for (const [{ x, y }, text, style, dx, dy] of this.#words) {
      pen.strokeStyle = colour("--panel");
      pen.lineWidth = 4;
      pen.strokeText(text, x + dx, y + dy);
      pen.fillStyle = style;
      pen.fillText(text, x + dx, y + dy);
    }
  }
}

// A grid on the floor, with the robot's axes, and the box in which the tool may be.
function floor(page, slave) {
  const line = colour("--line");
  for (let at = -GRID_M; at <= GRID_M + 1e-9; at += CELL_M) {
    page.line([at, -GRID_M, 0], [at, GRID_M, 0], line);
    page.line([-GRID_M, at, 0], [GRID_M, at, 0], line);
  }
  const soft = colour("--soft");
  [["x", [0.4, 0, 0]], ["y", [0, 0.4, 0]]].forEach(([name, end]) => {
    page.line([0, 0, 0], end, soft, 2);
    page.word(end, name, soft, 2, 4);
  });
  if (!slave) return;
  // more than the grid: the tool stops there
  const edge = colour("--edge");
  const [low, high] = [slave.workspace_min_mm, slave.workspace_max_mm].map((corner) => times(corner, 1e-3));
  const corner = (bits) => [0, 1, 2].map((axis) => (bits & (1 << axis) ? high : low)[axis]);
  for (let bits = 0; bits < 8; bits += 1) {
    for (const axis of [1, 2, 4]) {
      if (!(bits & axis)) page.line(corner(bits), corner(bits | axis), edge, 1, [3, 5]);
    }
  }
}

function drawArm(page, links, arm, goal) {
  const radians = (degrees) => degrees.map((angle) => (angle * Math.PI) / 180);
  const told = skeleton(links, radians(arm.set_point_deg));
  const tool = { r: arm.tool_rotation, t: times(arm.tool_mm, 1e-3) };
  const text = colour("--text");
  const ghost = colour("--link");
  if (arm.joints_deg) {
    const is = skeleton(links, radians(arm.joints_deg));
    // the tool is where the last link is, as it is for the joints that were told
    const end = compose(is.pose, compose(inverse(told.pose), tool));
    shadow(page, [...is.corners.map(({ at }) => at), end.t]);
    // hollow: that it is still there is not known
    solid(page, is.corners, end, colour(arm.silent ? "--panel" : "--arm"));
  }
  const corners = [...told.corners.map(({ at }) => at), tool.t];
  corners.slice(1).forEach((at, before) => page.line(corners[before], at, ghost, 2, [7, 5]));
  axes(page, tool, ghost, [7, 5]);
  const since = arm.silent ? "told last: not heard now" : "told";
  page.word(tool.t, arm.joints_deg ? since : `${since} (not measured yet)`, ghost, 10, 16);
  // what a slave that is silent would be asked nobody knows
  if (goal && !arm.silent) {
    const asked = { r: goal.rotation, t: times(goal.place_mm, 1e-3) };
    page.line(tool.t, asked.t, colour("--warn"), 1.5, [2, 4]);
    axes(page, asked, colour("--warn"), [2, 4]);
    page.word(asked.t, "asked", colour("--warn"));
  } else {
    page.word(add(tool.t, times(column(tool.r, 2), TOOL_M)), "tool", text, 6, -4);
  }
}

function solid(page, corners, end, body) {
  const edge = colour("--text");
  // it gets thinner towards the wrist
  const all = [...corners, { at: end.t, joint: false }];
  all.slice(1).forEach(({ at, joint }, before) => {
    const width = 0.1 - (0.075 * before) / all.length;
    page.rod(all[before].at, at, body, edge, width);
    if (joint) page.ball(at, width * 0.62, body, edge);
  });
  [0, 1, 2].forEach((axis) => page.rod(end.t, add(end.t, times(column(end.r, axis), TOOL_M * 0.6)), body, edge, 0.012));
}

function axes(page, { r, t }, style, dash) {
  [0, 1, 2].forEach((axis) => page.line(t, add(t, times(column(r, axis), TOOL_M)), style, 2, dash));
}

// Where the arm stands above the floor.
function shadow(page, places) {
  const style = colour("--line");
  places.slice(1).forEach((to, before) => {
    const flat = ([x, y]) => [x, y, 0];
    page.line(flat(places[before]), flat(to), style, 6);
  });
}

// The hand in the robot's axes, moved from its stand as it was moved from its first place.
function drawHand(page, hand, robotFromHand) {
  const r = product(robotFromHand, hand.rotation);
  const origin = add(STAND, turn(robotFromHand, times(hand.position_mm, 1e-3)));
  const heard = isHeard(hand.age_us);
  // hollow, as the arm: that it is still there is not known
  const hollow = colour("--panel");
  const [rod, edge] = [heard ? colour("--soft") : hollow, colour("--text")];
  const ends = [origin, ...[0, 1, 2].map((axis) => add(origin, times(column(r, axis), HAND_ARM_M)))];
  page.line([...STAND.slice(0, 2), 0], [...origin.slice(0, 2), 0], colour("--line"), 4);
  page.line([...origin.slice(0, 2), 0], origin, colour("--line"), 1, [2, 4]);
  ends.forEach((end, at) => {
    if (at) page.rod(origin, end, rod, edge, 0.012);
    const [style, ink] = heard ? [colour(COLOURS[at]), colour("--on-ball")] : [hollow, edge];
    page.ball(end, BALL_M, style, edge, LETTERS[at], ink);
  });
  if (heard && hand.covariance_mm2) ellipsoid(page, origin, robotFromHand, hand.covariance_mm2);
  const known = hand.state === "both" || hand.state === "three" || hand.state === "one";
  page.word(origin, !heard ? "hand: not heard now" : known ? "hand" : `hand (${hand.state})`, colour("--text"), 12, 24);
}

// One standard deviation about the hand's place, enlarged: three circles of the ellipsoid.
function ellipsoid(page, origin, robotFromHand, covariance) {
  const l = triangle(covariance);
  if (!l) return;
  const style = colour("--warn");
  const STEPS = 36;
  for (const [first, second] of [[0, 1], [1, 2], [2, 0]]) {
    let before = null;
    for (let step = 0; step <= STEPS; step += 1) {
      const angle = (2 * Math.PI * step) / STEPS;
      const unit = [0, 0, 0];
      unit[first] = Math.cos(angle);
      unit[second] = Math.sin(angle);
      const off = times(turn(l, unit), ENLARGED * 1e-3);
      const place = add(origin, turn(robotFromHand, off));
      if (before) page.line(before, place, style, 1);
      before = place;
    }
  }
}
