// Pictures of visibility: shaded, grey, its signed error, the reference's classes.
import {run} from "./run.js";

export const classNames = ["background", ...run.class_colours.map(({name}) => name), "facing away"];
const [kBackground, kFacingAway] = [0, 5];
const isAsked = (c) => c !== kBackground && c !== kFacingAway;

// sRGB bytes to linear and back, for shading.
const linear = Float32Array.from({length: 256}, (_, i) => {
  const v = i / 255;
  return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
});
const kSteps = 4095;
const encoded = Uint8ClampedArray.from({length: kSteps + 1}, (_, i) => {
  const v = i / kSteps;
  return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
});
// Keeps the umbra from pure black, about as the pictures in grid/ do.
const kAmbient = 0.04;
const kNotFinite = [255, 0, 255];

function shaded(truth, v, i) {
  const own = isAsked(truth.classes[i]) ? Math.min(1, Math.max(0, v)) : 1;
  const light = kAmbient + (1 - kAmbient) * own;
  return truth.colours.map((plane) => encoded[Math.round(kSteps * light * linear[plane[i]])]);
}

// Dim stripes that no value can have: nobody answers for these pixels.
function hatching(x, y) {
  const grey = (x + y) % 16 < 8 ? 89 : 101;
  return [grey, grey, grey];
}

function errorColour(error) {
  if (!Number.isFinite(error)) return kNotFinite;
  const last = run.error_colours.length - 1;
  const t = Math.min(1, Math.max(0, 0.5 * (error / run.error_scale + 1)));
  return run.error_colours[Math.round(t * last)];
}

const painters = {
  shaded: (truth, v, i) => (Number.isFinite(v[i]) ? shaded(truth, v[i], i) : kNotFinite),
  visibility: (truth, v, i) => {
    if (!Number.isFinite(v[i])) return kNotFinite;
    const grey = Math.round(255 * Math.min(1, Math.max(0, v[i])));
    return [grey, grey, grey];
  },
  error: (truth, v, i) => errorColour(v[i] - truth.reference[i]),
  classes: (truth, v, i) => run.class_colours[truth.classes[i] - 1].colour,
};

// `mode` is a painter; of `mask`, the index of a class, all other pixels are dimmed (null: none).
export function painted(truth, v, mode, mask = null) {
  const {width, height, classes} = truth;
  const image = new ImageData(width, height);
  const paint = painters[mode];
  for (let i = 0; i < classes.length; ++i) {
    const drawn = mode === "shaded" ? classes[i] !== kBackground : isAsked(classes[i]);
    const colour = drawn ? paint(truth, v, i) : hatching(i % width, Math.floor(i / width));
    const strength = mask === null || classes[i] === mask ? 1 : 0.18;
    for (let c = 0; c < 3; ++c) image.data[4 * i + c] = colour[c] * strength;
    image.data[4 * i + 3] = 255;
  }
  return image;
}

// `image` as something that can be drawn scaled.
export function canvasOf(image) {
  const canvas = document.createElement("canvas");
  canvas.width = image.width;
  canvas.height = image.height;
  canvas.getContext("2d").putImageData(image, 0, 0);
  return canvas;
}
