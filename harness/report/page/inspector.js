// What the numbers are at one pixel, and around it.
import {el, fill} from "./dom.js";
import {classNames} from "./paint.js";
import {run} from "./run.js";

const digits = (value) => (Number.isFinite(value) ? value.toFixed(3) : "not finite");
const signed = (value) => (Number.isFinite(value) ? `${value >= 0 ? "+" : "−"}${Math.abs(value).toFixed(3)}` : "");

// `sides` are {name, v, row} of the images compared, `v` null for the reference itself.
export function inspector(truth, sides) {
  const box = el("dl", {class: "inspector", "aria-live": "polite"});
  const item = (name, value, title) => el("div", {}, el("dt", {}, name), el("dd", {title}, value));
  const show = (pixel) => {
    if (!pixel) return fill(box, el("div", {class: "soft"}, "Point at the image for its numbers; a click keeps a pixel."));
    const i = pixel.y * truth.width + pixel.x;
    const kind = classNames[truth.classes[i]];
    const asked = kind !== "background" && kind !== "facing away";
    const error = truth.error[i] * run.planes.standard_error;
    return fill(box,
      item("pixel", `${pixel.x * run.stride}, ${pixel.y * run.stride}`),
      item("class", kind),
      asked ? item("reference V", `${digits(truth.reference[i])} ± ${error.toFixed(5)}`,
                   "± the standard error; where all rays agree the bound 3/n") : null,
      asked ? sides.filter(({v}) => v).map(({name, v}) => item(`${name}`, [
        el("span", {}, `V ${digits(v[i])}`), " ",
        el("span", {class: "error-value"}, `error ${signed(v[i] - truth.reference[i])}`)])) : null);
  };
  show(null);
  return {box, show};
}
