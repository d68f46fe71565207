// Images as numbers, as harness/report/page_image.hpp packs them.
import {pageBytes} from "./data.js";
import {run} from "./run.js";

async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// The inverse of packedPlane: one number per pixel.
export function unpredicted(bytes, width) {
  const n = bytes.length / 2;
  const out = new Uint16Array(n);
  for (let i = 0; i < n; ++i) {
    const folded = bytes[i] | (bytes[n + i] << 8);
    const residual = folded & 1 ? -((folded + 1) >> 1) : folded >> 1;
    const first = i % width === 0, top = i < width;
    const left = first ? 0 : out[i - 1], above = top ? 0 : out[i - width];
    const corner = first || top ? 0 : out[i - width - 1];
    const low = left < above ? left : above, high = left < above ? above : left;
    out[i] = residual + (corner >= high ? low : corner <= low ? high : left + above - corner);
  }
  return out;
}

// The most recently used planes; one of 512 x 512 takes half a MiB.
const kMostPlanes = 96;
const planes = new Map();

function plane(id, width) {
  const known = planes.get(id);
  planes.delete(id);
  const one = known ?? pageBytes(id).then(inflated).then((bytes) => unpredicted(bytes, width));
  planes.set(id, one);
  if (planes.size > kMostPlanes) planes.delete(planes.keys().next().value);
  return one;
}

// The size of a frame's images in the page; null if it has none.
export function frameSize(scene, frame) {
  const size = scene.sizes.get(frame);
  return size ? {width: Math.ceil(size.width / run.stride), height: Math.ceil(size.height / run.stride)} : null;
}

function visibilityOf(numbers) {
  const v = new Float32Array(numbers.length);
  for (let i = 0; i < v.length; ++i)
    v[i] = numbers[i] === 0 ? NaN : (numbers[i] - run.planes.zero) * run.planes.visibility;
  return v;
}

// The frame's reference V, its standard error, pixel classes and colours without shadows.
export async function truthOf(scene, frame) {
  const size = frameSize(scene, frame);
  const id = (name) => `${name}-${scene.index}-${frame}`;
  const [reference, error, classes, red, green, blue] = await Promise.all(
    ["reference", "standard-error", "class", "red", "green", "blue"].map((name) => plane(id(name), size.width)));
  return {...size, reference: visibilityOf(reference), error, classes, colours: [red, green, blue]};
}

// V of a row, on the same pixels.
export async function visibilityOfRow(row, width) {
  return visibilityOf(await plane(`visibility-${row.id}`, width));
}

export const hasImage = (row, scene) => scene.sizes.get(row.frame)?.rows.includes(row.id) ?? false;
