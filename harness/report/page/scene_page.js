// One scene: methods x frames beside the reference, and every number of every setting.
import {choice, copyButton, dropDown, el, fill} from "./dom.js";
import {milliseconds, number, percent} from "./format.js";
import {frameSize, hasImage} from "./planes.js";
import {commandOf, isSeparation, rowOf, run, scenes, sceneOf, settingOf, settings, telling} from "./run.js";
import {go, keep, linkTo, state} from "./state.js";
import {dataTable} from "./table.js";
import {lazyThumb} from "./thumbs.js";

const modes = [["shaded", "Shaded"], ["visibility", "Visibility"], ["error", "Error"]];

function tile(scene, frame, row, mode) {
  const shown = mode === "error" && !row ? "classes" : mode;
  const link = linkTo({page: "compare", scene: scene.id, frame, b: row?.setting});
  return el("a", {class: "tile", href: link}, lazyThumb(scene, frame, row, shown),
    row ? el("span", {class: "small"}, [row.rmse === null ? null : `rmse ${number(row.rmse)}`, milliseconds(row.frame_ms)]
      .filter(Boolean).join(" · "))
        : el("span", {class: "small soft"}, shown === "classes" ? "lit, penumbra, umbra" : "the truth"));
}

function cell(scene, frame, setting, mode) {
  const row = rowOf(scene.id, frame, setting.name);
  if (!row) return el("td", {}, el("div", {class: "thumb none soft"}, "not run"));
  if (row.status !== "ok")
    return el("td", {}, el("div", {class: "thumb none"}, el("strong", {class: "bad"}, row.status), el("span", {}, row.message)));
  if (!hasImage(row, scene)) return el("td", {}, el("div", {class: "thumb none soft"}, "no image"));
  return el("td", {}, tile(scene, frame, row, mode));
}

// One frame: the reference and then the settings, as many in a line as there is room for.
function wall(scene, own, mode) {
  const frame = scene.frames[0];
  const one = (title, below, content) => el("figure", {class: "on-wall"}, content,
    el("figcaption", {}, el("strong", {}, title), below ? el("span", {class: "small soft"}, below) : null));
  return el("div", {class: "cards"},
    one("reference", null, frameSize(scene, frame) ? tile(scene, frame, null, mode) : "no image"),
    own.map((setting) => one(setting.name, telling(setting), [...cell(scene, frame, setting, mode).childNodes])));
}

function grid(scene, own, mode) {
  if (scene.frames.length === 1) return wall(scene, own, mode);
  const heads = scene.frames.map((frame) => el("th", {scope: "col"}, `frame ${frame}`));
  const line = (title, below, cells) => el("tr", {}, el("th", {scope: "row"}, el("span", {}, title),
    below ? el("span", {class: "small soft"}, below) : null), cells);
  return el("div", {class: "scroll grid", tabindex: "0", role: "region", "aria-label": "methods and frames"},
    el("table", {}, el("thead", {}, el("tr", {}, el("td"), heads)), el("tbody", {},
      line("reference", null, scene.frames.map((frame) => el("td", {},
        frameSize(scene, frame) ? tile(scene, frame, null, mode) : "no image"))),
      own.map((setting) => line(setting.name, telling(setting),
        scene.frames.map((frame) => cell(scene, frame, setting, mode)))))));
}

