// The chart of error against time: one line per method through its settings, the front broad.
import {errorName} from "./cost.js";
import {el} from "./dom.js";
import {milliseconds, number} from "./format.js";
import {colourOf, shapeOf} from "./palette.js";
import {settingOf, telling} from "./run.js";
import {cssColour} from "./theme.js";

// Through those of a method's points that no other of its points beats.
function ownFront(points) {
  const line = [];
  for (const p of points) if (line.length === 0 || p.error < line.at(-1).error) line.push(p);
  return line;
}

const at = (p) => ({x: p.ms, y: p.error, point: p});

function datasets(study) {
  const byMethod = new Map();
  for (const p of study.points) byMethod.set(p.method, [...(byMethod.get(p.method) ?? []), p]);
  const front = study.points.filter((p) => p.onFront && p.covers);
  const sets = [...byMethod].sort().map(([method, points]) => {
    const colour = colourOf(method);
    return {
      label: method, data: points.map(at), showLine: false, pointStyle: shapeOf(method),
      borderColor: colour, backgroundColor: points.map((p) => (p.onFront ? colour : cssColour("--card"))),
      pointRadius: points.map((p) => (p.onFront ? 6 : 4.5)), pointHoverRadius: 9, borderWidth: 2, order: 1,
      intervals: true,
    };
  });
  for (const set of [...sets]) {
    sets.push({label: set.label, data: ownFront(set.data.map(({point}) => point)).map(at), showLine: true,
               pointRadius: 0, pointHitRadius: 0, borderColor: set.borderColor, borderWidth: 1.5, order: 2, line: true});
  }
  sets.push({label: "front", data: front.map(at), showLine: true, pointRadius: 0, pointHitRadius: 0,
             borderColor: cssColour("--line"), borderWidth: 12, borderCapStyle: "round", borderJoinStyle: "round",
             order: 4, line: true});
  if (study.floor && study.points.length > 0) {
    const ms = study.points.map((p) => p.ms);
    sets.push({label: "the reference's own error", showLine: true, pointRadius: 0, pointHitRadius: 0,
               data: [{x: Math.min(...ms), y: study.floor}, {x: Math.max(...ms), y: study.floor}],
               borderColor: cssColour("--soft"), borderDash: [4, 4], borderWidth: 1.5, order: 5, line: true});
  }
  return sets;
}

// 95 % intervals of the times, as horizontal bars behind the points.
const intervalBars = {
  id: "intervals",
  beforeDatasetsDraw(chart) {
    const {ctx, scales: {x, y}} = chart;
    ctx.save();
    ctx.beginPath();
    ctx.rect(chart.chartArea.left, chart.chartArea.top, chart.chartArea.width, chart.chartArea.height);
    ctx.clip();
    chart.data.datasets.forEach((set, i) => {
      if (!set.intervals || !chart.isDatasetVisible(i)) return;
      ctx.strokeStyle = set.borderColor;
      ctx.globalAlpha = 0.35;
      ctx.lineWidth = 1.5;
      for (const {point} of set.data) {
        const height = y.getPixelForValue(point.error);
        ctx.beginPath();
        ctx.moveTo(x.getPixelForValue(point.low), height);
        ctx.lineTo(x.getPixelForValue(point.high), height);
        ctx.stroke();
      }
    });
    ctx.restore();
  },
};

// Around all values; Chart.js itself would go to the next powers of ten.
function bounds(values, logarithmic) {
  if (values.length === 0) return {};
  const low = Math.min(...values), high = Math.max(...values);
  if (logarithmic) return {min: low / 1.25, max: high * 1.25};
  return {min: 0, max: high * 1.05};
}

function axis(title, values, logarithmic, narrow) {
  const faint = cssColour("--line"), soft = cssColour("--soft");
  return {
    type: logarithmic ? "logarithmic" : "linear",
    ...bounds(values.filter((value) => value > 0), logarithmic),
    title: {display: true, text: title, color: soft},
    grid: {color: faint, borderColor: faint},
    // Of logarithmic ticks 1, 2 and 5 of every decade; the ends of the axis are no round numbers.
    ticks: {color: soft, maxRotation: 0, autoSkip: !logarithmic, callback(value) {
      if (!logarithmic) return number(value);
      const mantissa = Number(value.toExponential().split("e")[0]);
      return (narrow ? [1] : [1, 2, 5]).includes(mantissa) ? String(value) : null;
    }},
  };
}

// Draws `study` into `canvas` anew; `opened(point)` hears of a click on a point.
export function costChart(canvas, study, {metric, x, y, opened}) {
  Chart.getChart(canvas)?.destroy();
  const narrow = canvas.parentElement.clientWidth < 560;
  return new Chart(canvas, {
    type: "scatter",
    plugins: [intervalBars],
    data: {datasets: datasets(study)},
    options: {
      animation: false, responsive: true, maintainAspectRatio: false,
      interaction: {mode: "nearest", intersect: true},
      scales: {x: axis("frame time (ms), mean over frames", study.points.flatMap(({low, high}) => [low, high]),
                       x !== "linear", narrow),
               y: axis(errorName(metric), [...study.points.map(({error}) => error), study.floor ?? 0], y !== "linear", false)},
      onClick: (event, hits) => {
        const point = hits.map(({datasetIndex, index}) =>
          Chart.getChart(canvas).data.datasets[datasetIndex].data[index].point).find(Boolean);
        if (point) opened(point);
      },
      onHover: (event, hits) => { canvas.classList.toggle("pointing", hits.length > 0); },
      plugins: {
        legend: {
          position: narrow ? "bottom" : "right",
          labels: {usePointStyle: true, color: cssColour("--ink"), boxHeight: 7,
                   generateLabels: (chart) => Chart.defaults.plugins.legend.labels.generateLabels(chart)
                     .map((label) => ({...label, fillStyle: label.strokeStyle})),
                   filter: ({datasetIndex}, {datasets: sets}) => !sets[datasetIndex].line ||
                     !sets[datasetIndex].data[0]?.point},
          // A method's points and its line go together.
          onClick: (event, {datasetIndex}, {chart}) => {
            const {label} = chart.data.datasets[datasetIndex];
            const visible = !chart.isDatasetVisible(datasetIndex);
            chart.data.datasets.forEach((set, i) => { if (set.label === label) chart.setDatasetVisibility(i, visible); });
            chart.update();
          },
        },
        tooltip: {
          displayColors: false,
          callbacks: {
            title: ([{raw}]) => raw.point?.setting ?? "the reference's own error",
            label: ({raw: {point, y: error}}) => (!point ? number(error) : [
              `${errorName(metric)} ${number(point.error)}`,
              `${milliseconds(point.ms)} [${number(point.low)}, ${number(point.high)}]`,
              ...wrapped(telling(settingOf.get(point.setting))),
              point.onFront ? "on the front" : "not on the front",
              ...(point.covers ? [] : [`in ${point.frames} of ${study.frames} frames only`])]),
          },
        },
      },
    },
  });
}

function wrapped(text) {
  const lines = [];
  for (const word of text.split(" ").filter(Boolean)) {
    if (lines.length > 0 && lines.at(-1).length + word.length < 44) lines.push(`${lines.pop()} ${word}`);
    else lines.push(word);
  }
  return lines;
}

// The canvas in its frame, for pages.
export function chartCanvas(label) {
  const canvas = el("canvas", {role: "img", "aria-label": label});
  return {canvas, box: el("div", {class: "chart"}, canvas)};
}
