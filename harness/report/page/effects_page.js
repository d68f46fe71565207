// Effects: what a scene calls for and why, what each method makes of it, what each effect costs.
import {choice, el, fill} from "./dom.js";
import {milliseconds, number, percent, plural} from "./format.js";
import {isSeparation, rows, run, sceneOf} from "./run.js";
import {keep, linkTo, remembered} from "./state.js";
import {dataTable} from "./table.js";

const sceneColumn = {name: "scene", value: (g) => g.scene,
  show: (g) => (sceneOf.has(g.scene) ? el("a", {href: linkTo({page: "scene", scene: g.scene})}, g.scene) : g.scene)};
const inWords = (effect) => effect.replaceAll("_", " ");
const numeric = (name, title, show = number, extra = {}) =>
  ({name, title, number: true, value: (g) => g[name], show: (g) => show(g[name]), ...extra});

// ---- what methods make of it

function methodTable(view) {
  const words = (text) => text.split(/\s+/).filter(Boolean);
  const groups = new Map();
  for (const row of rows) {
    if (isSeparation(row) || row.status !== "ok" || row.renderer === run.external_renderer) continue;
    const key = JSON.stringify([row.scene, row.method]);
    const group = groups.get(key) ?? {scene: row.scene, method: row.method, simulated: new Set(), skipped: new Set(), missing: new Set()};
    for (const column of ["simulated", "skipped", "missing"])
      for (const word of words(row[`effects_${column}`])) group[column].add(word);
    groups.set(key, group);
  }
  const list = [...groups.values()];
  const all = [...new Set(list.flatMap(({simulated, skipped, missing}) => [...simulated, ...skipped, ...missing]))].sort();
  const mark = {simulated: "✓", skipped: "–", missing: "✗ missing"};
  const stateOf = (group, effect) => ["missing", "simulated", "skipped"].find((column) => group[column].has(effect)) ?? "";
  return dataTable([
    sceneColumn, {name: "method", value: (g) => g.method},
    ...all.map((effect) => ({name: effect, title: inWords(effect), value: (g) => stateOf(g, effect),
      show: (g) => el("span", {class: stateOf(g, effect) === "missing" ? "bad" : "soft"}, mark[stateOf(g, effect)] ?? "")})),
  ], list, {name: "effects", ...remembered(view)});
}

// ---- what the scenes call for

// Frames of one scene, one after another, about which the same was found out.
function alike() {
  const groups = [];
  const told = ({effects}) => JSON.stringify(effects);
  const records = run.scenes.flatMap(({id}) => run.analysis.filter(({scene}) => scene === id).sort((a, b) => a.frame - b.frame));
  for (const record of records) {
    const last = groups.at(-1);
    if (last?.scene === record.scene && last.last + 1 === record.frame && told(last) === told(record)) last.last = record.frame;
    else groups.push({...record, last: record.frame});
  }
  return groups;
}

function evidence() {
  if (run.analysis.length === 0)
    return [el("p", {class: "soft"}, "The run has no record of it.")];
  const reasons = (list) => el("ul", {class: "small reasons"}, list.map(({effect, evidence: why}) =>
    el("li", {}, el("strong", {}, inWords(effect)), `: ${why}`)));
  return alike().map(({scene, frame, last, effects}) => {
    const called = effects.filter((e) => e.called_for), absent = effects.filter((e) => !e.called_for);
    const frames = frame !== last ? `, frames ${frame} to ${last}` : sceneOf.get(scene)?.frames.length > 1 ? `, frame ${frame}` : "";
    return el("details", {class: "card evidence"},
      el("summary", {}, el("strong", {}, `${scene}${frames}`), ": ",
        called.length > 0 ? called.map((e) => inWords(e.effect)).join(", ") : "nothing"),
      called.length > 0 ? [el("p", {class: "soft"}, "Called for"), reasons(called)] : null,
      absent.length > 0 ? [el("p", {class: "soft"}, "Not called for, so that it costs nothing"), reasons(absent)] : null);
  });
}

function analysisTimes() {
  const sum = (name) => run.analysis.reduce((total, record) => total + record[name], 0);
  if (run.analysis.length === 0) return [];
  const list = run.analysis.map((record) => ({...record, share: record.analysis_ms / record.load_ms}));
  return [
    el("p", {}, `Finding that out took ${milliseconds(sum("analysis_ms"))} for ${plural(list.length, "frame", "frames")}, beside ` +
      `${milliseconds(sum("load_ms"))} of loading them (asset, geometry, BVH, upload, G-buffer).`),
    el("details", {}, el("summary", {}, "What analysis took, frame by frame"),
      dataTable([sceneColumn, numeric("frame", "frame"), numeric("load_ms", "load ms"), numeric("analysis_ms", "analysis ms"),
                 numeric("share", "share of load", percent, {largeFirst: true})], list, {name: "analysis"})),
  ];
}

