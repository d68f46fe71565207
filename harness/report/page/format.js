// Numbers as people read them. Empty text for what is not there.

// Three significant digits, whole numbers in full, an exponent only below 0.0001.
export function number(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "";
  if (Number.isInteger(value)) return String(value);
  const size = Math.abs(value);
  if (size >= 100) return value.toFixed(0);
  return size < 1e-4 ? value.toExponential(2) : String(Number(value.toPrecision(3)));
}

export function milliseconds(value) {
  return value === null || value === undefined ? "" : `${number(value)} ms`;
}

export function percent(value) {
  return value === null || value === undefined ? "" : `${number(100 * value)} %`;
}

// 12.3 M and the like.
export function count(value) {
  if (value === null || value === undefined) return "";
  for (const [unit, name] of [[1e9, "G"], [1e6, "M"], [1e3, "k"]])
    if (Math.abs(value) >= unit) return `${number(value / unit)} ${name}`;
  return number(value);
}

export const plural = (n, one, many) => `${n} ${n === 1 ? one : many}`;
