// A colour and a shape for each method, the same on every chart and in curve/*.svg.
import {run, settings} from "./run.js";
import {isDark} from "./theme.js";

// Okabe and Ito 2008 without yellow, and three of Paul Tol's "muted" scheme (harness/study/plot.cpp).
const light = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#404040", "#882255",
               "#999933", "#332288"];
// The dark ones of these lightened, for dark paper.
const dark = ["#4aa3df", "#f0803c", "#2fc79a", "#e09cc4", "#f0b53c", "#8ccdf5", "#c9c9c9", "#d86a99",
              "#c2c25a", "#9b8cf0"];
const shapes = ["circle", "rect", "rectRot", "triangle"];

const order = (() => {
  const ids = run.methods.map(({id}) => id);
  const others = [...new Set(settings.map(({method}) => method))].filter((id) => !ids.includes(id));
  return new Map([...ids, ...others.sort()].map((id, index) => [id, index]));
})();

export function colourOf(method) {
  const inks = isDark() ? dark : light;
  return inks[order.get(method) % inks.length];
}

export function shapeOf(method) {
  return shapes[Math.floor(order.get(method) / light.length) % shapes.length];
}
