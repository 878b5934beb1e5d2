// How long each stage takes, as bars: figure 9 of the paper, live.

import { colour } from "./palette.js";
import { Plot } from "./plot.js";

export class DelayPlot {
  #plot;
  #shown = "";

  constructor(element) {
    this.#plot = new Plot(element);
  }

  // `delays` as the snapshot has them.
  show(delays) {
    const told = JSON.stringify(delays.map(({ stage, lately }) => [stage, lately]));
    if (told === this.#shown) return;
    this.#shown = told;
    // the first stage is to be the uppermost
    const stages = [...delays].reverse();
    const bars = (name, key, fill, shape) => ({
      type: "bar",
      orientation: "h",
      name,
      // what was not measured lately has no bar
      x: stages.map(({ lately }) => lately?.[key] ?? null),
      y: stages.map(({ stage }) => stage),
      marker: { color: colour(fill), line: { color: colour("--text"), width: 1 }, pattern: { shape, fgcolor: colour("--text"), size: 6, solidity: 0.25 } },
      hovertemplate: `%{y}: %{x:.2f} ms (${name})<extra></extra>`,
    });
    this.#plot.draw(() => ({
      traces: [bars("99 of 100 within", "p99_ms", "--panel", "/"), bars("half within", "p50_ms", "--link", "")],
      layout: {
        barmode: "group",
        bargap: 0.25,
        dragmode: false,
        xaxis: { title: { text: "milliseconds" }, rangemode: "tozero", fixedrange: true },
        yaxis: { fixedrange: true },
        legend: { orientation: "h", traceorder: "reversed", x: 0, y: 1.01, yanchor: "bottom" },
        margin: { l: 10, r: 10, t: 40, b: 40 },
      },
    })).catch(() => {
      // the table below says the same; the next numbers try again
      this.#shown = "";
    });
  }
}
