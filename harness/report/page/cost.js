// What accuracy costs: points of error against time and their front, for any choice of scenes. The
// rules and their reasons are in harness/study/pareto.hpp; pareto.csv is what this must agree with.
import {isTimed} from "./run.js";

const signed = new Set(["bias", "penumbra_width_error", "penumbra_shift"]);

export function errorName(metric) {
  return metric === "ssim" ? "1 − ssim" : signed.has(metric) ? `|${metric}|` : metric;
}

function errorOf(row, metric) {
  const value = row[metric];
  if (value === null || value === undefined) return null;
  return metric === "ssim" ? 1 - value : signed.has(metric) ? Math.abs(value) : value;
}

const placeOf = (row) => JSON.stringify([row.scene, row.frame, row.renderer]);

function subjectsOf(rows, metric) {
  const subjects = new Map();
  for (const row of rows) {
    const error = errorOf(row, metric);
    if (!isTimed(row) || error === null) continue;
    if (!subjects.has(row.setting))
      subjects.set(row.setting, {setting: row.setting, method: row.method, samples: new Map()});
    subjects.get(row.setting).samples.set(placeOf(row), {
      error, ms: row.frame_ms, low: row.frame_ms_low ?? row.frame_ms,
      high: row.frame_ms_high ?? row.frame_ms});
  }
  return [...subjects.values()];
}

function aggregate(samples, at, quadratic) {
  const mean = {error: 0, ms: 0, low: 0, high: 0, frames: at.size};
  for (const place of at.keys()) {
    const s = samples.get(place);
    mean.error += quadratic ? s.error * s.error : s.error;
    mean.ms += s.ms;
    mean.low += s.low;
    mean.high += s.high;
  }
  for (const key of ["error", "ms", "low", "high"]) mean[key] /= at.size;
  if (quadratic) mean.error = Math.sqrt(mean.error);
  return mean;
}

// The 95 % interval of the difference of the mean times does not reach 0 (Zou & Donner 2008, eq. 3).
function surelyFaster(fast, slow, at) {
  let difference = 0, square = 0;
  for (const place of at.keys()) {
    const f = fast.get(place), s = slow.get(place);
    difference += s.ms - f.ms;
    square += (s.ms - s.low) ** 2 + (f.high - f.ms) ** 2;
  }
  return difference > Math.sqrt(square);
}

function keepsOffTheFront(other, own, quadratic) {
  const error = aggregate(own, own, quadratic).error;
  const otherError = aggregate(other, own, quadratic).error;
  if (otherError === error) return surelyFaster(other, own, own);
  return otherError < error && !surelyFaster(own, other, own);
}

const hasAllOf = (samples, at) => [...at.keys()].every((place) => samples.has(place));

// The error that the reference's own noise gives a perfect image; null where that is not known.
function floorOf(rows, metric, quadratic) {
  const floors = new Map();  // of every frame the row with the least rmse: its rounding is least
  for (const row of rows) {
    let floor = null;
    if (metric === "rmse_penumbra") floor = row.reference_se;
    else if (metric === "rmse" && row.rmse && row.rmse_corrected)
      floor = Math.sqrt(Math.max(0, row.rmse ** 2 - row.rmse_corrected ** 2));
    const best = floors.get(placeOf(row));
    if (floor !== null && (!best || row.rmse < best.rmse)) floors.set(placeOf(row), {rmse: row.rmse, floor});
  }
  if (floors.size === 0) return null;
  let sum = 0;
  for (const {floor} of floors.values()) sum += quadratic ? floor * floor : floor;
  sum /= floors.size;
  return quadratic ? Math.sqrt(sum) : sum;
}

// Every setting over `rows`: error, mean time with its interval, frames, covers (all frames), front.
// Over several scenes errors are root mean squares over frames, within one means.
export function costStudy(rows, metric) {
  const quadratic = new Set(rows.map((row) => row.scene)).size > 1;
  const subjects = subjectsOf(rows, metric);
  const places = new Set(subjects.flatMap(({samples}) => [...samples.keys()]));
  const points = subjects.map(({setting, method, samples}) => ({
    setting, method, ...aggregate(samples, samples, quadratic),
    covers: samples.size === places.size,
    onFront: !subjects.some((other) => other.setting !== setting &&
      hasAllOf(other.samples, samples) && keepsOffTheFront(other.samples, samples, quadratic)),
  }));
  points.sort((a, b) => a.ms - b.ms);
  return {points, frames: places.size, floor: floorOf(rows, metric, quadratic)};
}
