// Draws a figure's plots when it comes near the window; the SVG picture stands there until then.
(() => {
  if (!window.Plotly) return;
  const options = { responsive: true, displaylogo: false, scrollZoom: false, modeBarButtonsToRemove: ["lasso2d", "select2d"] };
  const draw = figure => {
    figure.classList.add("live");
    for (const plot of figure.querySelectorAll(".plot")) {
      const { data, layout } = JSON.parse(plot.querySelector("script").textContent);
      Plotly.newPlot(plot.appendChild(document.createElement("div")), data, { ...layout, autosize: true, modebar: { bgcolor: "rgba(0,0,0,0)", color: "#8a8f98", activecolor: "#3b7dd8" }, height: plot.clientHeight, dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom" }, options);
    }
  };
  const near = new IntersectionObserver(entries => {
    for (const { isIntersecting, target } of entries) {
      if (isIntersecting) { near.unobserve(target); draw(target); }
    }
  }, { rootMargin: "600px" });
  document.querySelectorAll("figure").forEach(figure => near.observe(figure));
})();
