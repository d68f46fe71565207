// Small pictures, drawn when they are about to be seen.
import {el} from "./dom.js";
import {canvasOf, painted} from "./paint.js";
import {frameSize, truthOf, visibilityOfRow} from "./planes.js";

const kWidth = 200;

const watcher = new IntersectionObserver((entries) => {
  for (const {isIntersecting, target} of entries) {
    if (!isIntersecting) continue;
    watcher.unobserve(target);
    target.drawNow();
  }
}, {rootMargin: "300px"});

async function draw(canvas, scene, frame, row, mode) {
  try {
    const truth = await truthOf(scene, frame);
    const v = row ? await visibilityOfRow(row, truth.width) : truth.reference;
    const picture = canvasOf(painted(truth, v, mode));
    const context = canvas.getContext("2d");
    context.imageSmoothingQuality = "high";
    context.drawImage(picture, 0, 0, canvas.width, canvas.height);
    canvas.classList.add("drawn");
  } catch (error) {
    canvas.replaceWith(el("div", {class: "thumb none"}, error.message));
  }
}

// The picture of a row, or of the reference (`row` null).
export function lazyThumb(scene, frame, row, mode) {
  const {width, height} = frameSize(scene, frame);
  const scale = Math.min(1, (2 * kWidth) / width);
  const canvas = el("canvas", {class: "thumb", width: Math.round(width * scale), height: Math.round(height * scale),
    role: "img", "aria-label": `${row ? row.setting : "reference"}, ${scene.id}, frame ${frame}: ${mode}`});
  canvas.drawNow = () => draw(canvas, scene, frame, row, mode);
  watcher.observe(canvas);
  return canvas;
}
