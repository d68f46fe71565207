// Pages of tables: all rows, the reference's truth, stability, claims, pairs, provenance.
import {alerts} from "./alerts.js";
import {copyButton, el, fill} from "./dom.js";
import {count, number, percent} from "./format.js";
import {rows, run} from "./run.js";
import {linkTo, remembered} from "./state.js";
import {dataTable} from "./table.js";

export function rowsPage(page, view) {
  const columns = run.columns.map(({name, values}) => ({name, number: Boolean(values),
    value: (row) => row[name],
    show: values ? (row) => number(row[name])
      : (row) => el("span", {class: "clamped", title: row[name]}, row[name].replaceAll(";", "; ")),
    doc: run.metrics.find(({id}) => id === name)?.doc}));
  fill(page, el("h1", {}, "Every row"), el("p", {class: "soft"}, "results.csv as it is; the download has full precision."),
    dataTable(columns, rows, {name: "results", most: 100, ...remembered(view)}));
}

export function truthPage(page, view) {
  const of = (name, title, value, show = number) => ({name, title, number: true, value, show: (r) => show(value(r))});
  fill(page, el("h1", {}, "Is the reference right?"),
    el("p", {}, `Asked for: a standard error of ${number(run.reference_se)} at every pixel, by ${run.reference}. A sample of the `,
      "penumbra pixels of each frame is held against exact visibility. Coverage is the share of pixels whose 95 % interval ",
      `holds it: ${percent(run.least_coverage)} to ${percent(run.most_coverage)} over a run is right.`),
    dataTable([
      {name: "scene", value: (r) => r.scene, show: (r) => el("a", {href: linkTo({page: "scene", scene: r.scene})}, r.scene)},
      of("frame", "frame", (r) => r.frame), of("rays", "rays", (r) => r.rays, count),
      {name: "source", value: (r) => (r.cached ? "cached" : "traced")},
      of("penumbra", "penumbra pixels", (r) => (r.scored_pixels ? r.penumbra_pixels / r.scored_pixels : null), percent),
      of("checked", "checked", (r) => r.checked?.pixels), of("coverage", "coverage", (r) => r.checked?.coverage, percent),
      of("rmse", "rmse", (r) => r.checked?.rmse), of("worst", "worst", (r) => r.checked?.worst),
    ], run.references, {name: "references", ...remembered(view)}));
}

// A table of the run folder as it is: header and lines of texts; columns called `first` come first.
function plainTable(name, view, {first, sort, rowClass}) {
  const [header, ...lines] = run.tables[name];
  const isNumber = header.map((_, c) => lines.length > 0 && lines.every((line) => line[c] === "" || Number.isFinite(Number(line[c]))));
  const order = [...header.keys()].sort((a, b) => (first.includes(header[b]) - first.includes(header[a])) ||
    (first.includes(header[a]) ? first.indexOf(header[a]) - first.indexOf(header[b]) : a - b));
  return dataTable(order.map((c) => [header[c], c]).map(([title, c]) => ({name: title, title: title.replaceAll("_", " "), number: isNumber[c],
    value: (line) => (isNumber[c] && line[c] !== "" ? Number(line[c]) : line[c]),
    show: isNumber[c] ? (line) => (line[c] === "" ? "" : number(Number(line[c]))) : null})),
    lines, {name, ...remembered(view, sort), rowClass});
}

const columnOf = (name, title) => {
  const index = run.tables[name][0].indexOf(title);
  return (line) => line[index];
};

function tally(name, title) {
  const counts = new Map();
  for (const line of run.tables[name].slice(1)) counts.set(columnOf(name, title)(line), (counts.get(columnOf(name, title)(line)) ?? 0) + 1);
  return [...counts].map(([what, n]) => `${what}: ${n}`).join(" · ");
}

const tables = {
  stability: {name: "stress", title: "Stability", tally: "status", first: ["case", "method", "status", "deviation", "bound"],
    about: "Numerical hard cases: what must hold, and by how much it does not."},
  claims: {name: "claims", title: "Claims of the papers", tally: "verdict",
    first: ["paper", "claim", "verdict", "metric", "paper_ratio", "relation", "ratio", "ratio_low", "ratio_high", "message"],
    about: "Each claim as a ratio a / b measured in one run: relation is what has to hold of it, paper ratio what the paper reports."},
  pairs: {name: "paired", title: "Pairs", tally: null, first: [],
    about: "Frames timed in pairs, each as one line; a speed-up above 1 is in favour of A. summary.md has the verdict."},
};

export const tablePages = Object.entries(tables).filter(([, {name}]) => run.tables[name]).map(([id, section]) => ({
  id, title: section.title,
  draw: (page, view) => {
    const status = section.tally ? columnOf(section.name, section.tally) : () => "";
    const wrong = (line) => (/^(fail|mended|does not hold|could)/i.test(status(line) ?? "") ? "wrong" : "");
    fill(page, el("h1", {}, section.title), el("p", {}, section.about),
      section.tally ? el("p", {class: "soft"}, tally(section.name, section.tally)) : null,
      plainTable(section.name, view, {first: section.first, sort: section.tally, rowClass: wrong}));
  },
}));

export function provenancePage(page) {
  const item = (name, value) => el("div", {}, el("dt", {}, name), el("dd", {}, value));
  const {clock} = run;
  fill(page, el("h1", {}, "Provenance"),
    el("div", {class: "card"}, el("div", {class: "row spread"}, el("strong", {}, "Command"), copyButton(() => run.command)),
      el("pre", {}, run.command)),
    el("dl", {class: "facts card"},
      run.provenance.map(([name, value]) => item(name.replaceAll("_", " "), value)),
      item("size", `${run.width} × ${run.height}`), item("repeats", String(run.repeats)), item("seed", String(run.seed)),
      item("effects", run.effects.join(", ")), item("reference", `${run.reference}, standard error ${number(run.reference_se)}`),
      item("finished", run.finished ? "yes" : "no"),
      item("clock", `fenced ${number(clock.fenced_ms)} ms; timer queries say ${number(clock.timer_query_ms)} ms and are ` +
        (clock.timer_queries_trusted ? "trusted" : "not trusted"))),
    el("h2", {}, "Warnings"),
    alerts.length === 0 ? el("p", {}, "None.") : el("ul", {}, alerts.map(({title}) => el("li", {}, title))),
    el("p", {class: "soft"}, "Times of different renderers or machines are not comparable."));
}
