// The history page: what was approved, where a metric makes a step, and one metric over time.
import {pageData} from "./data.js";
import {byId, dropDown, el, fill} from "./dom.js";
import {cssColour, onThemeChange, themeButton} from "./theme.js";

const approvals = pageData("approval-data");
const all = pageData("series-data");
const mostStepsShown = 300;
// Metrics that are best where they are greatest; bias and the like are best at 0.
const higherIsBetter = ["ssim"];
const zeroIsBest = ["bias", "penumbra_width_error", "penumbra_shift"];

const number = (value) => (value === null || value === undefined ? "none" : String(Number(value.toPrecision(4))));
const rowOf = (series) => `${series.scene} frame ${series.frame} ${series.setting}`;
const titleOf = (approval) => `${approval.commit} (${approval.when.slice(0, 10)})`;
const unique = (list) => [...new Set(list)];

// ---- what is chosen, in the URL so that a view can be linked ----

const shown = all.filter((series) => !/^frame_ms_(low|high)$/.test(series.metric));
const rows = unique(shown.map(rowOf));
const state = {row: rows[0] ?? "", metric: "rmse"};

function readUrl() {
  const link = new URLSearchParams(location.hash.slice(1));
  if (rows.includes(link.get("row"))) state.row = link.get("row");
  if (link.get("metric")) state.metric = link.get("metric");
  const has = metricsOf(state.row);
  if (!has.includes(state.metric)) state.metric = has[0] ?? "";
}

function choose(changes) {
  Object.assign(state, changes);
  const link = new URLSearchParams(state);
  if (location.hash.slice(1) === String(link)) show();
  else location.hash = String(link);
}

const metricsOf = (row) => shown.filter((series) => rowOf(series) === row).map((series) => series.metric);
const find = (row, metric) => all.find((series) => rowOf(series) === row && series.metric === metric);

// ---- the chart ----

let chart = null;

function draw() {
  const series = find(state.row, state.metric);
  if (!series) return;
  const ink = cssColour("--ink"), line = cssColour("--line");
  const colour = cssColour("--accent"), stepColour = cssColour("--bad");
  const steps = new Map(series.steps.map((step) => [step.at, step]));
  const datasets = [{
    label: state.metric, data: series.values, stepped: true, borderColor: colour, spanGaps: false,
    pointRadius: series.values.map((_, i) => (steps.has(i) ? 7 : 4)),
    pointStyle: series.values.map((_, i) => (steps.has(i) ? "triangle" : "circle")),
    pointBackgroundColor: series.values.map((_, i) => (steps.has(i) ? stepColour : colour)),
  }];
  if (state.metric === "frame_ms") {
    for (const [metric, label] of [["frame_ms_low", "95 % from"], ["frame_ms_high", "95 % to"]]) {
      const bound = find(state.row, metric);
      if (bound)
        datasets.push({label, data: bound.values, stepped: true, borderColor: colour, borderDash: [3, 4],
                       borderWidth: 1, pointRadius: 0});
    }
  }
  const axis = (title) => ({title: {display: true, text: title, color: ink}, ticks: {color: ink},
                            grid: {color: line}});
  chart?.destroy();
  chart = new Chart(byId("plot"), {
    type: "line",
    data: {labels: approvals.map(titleOf), datasets},
    options: {
      animation: false, maintainAspectRatio: false, interaction: {mode: "index", intersect: false},
      scales: {x: axis("approved commit"), y: {...axis(state.metric), beginAtZero: true}},
      plugins: {
        legend: {display: false},
        tooltip: {callbacks: {afterBody: ([item]) => approvalLines(item.dataIndex, steps.get(item.dataIndex))}},
      },
    },
  });
}

function approvalLines(index, step) {
  const approval = approvals[index];
  const lines = [`approved by ${approval.who}`, approval.reason];
  if (step) lines.push(`step: ${number(step.before)} to ${number(step.after)}`);
  return lines;
}

// ---- tables ----

function table(columns, lines) {
  return el("div", {class: "scroll"}, el("table", {},
    el("thead", {}, el("tr", {}, columns.map((name) => el("th", {}, name)))),
    el("tbody", {}, lines)));
}

function verdict(metric, step) {
  const badness = (value) =>
    higherIsBetter.includes(metric) ? -value : zeroIsBest.includes(metric) ? Math.abs(value) : value;
  return badness(step.after) > badness(step.before) ? "worse" : "better";
}

function stepTable() {
  const steps = shown.flatMap((series) => series.steps.map((step) => ({series, step})));
  steps.sort((a, b) => b.step.at - a.step.at);
  if (steps.length === 0) return [el("p", {}, "None.")];
  const lines = steps.slice(0, mostStepsShown).map(({series, step}) => el("tr", {},
    el("td", {}, titleOf(approvals[step.at])),
    el("td", {}, el("button", {type: "button",
      onclick: () => choose({row: rowOf(series), metric: series.metric})}, rowOf(series))),
    el("td", {}, series.metric),
    el("td", {class: "number"}, number(step.before)),
    el("td", {class: `number ${verdict(series.metric, step)}`}, number(step.after)),
    el("td", {}, verdict(series.metric, step)),
    el("td", {class: "reason"}, approvals[step.at].reason)));
  const more = steps.length - lines.length;
  return [table(["approval", "row", "metric", "before", "after", "", "reason"], lines),
          more > 0 ? el("p", {class: "soft"}, `and ${more} older ones`) : null];
}

function approvalTable() {
  return table(["when", "who", "commit", "values changed", "reason", "machine"],
    approvals.map((a) => el("tr", {},
      el("td", {}, a.when), el("td", {}, a.who), el("td", {class: "mono"}, a.commit),
      el("td", {class: "number"}, String(a.changes)), el("td", {class: "reason"}, a.reason),
      el("td", {class: "small"}, a.machine))).reverse());
}

// ---- the page ----

function show() {
  readUrl();
  fill(byId("choices"),
    dropDown("row", rows.map((row) => [row, row]), state.row, (row) => choose({row})),
    dropDown("metric", metricsOf(state.row).map((metric) => [metric, metric]), state.metric,
             (metric) => choose({metric})));
  const series = find(state.row, state.metric);
  const present = (series?.values ?? []).filter((value) => value !== null);
  fill(byId("chosen"), present.length === 0 ? "No value." :
    `${number(present[0])} at first, ${number(present.at(-1))} now, steps (triangles): ${series.steps.length}`);
  draw();
}

byId("theme-place").append(themeButton());
onThemeChange(draw);
byId("extent").textContent = `${approvals.length} approvals, ${rows.length} rows`;
fill(byId("steps"), stepTable());
fill(byId("approvals"), approvalTable());
addEventListener("hashchange", show);
show();
