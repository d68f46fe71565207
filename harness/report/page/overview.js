// The first page: what accuracy costs over the scenes that the reader picks, and the ranking there.
import {chartCanvas, costChart} from "./cost_chart.js";
import {costStudy, errorName} from "./cost.js";
import {choice, dropDown, el, fill} from "./dom.js";
import {number, percent, plural} from "./format.js";
import {colourOf} from "./palette.js";
import {frameSize} from "./planes.js";
import {errorMetrics, isSeparation, rows, run, sceneOf, scenes, settingOf, telling} from "./run.js";
import {go, keep, linkTo, state} from "./state.js";
import {dataTable} from "./table.js";
import {onThemeChange} from "./theme.js";
import {lazyThumb} from "./thumbs.js";

const mean = (values) => {
  const there = values.filter((v) => v !== null && v !== undefined);
  return there.length > 0 ? there.reduce((a, b) => a + b, 0) / there.length : null;
};

// The place where most of a setting can be seen: the picked scene where it is worst.
function openSetting(setting, picked) {
  const own = rows.filter((row) => row.setting === setting && picked.has(row.scene) && row.status === "ok");
  const worst = own.reduce((a, b) => ((b.rmse ?? 0) > (a?.rmse ?? -1) ? b : a), null);
  if (worst) go({page: "compare", scene: worst.scene, frame: worst.frame, b: setting});
}

function ranking(study, picked, metric) {
  const bySetting = new Map();
  for (const row of rows)
    if (picked.has(row.scene) && !isSeparation(row))
      bySetting.set(row.setting, [...(bySetting.get(row.setting) ?? []), row]);
  const pointOf = new Map(study.points.map((p) => [p.setting, p]));
  const fastest = Math.min(...study.points.filter((p) => p.covers).map((p) => p.ms));
  const lines = [...bySetting].map(([name, own]) => {
    const good = own.filter((row) => row.status === "ok");
    const of = (column) => mean(good.map((row) => row[column]));
    return {name, setting: settingOf.get(name), cells: own.length, good: good.length, point: pointOf.get(name),
            bias: of("bias"), leak: of("leak_rate"), falseShadow: of("false_shadow_rate"),
            penumbra: of("rmse_penumbra")};
  });
  const largest = Math.max(...study.points.map((p) => p.error), 1e-12);
  const errorCell = (line) => {
    if (!line.point) return "";
    const bar = el("span", {class: "bar"});
    bar.style.width = `${(100 * line.point.error) / largest}%`;
    return el("span", {class: "barred"}, bar, el("span", {}, number(line.point.error)));
  };
  const name = (line) => {
    const dot = el("span", {class: "dot"});
    dot.style.background = colourOf(line.setting.method);
    return el("span", {class: "named"}, dot, el("button", {type: "button", class: "link", onclick: () => openSetting(line.name, picked)},
      line.name));
  };
  const numeric = (column, title, value, show, doc) => ({name: column, title, number: true, value,
    show: (line) => show(value(line)), doc});
  return dataTable([
    {name: "setting", title: "Setting", value: (line) => line.name, show: name},
    {name: "parameters", title: "Parameters", value: (line) => telling(line.setting),
     show: (line) => el("span", {class: "small soft"}, telling(line.setting))},
    {name: errorName(metric), number: true, value: (line) => line.point?.error, show: errorCell,
     doc: "root mean square over the frames of the picked scenes; of one scene the mean"},
    numeric("frame_ms", "ms", (line) => line.point?.ms, number, "mean frame time"),
    numeric("times_fastest", "× fastest", (line) => (line.point?.covers ? line.point.ms / fastest : null), number,
      "mean frame time over that of the fastest setting"),
    {name: "front", title: "Front", value: (line) => (line.point?.onFront && line.point.covers ? 1 : 0), largeFirst: true,
     show: (line) => (line.point?.onFront && line.point.covers ? "●" : ""),
     doc: "surely faster than everything more accurate"},
    numeric("rmse_penumbra", "penumbra", (line) => line.penumbra, number, "rmse over penumbra pixels, mean over cells"),
    numeric("bias", "bias", (line) => line.bias, number, "above 0 light leaks, below 0 it is too dark"),
    numeric("leak_rate", "leaks", (line) => line.leak, percent, "share of umbra pixels that are lit"),
    numeric("false_shadow_rate", "false shadows", (line) => line.falseShadow, percent, "share of lit pixels that are dark"),
    {name: "good_cells", title: "cells", number: true, value: (line) => line.good,
     show: (line) => `${line.good}/${line.cells}`,
     doc: "cells that finished; a setting with fewer was averaged over other frames"},
  ], lines, {name: "ranking", sort: state().sort ? {column: state().sort, descending: state().down === "1"}
                                                  : {column: errorName(metric), descending: false},
             filter: state().filter ?? "",
             changed: ({sort, filter}) => keep({sort: sort?.column, down: sort?.descending ? "1" : "", filter})});
}

