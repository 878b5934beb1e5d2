// Plots: plotly, whose script the program embeds, loaded by the first plot of a page.

import { colour, whenRecoloured } from "./palette.js";

const STYLE = "plotly.js-style-global";

let loading = null;

// Plotly, once its script has come; one that did not come is asked for again by the next plot.
function plotly() {
  loading ??= new Promise((done, failed) => {
    // an element of this name and class tells plotly that its rules are here: the console's policy allows
    // no inline style, which it would make of them
    if (!document.getElementById(STYLE)) {
      const style = document.createElement("link");
      style.id = STYLE;
      style.className = "no-inline-styles";
      style.rel = "stylesheet";
      style.href = "/plot.css";
      document.head.append(style);
    }
    const script = document.createElement("script");
    script.src = "/plotly.js";
    script.onload = () => done(window.Plotly);
    script.onerror = () => {
      loading = null;
      script.remove();
      failed(new Error("the script of the plots did not come"));
    };
    document.head.append(script);
  });
  return loading;
}

// One plot in an element, in the page's colours, as large as the element. It is drawn anew when the scheme changes.
export class Plot {
  #element;
  #newest = null;
  #isDrawn = false;

  constructor(element) {
    this.#element = element;
    whenRecoloured(() => this.#again());
    new ResizeObserver(() => this.#fit()).observe(element);
  }

  // `make` is asked for { traces, layout } as plotly takes them; it may ask for colours (palette.js). No text may have
  // tags: plotly makes inline styles of them, which the policy forbids.
  async draw(make) {
    this.#newest = make;
    const Plotly = await plotly();
    // what came while the script was loading is newer
    if (this.#newest !== make) return;
    const { traces, layout } = make();
    await Plotly.react(this.#element, traces, themed(layout), { displayModeBar: false });
    this.#isDrawn = true;
    // its place may have changed meanwhile
    this.#fit();
  }

  #fit() {
    const { clientWidth, clientHeight, _fullLayout: drawn } = this.#element;
    if (!this.#isDrawn || !clientWidth || (drawn.width === clientWidth && drawn.height === clientHeight)) return;
    window.Plotly.Plots.resize(this.#element);
  }

  #again() {
    if (this.#newest) this.draw(this.#newest);
  }
}

function themed(layout) {
  const clear = "rgba(0,0,0,0)";
  const lines = { gridcolor: colour("--line"), linecolor: colour("--line"), zerolinecolor: colour("--soft"), automargin: true };
  const axes = Object.keys(layout).filter((name) => /^[xy]axis/.test(name));
  return {
    paper_bgcolor: clear,
    plot_bgcolor: clear,
    margin: { l: 50, r: 10, t: 10, b: 40 },
    ...layout,
    font: { color: colour("--text"), size: 13, family: "system-ui, sans-serif", ...layout.font },
    ...Object.fromEntries(["xaxis", "yaxis", ...axes].map((name) => [name, { ...lines, ...layout[name] }])),
  };
}
