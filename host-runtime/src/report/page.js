// Draws a figure's plots when it comes near the window; the SVG picture stands there until then.
(() => {
  if (!window.Plotly) return;
  const options = { responsive: true, displaylogo: false, scrollZoom: false, modeBarButtonsToRemove: ["lasso2d", "select2d"] };
  // letters and lines in the page's colours, which it has for the light and for the dark
  const inked = (layout) => {
    const style = getComputedStyle(document.documentElement);
    const [ink, soft, line] = ["--ink", "--soft", "--line"].map((name) => style.getPropertyValue(name).trim());
    const axis = { gridcolor: line, zerolinecolor: soft, linecolor: soft };
    return {
      ...layout,
      font: { ...layout.font, color: ink },
      xaxis: { ...layout.xaxis, ...axis },
      yaxis: { ...layout.yaxis, ...axis },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: soft, activecolor: ink },
    };
  };
  const drawn = [];
  const draw = (figure) => {
    figure.classList.add("live");
    for (const plot of figure.querySelectorAll(".plot")) {
      const { data, layout } = JSON.parse(plot.querySelector("script").textContent);
      const place = plot.appendChild(document.createElement("div"));
      const dragmode = matchMedia("(pointer: coarse)").matches ? false : "zoom";
      const all = { ...layout, autosize: true, height: plot.clientHeight, dragmode };
      drawn.push({ place, data, layout: all });
      Plotly.newPlot(place, data, inked(all), options);
    }
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const { place, data, layout } of drawn) Plotly.react(place, data, inked(layout), options);
  });
  const near = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) {
      if (isIntersecting) { near.unobserve(target); draw(target); }
    }
  }, { rootMargin: "600px" });
  document.querySelectorAll("figure").forEach((figure) => near.observe(figure));
})();
