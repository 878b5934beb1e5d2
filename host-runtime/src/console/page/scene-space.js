// Vectors, rotations (row by row, as the program tells them) and the eye that looks at the scene.

export const add = (a, b) => a.map((value, at) => value + b[at]);
export const sub = (a, b) => a.map((value, at) => value - b[at]);
export const times = (a, by) => a.map((value) => value * by);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

export const IDENTITY = [1, 0, 0, 0, 1, 0, 0, 0, 1];

// A rotation's column: where it takes that axis.
export const column = (r, at) => [r[at], r[at + 3], r[at + 6]];
export const turn = (r, v) => [0, 3, 6].map((row) => r[row] * v[0] + r[row + 1] * v[1] + r[row + 2] * v[2]);
export const transpose = (r) => [r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]];
export const product = (a, b) =>
  [0, 3, 6].flatMap((row) => [0, 1, 2].map((at) => a[row] * b[at] + a[row + 1] * b[at + 3] + a[row + 2] * b[at + 6]));

// A pose: { r, t }, row by row and metres.
export const compose = (a, b) => ({ r: product(a.r, b.r), t: add(a.t, turn(a.r, b.t)) });
export const inverse = (pose) => {
  const r = transpose(pose.r);
  return { r, t: times(turn(r, pose.t), -1) };
};

// Where the joints of a link table are at these angles (radians): the corners of a skeleton from the base to
// the last link, and that link's pose.
export function skeleton(links, joints) {
  let pose = { r: IDENTITY, t: [0, 0, 0] };
  const corners = [{ at: pose.t, joint: true }];
  links.forEach(({ d_m: d, a_m: a, alpha_rad: alpha }, at) => {
    const [s, c] = [Math.sin(joints[at]), Math.cos(joints[at])];
    pose = compose(pose, { r: [c, -s, 0, s, c, 0, 0, 0, 1], t: [0, 0, 0] });
    // a link goes along its axis first, and then across
    for (const step of [[0, 0, d], [a, 0, 0]]) {
      if (Math.hypot(...step) < 1e-4) continue;
      pose = compose(pose, { r: IDENTITY, t: step });
      corners.push({ at: pose.t, joint: false });
    }
    corners.at(-1).joint = true;
    const [sa, ca] = [Math.sin(alpha), Math.cos(alpha)];
    pose = compose(pose, { r: [1, 0, 0, 0, ca, -sa, 0, sa, ca], t: [0, 0, 0] });
  });
  return { corners, pose };
}

// The lower triangle L of a covariance (row by row), L L^T; null where it is none.
export function triangle(k) {
  const l = Array(9).fill(0);
  for (let row = 0; row < 3; row += 1) {
    for (let at = 0; at <= row; at += 1) {
      let rest = k[row * 3 + at];
      for (let i = 0; i < at; i += 1) rest -= l[row * 3 + i] * l[at * 3 + i];
      if (row === at && !(rest > 0)) return null;
      l[row * 3 + at] = row === at ? Math.sqrt(rest) : rest / l[at * 3 + at];
    }
  }
  return l;
}

const START = { yaw: -0.9, pitch: 0.35, distance: 3.9 };
const TARGET = [0.1, -0.15, 0.7];

// A step nearer, of the distance.
const NEARER = 0.9;

// The eye: it goes round a point of the scene, by pointer or keys, and nearer or farther by keys or wheel.
export class Eye {
  #canvas;
  #moved;
  #at = { ...START };

  constructor(canvas, moved) {
    this.#canvas = canvas;
    this.#moved = moved;
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons) this.#go(-event.movementX * 0.008, event.movementY * 0.008, 1);
    });
    canvas.addEventListener(
      "wheel",
      (event) => {
        // a page that is scrolled does not stop here
        if (document.activeElement !== canvas) return;
        event.preventDefault();
        this.#go(0, 0, Math.exp(event.deltaY * 0.001));
      },
      { passive: false },
    );
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  nearer() {
    this.#go(0, 0, NEARER);
  }

  farther() {
    this.#go(0, 0, 1 / NEARER);
  }

  #key(event) {
    const steps = {
      ArrowLeft: [-0.1, 0, 1],
      ArrowRight: [0.1, 0, 1],
      ArrowUp: [0, 0.1, 1],
      ArrowDown: [0, -0.1, 1],
      "+": [0, 0, NEARER],
      "-": [0, 0, 1 / NEARER],
    };
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === "Home") {
      this.#at = { ...START };
      this.#moved();
    } else if (steps[event.key]) {
      this.#go(...steps[event.key]);
    } else {
      return;
    }
    event.preventDefault();
  }

  #go(yaw, pitch, zoom) {
    const at = this.#at;
    at.yaw += yaw;
    at.pitch = Math.min(1.5, Math.max(-0.2, at.pitch + pitch));
    at.distance = Math.min(8, Math.max(1, at.distance * zoom));
    this.#moved();
  }

  // What takes a place of the scene to the screen: { x, y, depth, scale }, pixels per metre there.
  projection(width, height) {
    const { yaw, pitch, distance } = this.#at;
    const [sy, cy, sp, cp] = [Math.sin(yaw), Math.cos(yaw), Math.sin(pitch), Math.cos(pitch)];
    const right = [-sy, cy, 0];
    const out = [cy * cp, sy * cp, sp];
    const up = [-cy * sp, -sy * sp, cp];
    const focal = 1.7 * Math.min(width, height * 1.2);
    return (place) => {
      const from = sub(place, TARGET);
      const depth = Math.max(0.1, distance - dot(from, out));
      const scale = focal / depth;
      return { x: width / 2 + dot(from, right) * scale, y: height / 2 - dot(from, up) * scale, depth, scale };
    };
  }
}
