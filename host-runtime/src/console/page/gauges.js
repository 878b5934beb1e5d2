// How well the hand is known, as bars: a standard deviation about each axis.

import { write } from "./page.js";

// Bars are as long as the logarithm: what is known well and what is not are both to be seen.
const share = (value, [from, to]) => Math.min(1, Math.max(0, Math.log(value / from) / Math.log(to / from)));

// From a bar's one end to the other.
const PLACE_MM = [0.01, 10];
const TURN_DEG = [0.01, 10];

export class Gauges {
  #list;
  #bars = [];

  constructor(list) {
    this.#list = list;
    for (const [axis, unit, range] of [
      ...["x", "y", "z"].map((axis) => [axis, "mm", PLACE_MM]),
      ...["x", "y", "z"].map((axis) => [`about ${axis}`, "deg", TURN_DEG]),
    ]) {
      const item = document.createElement("li");
      const bar = document.createElement("span");
      const fill = document.createElement("span");
      const value = document.createElement("span");
      bar.className = "gauge";
      bar.setAttribute("aria-hidden", "true");
      bar.append(fill);
      item.append(`${axis} `, bar, value);
      this.#list.append(item);
      this.#bars.push({ fill, value, unit, range });
    }
  }

  // Millimetres along and degrees about each axis; null where they are not known.
  show(sigmaMm, sigmaDeg) {
    const values = [...(sigmaMm ?? [null, null, null]), ...(sigmaDeg ?? [null, null, null])];
    this.#bars.forEach(({ fill, value, unit, range }, at) => {
      const sigma = values[at];
      write(value, sigma === null ? "not known" : `${sigma.toFixed(sigma < 1 ? 2 : 1)} ${unit}`);
      fill.style.width = sigma === null ? "0" : `${(share(sigma, range) * 100).toFixed(0)}%`;
    });
  }
}
