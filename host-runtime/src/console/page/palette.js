// The colours of style.css as they are now, dark or light, for what is drawn by scripts.

const scheme = matchMedia("(prefers-color-scheme: dark)");
const known = new Map();
scheme.addEventListener("change", () => known.clear());

export function colour(name) {
  if (!known.has(name)) known.set(name, getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  return known.get(name);
}

// Calls back whenever they have changed.
export function whenRecoloured(draw) {
  scheme.addEventListener("change", draw);
}