function numbers(scene, chosen) {
  const column = (name, title, show = number, extra = {}) =>
    ({name, title, number: true, value: (row) => row[name], show: (row) => show(row[name]), ...extra});
  return dataTable([
    {name: "frame", title: "frame", number: true, value: (row) => row.frame},
    {name: "setting", title: "setting", value: (row) => row.setting, show: (row) => (hasImage(row, scene)
      ? el("a", {href: linkTo({page: "compare", scene: scene.id, frame: row.frame, b: row.setting})}, row.setting) : row.setting)},
    {name: "status", title: "status", value: (row) => row.status},
    {name: "rmse", title: "rmse ± reference", number: true, value: (row) => row.rmse, show: (row) =>
      (row.rmse === null ? "" : `${number(row.rmse)} ± ${number(row.reference_se)}`)},
    column("rmse_penumbra", "penumbra"), column("bias", "bias"), column("p99", "p99"), column("max_error", "max"),
    column("ssim", "ssim"), column("flip", "flip"), column("leak_rate", "leaks", percent),
    column("false_shadow_rate", "false shadows", percent), column("flicker", "flicker"),
    {name: "frame_ms", title: "frame ms", number: true, value: (row) => row.frame_ms, show: (row) =>
      (row.frame_ms === null ? "" : `${number(row.frame_ms)} [${number(row.frame_ms_low)}, ${number(row.frame_ms_high)}]` +
        (row.unstable ? " unstable" : ""))},
    column("build_ms", "build"), column("shade_ms", "shade"), column("maps", "maps"), column("draw_calls", "draws"),
    column("texture_mib", "MiB"),
    {name: "command", title: "reproduce", value: (row) => commandOf(row) ?? "", show: (row) => {
      const command = commandOf(row);
      if (!command) return "";
      const box = el("details", {}, el("summary", {}, "command"),
        el("div", {class: "command"}, el("pre", {}, command), copyButton(() => command)));
      return box;
    }},
  ], scene.rows, {name: `${scene.id}`, filter: chosen.filter ?? "", rowClass: (row) =>
       (row.setting === chosen.setting && (chosen.frame === undefined || row.frame === Number(chosen.frame)) ? "chosen" : ""),
     sort: chosen.sort ? {column: chosen.sort, descending: chosen.down === "1"} : {column: "rmse", descending: false},
     changed: ({sort, filter}) => keep({sort: sort?.column, down: sort?.descending ? "1" : "", filter})});
}

// Of each method its defaults, or the middle of its settings where these were not run.
function representatives(own) {
  const byMethod = new Map();
  for (const setting of own) byMethod.set(setting.method, [...(byMethod.get(setting.method) ?? []), setting]);
  return [...byMethod].map(([method, list]) =>
    list.find(({name}) => name === method) ?? list[Math.floor(list.length / 2)]);
}

export function scenePage(page, view) {
  const scene = sceneOf.get(view.scene) ?? scenes[0];
  const own = settings.filter((setting) => scene.rows.some((row) => row.setting === setting.name));
  const few = representatives(own);
  let mode = modes.some(([id]) => id === view.show) ? view.show : "shaded";
  let all = view.all === "1" || few.length === own.length;
  const place = el("div", {id: "grid"});
  const draw = () => fill(place, grid(scene, all ? own : few, mode));
  fill(page,
    el("div", {class: "row spread"}, el("h1", {}, scene.id),
      dropDown("Scene", scenes.map(({id}) => [id, id]), scene.id, (id) => go({page: "scene", scene: id, show: state().show}))),
    el("p", {}, scene.shows, scene.figure ? el("span", {class: "soft"}, ` — ${scene.figure}`) : null),
    scene.chosen.length > 0 ? el("ul", {class: "small soft"}, scene.chosen.map((text) => el("li", {}, text))) : null,
    el("div", {class: "row"},
      choice("Show", modes, mode, (value) => { mode = value; keep({show: value === "shaded" ? "" : value}); draw(); }),
      few.length === own.length ? null :
        choice("Settings", [["few", `${few.length} methods`], ["all", `all ${own.length} settings`]], all ? "all" : "few",
          (value) => { all = value === "all"; keep({all: all ? "1" : ""}); draw(); }),
      run.stride > 1 ? el("span", {class: "soft small"},
        `Images show one pixel of every ${run.stride} × ${run.stride}.`) : null),
    place,
    el("h2", {}, "Every setting"), numbers(scene, view));
  draw();
}
