// What must not be overlooked, above every page; each entry unfolds to all that it counts.
import {el} from "./dom.js";
import {milliseconds, plural} from "./format.js";
import {rows, run} from "./run.js";
import {linkTo} from "./state.js";

const placeOf = (row) => `${row.scene}, frame ${row.frame}, ${row.setting}`;
const linkOf = (row) => linkTo({page: "scene", scene: row.scene, frame: row.frame, setting: row.setting});

function entry(severity, title, list) {
  return list.length === 0 ? [] : [{severity, title: title(list.length), list}];
}

export const alerts = (() => {
  const told = (choose, tell) => rows.filter(choose).map((row) =>
    ({where: placeOf(row), link: linkOf(row), what: tell(row)}));
  const checked = run.references.filter(({checked: c}) => c);
  const wrong = (() => {
    let pixels = 0, covered = 0;
    for (const {checked: c} of checked) {
      pixels += c.pixels;
      covered += c.pixels * c.coverage;
    }
    const share = covered / pixels;
    return pixels > 0 && !(share >= run.least_coverage && share <= run.most_coverage)
      ? [{where: "all scenes", link: linkTo({page: "truth"}),
          what: `${(100 * share).toFixed(1)} % of 95 % intervals hold the exact value`}] : [];
  })();
  return [
    ...(run.finished ? [] : [{severity: "bad", title: "The run did not finish", list: [
      {where: "run.json", link: linkTo({page: "provenance"}), what: "rows are missing; --resume does the rest"}]}]),
    ...entry("bad", (n) => plural(n, "failed cell", "failed cells"),
      told((row) => row.status !== "ok" && row.status !== "unsupported", (row) => `${row.status}: ${row.message}`)),
    ...entry("bad", (n) => `${plural(n, "image", "images")} with pixels that are not finite`,
      told((row) => row.nonfinite > 0, (row) => plural(row.nonfinite, "pixel", "pixels"))),
    ...entry("bad", () => "The reference's error bars are wrong", wrong),
    ...entry("warn", (n) => plural(n, "skipped scene", "skipped scenes"),
      run.skipped_scenes.map(([scene, reason]) => ({where: scene, link: null, what: reason}))),
    ...entry("warn", (n) => plural(n, "unsupported cell", "unsupported cells"),
      told((row) => row.status === "unsupported", (row) => row.message)),
    ...entry("warn", (n) => `${plural(n, "cell lacks", "cells lack")} effects`,
      told((row) => row.effects_missing, (row) => row.effects_missing)),
    ...entry("warn", (n) => plural(n, "unstable time", "unstable times"),
      told((row) => row.unstable === 1, (row) =>
        `${milliseconds(row.frame_ms)} [${milliseconds(row.frame_ms_low)}, ${milliseconds(row.frame_ms_high)}]`)),
  ];
})();

function listOf({list}) {
  const most = 200;
  return [
    el("ul", {class: "small"}, list.slice(0, most).map(({where, link, what}) =>
      el("li", {}, link ? el("a", {href: link}, where) : where, `: ${what}`))),
    list.length > most ? el("p", {class: "soft small"}, `… and ${list.length - most} more in the table of rows`) : null,
  ];
}

export function alertBar() {
  if (alerts.length === 0) return el("p", {class: "alert good"}, "No warnings: every cell finished, all times are stable.");
  return el("div", {class: "alerts", role: "region", "aria-label": "Warnings"}, alerts.map((alert) => {
    // Filled when it is opened: hundreds of entries would slow every page.
    const box = el("details", {class: `alert ${alert.severity}`, ontoggle: () => {
      if (box.open && box.children.length === 1) box.append(...listOf(alert).filter(Boolean));
    }}, el("summary", {}, alert.title));
    return box;
  }));
}
