// The run that the page shows: rows as objects, settings, scenes. Nothing here changes later.
import {pageData} from "./data.js";

export const run = pageData("run");

function readRows(columns) {
  const cells = columns.map(({values, texts, index}) => values ?? index.map((i) => texts[i]));
  const count = cells.length > 0 ? cells[0].length : 0;
  const rows = [];
  for (let r = 0; r < count; ++r) {
    const row = {id: r};
    columns.forEach(({name}, c) => { row[name] = cells[c][r]; });
    rows.push(row);
  }
  return rows;
}

export const rows = readRows(run.columns);

export const isSeparation = (row) => row.method === run.separation;

// Whether the row's time was measured here, as harness/study/pareto.cpp has it.
export const isTimed = (row) => row.status === "ok" && !isSeparation(row) &&
  row.renderer !== run.external_renderer && row.frame_ms > 0;

// Every setting in the rows, in the run's order; of hand-made rows those that run.json lacks last.
export const settings = (() => {
  const known = new Map(run.settings.map((setting) => [setting.name, setting]));
  for (const row of rows)
    if (!known.has(row.setting))
      known.set(row.setting, {name: row.setting, method: row.method, params: row.params, sets: null});
  const used = new Set(rows.map((row) => row.setting));
  return [...known.values()].filter((setting) => used.has(setting.name));
})();
export const settingOf = new Map(settings.map((setting) => [setting.name, setting]));

// Every scene in the rows, in the run's order, with the frames that its rows have.
export const scenes = (() => {
  const known = new Map(run.scenes.map((scene, index) =>
    [scene.id, {...scene, index, sizes: new Map(scene.frames.map((f) => [f.index, f]))}]));
  for (const row of rows)
    if (!known.has(row.scene))
      known.set(row.scene, {id: row.scene, shows: "", figure: "", source: "", chosen: [], index: -1,
                            sizes: new Map()});
  const list = [...known.values()];
  for (const scene of list) {
    scene.rows = rows.filter((row) => row.scene === scene.id);
    scene.frames = [...new Set(scene.rows.map((row) => row.frame))].sort((a, b) => a - b);
  }
  return list.filter((scene) => scene.rows.length > 0);
})();
export const sceneOf = new Map(scenes.map((scene) => [scene.id, scene]));

export function rowOf(scene, frame, setting) {
  return sceneOf.get(scene)?.rows.find((row) => row.frame === frame && row.setting === setting);
}

// The parameters in which the settings of a method differ here: they tell them apart.
export const telling = (() => {
  const seen = new Map();
  const split = (params) => params.split(";").filter(Boolean);
  const idOf = (assignment) => assignment.slice(0, assignment.indexOf("="));
  for (const {method, params} of settings)
    for (const one of split(params)) {
      const key = `${method}\n${idOf(one)}`;
      if (!seen.has(key)) seen.set(key, new Set());
      seen.get(key).add(one);
    }
  return (setting) => split(setting.params)
    .filter((one) => seen.get(`${setting.method}\n${idOf(one)}`).size > 1).join(", ");
})();

// Metrics that can be an error on an axis, as harness/study/pareto.cpp has it.
export const errorMetrics = run.metrics
  .filter(({id, unit}) => unit !== "pixels" && id !== "reference_se");

const plain = /^[\w@%+=:,./-]+$/;
const quoted = (word) => (plain.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);

// The command that makes one row again; null for rows that no method made.
export function commandOf(row) {
  if (row.renderer === run.external_renderer) return null;
  const scene = sceneOf.get(row.scene);
  const setting = settingOf.get(row.setting);
  const isOfLibrary = scene.source.endsWith(`/scenes/${scene.id}.toml`) || scene.source === "";
  const sets = setting.sets ?? row.params.split(";").filter(Boolean);
  const words = ["./run", "compare", "--scene", isOfLibrary ? scene.id : scene.source,
                 "--method", row.method];
  for (const set of sets) words.push("--set", `${row.method}.${set}`);
  words.push("--size", `${row.width}x${row.height}`, "--repeats", String(run.repeats),
             "--seed", String(run.seed), "--reference", run.reference,
             "--reference-se", String(run.reference_se), "--effects", run.effects.join(","));
  return words.map(quoted).join(" ");
}