function sceneCards() {
  return el("div", {class: "cards"}, scenes.map((scene) => {
    const frame = scene.frames[0];
    const best = scene.rows.filter((row) => row.rmse !== null && row.status === "ok" && !isSeparation(row))
      .reduce((a, b) => (!a || b.rmse < a.rmse ? b : a), null);
    return el("a", {class: "card scene-card", href: linkTo({page: "scene", scene: scene.id})},
      frameSize(scene, frame) ? lazyThumb(scene, frame, null, "shaded") : el("div", {class: "thumb none"}, "no images"),
      el("strong", {}, scene.id),
      el("span", {class: "small soft"}, scene.shows),
      best ? el("span", {class: "small"}, `best: ${best.setting}, rmse ${number(best.rmse)}`) : null);
  }));
}

let redraw = () => {};
onThemeChange(() => redraw());

// What the overview shows, as the hash says it.
function chosenOf(view) {
  const named = (view.scenes ?? "").split("|").filter((id) => sceneOf.has(id));
  const metrics = errorMetrics.map(({id}) => id);
  return {picked: new Set(named.length > 0 ? named : scenes.map(({id}) => id)),
          metric: metrics.includes(view.metric) ? view.metric : run.curve_metric,
          x: view.x === "linear" ? "linear" : "log", y: view.y === "linear" ? "linear" : "log"};
}

export function overview(page, view) {
  const chosen = chosenOf(view);
  const {canvas, box} = chartCanvas("Error against frame time of every setting; the ranking below has the same numbers");
  const table = el("div", {id: "ranking"});
  const note = el("p", {class: "soft small"});
  const draw = () => {
    const picked = rows.filter((row) => chosen.picked.has(row.scene));
    const study = costStudy(picked, chosen.metric);
    note.textContent = study.points.length === 0 ? "No cell of these scenes has this error and a time." :
      `${plural(chosen.picked.size, "scene", "scenes")}, ${plural(study.frames, "frame", "frames")}. Filled, on the ` +
      "broad line: surely faster than everything more accurate. Bars: 95 % intervals of the time. A click opens a " +
      "setting where it is worst.";
    costChart(canvas, study, {...chosen, opened: ({setting}) => openSetting(setting, chosen.picked)});
    fill(table, ranking(study, chosen.picked, chosen.metric));
  };
  redraw = () => { if (canvas.isConnected) draw(); };
  const changed = (changes) => {
    Object.assign(chosen, changes);
    keep({scenes: chosen.picked.size === scenes.length ? "" : [...chosen.picked].join("|"),
          metric: chosen.metric === run.curve_metric ? "" : chosen.metric,
          x: chosen.x === "log" ? "" : chosen.x, y: chosen.y === "log" ? "" : chosen.y, sort: "", down: ""});
    draw();
  };

  const chip = (id, onclick) => el("button", {type: "button", class: "chip", data: {scene: id}, onclick}, id || "all scenes");
  const everything = () => {
    changed({picked: new Set(scenes.map(({id}) => id))});
    press();
  };
  const chips = [chip("", everything), ...scenes.map(({id}) => chip(id, () => pick(id)))];
  const press = () => {
    const all = chosen.picked.size === scenes.length;
    for (const one of chips)
      one.setAttribute("aria-pressed", String(all ? one.dataset.scene === "" : chosen.picked.has(one.dataset.scene)));
  };
  // Out of all of them the first click picks one; the last one cannot be left out.
  function pick(id) {
    const picked = chosen.picked.size === scenes.length && scenes.length > 1 ? new Set([id]) : new Set(chosen.picked);
    if (chosen.picked.size < scenes.length) picked.has(id) ? picked.delete(id) : picked.add(id);
    changed({picked: picked.size > 0 ? picked : new Set(scenes.map((scene) => scene.id))});
    press();
  }
  const axes = (name) => choice(`${name} axis`, [["log", `${name} log`], ["linear", "linear"]], chosen[name],
    (value) => changed({[name]: value}));
  fill(page,
    el("h1", {}, "What accuracy costs"),
    el("div", {class: "card"},
      el("div", {class: "row chart-tools"},
        dropDown("Error", errorMetrics.map(({id}) => [id, errorName(id)]), chosen.metric, (metric) => changed({metric})),
        axes("x"), axes("y")),
      box,
      el("div", {class: "row chips", role: "group", "aria-label": "Scenes"}, chips),
      note),
    el("h2", {}, "Ranking"), table,
    el("h2", {}, "Scenes"), sceneCards());
  press();
  draw();
}