// ---- what effects cost: effects.csv of `compare --effects-table`

function plans() {
  const [header, ...lines] = run.tables.effects;
  return lines.map((line) => {
    const cell = Object.fromEntries(header.map((name, c) => [name, line[c]]));
    for (const name of ["frame_ms", "rmse_to_auto", "max_to_auto", "rmse"])
      cell[name] = cell[name] === "" ? null : Number(cell[name]);
    return cell;
  });
}

// Every plan but auto against auto: times summed and errors averaged over the frames that have both.
function planGroups(keyOf) {
  const cells = plans();
  const at = (c) => JSON.stringify([c.scene, c.frame, c.setting]);
  const auto = new Map(cells.filter(({plan}) => plan === "auto").map((c) => [at(c), c]));
  const groups = new Map();
  for (const cell of cells) {
    const own = auto.get(at(cell));
    if (cell.plan === "auto" || cell.frame_ms === null || (own?.frame_ms ?? null) === null) continue;
    const key = JSON.stringify([...keyOf(cell), cell.plan]);
    const group = groups.get(key) ?? {scene: cell.scene, setting: cell.setting, plan: cell.plan, frames: 0, plan_ms: 0,
                                      auto_ms: 0, max: 0, toAuto: 0, own: 0, autoOwn: 0};
    group.frames += 1;
    group.plan_ms += cell.frame_ms;
    group.auto_ms += own.frame_ms;
    group.max = Math.max(group.max, cell.max_to_auto ?? 0);
    group.toAuto += (cell.rmse_to_auto ?? 0) ** 2;
    group.own += (cell.rmse ?? 0) ** 2;
    group.autoOwn += (own.rmse ?? 0) ** 2;
    groups.set(key, group);
  }
  return [...groups.values()].map((g) => ({...g, ratio: g.plan_ms / g.auto_ms, rmse_to_auto: Math.sqrt(g.toAuto / g.frames),
    rmse: Math.sqrt(g.own / g.frames), auto_rmse: Math.sqrt(g.autoOwn / g.frames)}));
}

function costTable(bySuite) {
  const label = (plan) => (plan === "all" ? "all effects, every pixel" : `without ${inWords(plan.slice(1))}`);
  return dataTable([
    ...(bySuite ? [] : [sceneColumn]), {name: "setting", value: (g) => g.setting},
    {name: "plan", value: (g) => g.plan, show: (g) => label(g.plan)},
    numeric("frames", "frames"), numeric("plan_ms", "ms"), numeric("auto_ms", "auto ms"),
    numeric("ratio", "time / auto", number, {doc: "below 1: faster than auto"}),
    numeric("rmse_to_auto", "rmse to auto", number, {largeFirst: true, doc: "what the plan changes in the image"}),
    numeric("max", "max to auto", number, {largeFirst: true}),
    numeric("rmse", "rmse", number, {doc: "against the reference"}), numeric("auto_rmse", "auto's rmse"),
  ], planGroups((cell) => (bySuite ? [cell.setting] : [cell.scene, cell.setting])), {name: "effects-cost", most: 40});
}

function cost(view) {
  if (!run.tables.effects)
    return [el("p", {class: "soft"}, "What each effect costs is measured by ", el("code", {}, "compare --effects-table"), ".")];
  const place = el("div", {id: "effects-cost"});
  const draw = (by) => fill(place, costTable(by === "suite"));
  const by = view.by === "suite" ? "suite" : "scene";
  draw(by);
  return [
    el("p", {}, "Every line is a plan beside auto, timed in the same rounds: leaving one effect out of auto (what that saves, and ",
      "the error that it makes), or simulating all at every pixel. Times are sums, errors root mean squares over the frames."),
    choice("Rows", [["scene", "by scene"], ["suite", "all scenes"]], by,
      (value) => { keep({by: value === "suite" ? value : ""}); draw(value); }),
    place,
  ];
}

export function effectsPage(page, view) {
  fill(page, el("h1", {}, "Effects"),
    el("p", {}, "A method simulates what the scene calls for and it can: ✓. What the scene does not call for costs nothing: –. ",
      "What is called for but beyond the method is an error that the numbers contain: ✗."),
    el("p", {class: "soft"}, `Asked for: ${run.effects.join(", ")}.`),
    methodTable(view),
    el("h2", {}, "What effects cost"), cost(view),
    el("h2", {}, "What each scene calls for, and why"), evidence(), analysisTimes());
}
