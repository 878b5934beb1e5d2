// The horizontal scan of a row (figures 1, 2 and 5 of the paper) as a plot that follows the pointer.

import { colour } from "./palette.js";
import { Plot } from "./plot.js";

// Lines tell the curves apart; colours do not.
const DASHES = { R: "solid", G: "dot", B: "dash", V: "solid", D: "dot", M: "dash" };

export class Scan {
  #plot;
  #words;
  #wanted = null;
  #asking = false;

  constructor(element, words) {
    this.#plot = new Plot(element);
    this.#words = words;
  }

  // The newest place counts; one is on its way at a time.
  async ask(name, u, query) {
    this.#wanted = { name, u, query };
    if (this.#asking) return;
    this.#asking = true;
    try {
      while (this.#wanted) {
        const { name, u, query } = this.#wanted;
        this.#wanted = null;
        const answer = await fetch(`/api/setup/scan?${query}`);
        const told = await answer.json();
        if (answer.ok) {
          this.#words.textContent = words(name, u, told);
          await this.#plot.draw(() => plot(u, told));
        } else {
          this.#words.textContent = told.why;
        }
      }
    } catch (error) {
      this.#words.textContent = `no scan: ${error.message}`;
    } finally {
      this.#asking = false;
    }
  }
}

function plot(u, told) {
  const text = colour("--text");
  const curve = (name, y, hue, yaxis) => ({
    name, x: told.x, y, yaxis, mode: "lines", line: { color: hue, width: 1.5, dash: DASHES[name] },
  });
  const [red, green, blue, orange] = ["red", "green", "blue", "orange"].map((hue) => colour(`--plot-${hue}`));
  const ends = [0, told.width - 1];
  const traces = [
    curve("R", told.r, red, "y2"),
    curve("G", told.g, green, "y2"),
    curve("B", told.b, blue, "y2"),
    curve("V", told.v, green, "y"),
    curve("D", told.d, orange, "y"),
    curve("M", told.m, blue, "y"),
    { name: "threshold", x: ends, y: ends.map(() => told.threshold), mode: "lines", line: { color: text, width: 1, dash: "longdash" } },
  ];
  const upright = (x, dash) => ({
    type: "line", x0: x, x1: x, yref: "paper", y0: 0, y1: 1, line: { color: text, width: 1, dash },
  });
  const shapes = [upright(u, "dot")];
  // pixels reach half a column beyond their centres
  if (told.borders) shapes.push(upright(told.borders[0] - 0.5, "solid"), upright(told.borders[1] + 0.5, "solid"));
  const layout = {
    margin: { l: 36, r: 8, t: 4, b: 34 },
    font: { size: 12 },
    showlegend: true,
    legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0 },
    shapes,
    xaxis: { range: ends, title: { text: "column", standoff: 4 } },
    yaxis: { domain: [0, 0.53], range: [-0.5, 1] },
    yaxis2: { domain: [0.6, 1], range: [0, 1] },
  };
  return { traces, layout };
}

function words(name, u, told) {
  // of wide pictures some columns are left out
  const at = told.x.reduce((best, x, index) => (Math.abs(x - u) < Math.abs(told.x[best] - u) ? index : best), 0);
  const over = told.m[at] >= told.threshold ? "above" : "below";
  const matched = told.borders
    ? `the ${told.ball} ball's colour is from column ${told.borders[0]} to ${told.borders[1]}`
    : `nothing near has the ${told.ball} ball's colour`;
  const m = `M = ${told.m[at].toFixed(2)}, ${over} the threshold of ${told.threshold.toFixed(2)}`;
  return `${name}, row ${told.row}: ${matched}; at the pointer ${m}.`;
}
