// report.html: the header, the warnings, and whichever page the hash asks for.
import {alertBar} from "./alerts.js";
import {comparePage} from "./compare_page.js";
import {pageData} from "./data.js";
import {byId, el, fill} from "./dom.js";
import {effectsPage} from "./effects_page.js";
import {overview} from "./overview.js";
import {run} from "./run.js";
import {scenePage} from "./scene_page.js";
import {provenancePage, rowsPage, tablePages, truthPage} from "./sections.js";
import {linkTo, onGo, state} from "./state.js";
import {themeButton} from "./theme.js";

const pages = [
  {id: "", title: "Overview", draw: overview},
  {id: "scene", title: "Scenes", draw: scenePage},
  {id: "compare", title: "Compare", draw: comparePage},
  {id: "rows", title: "Rows", draw: rowsPage},
  {id: "effects", title: "Effects", draw: effectsPage},
  {id: "truth", title: "Truth", draw: truthPage},
  ...tablePages,
  {id: "provenance", title: "Provenance", draw: provenancePage},
];

function header() {
  const known = Object.fromEntries(run.provenance);
  fill(byId("nav"), pages.map(({id, title}) => el("a", {href: linkTo({page: id}), data: {page: id}}, title)));
  fill(byId("theme-place"), themeButton());
  const facts = [`${run.width} × ${run.height}`, known.renderer, known.cpu, known.threads && `${known.threads} threads`,
                 known.build, known.commit, known.started].filter(Boolean);
  fill(byId("alerts"), el("p", {class: "facts-line small soft"}, el("code", {}, run.command), el("br"), facts.join(" · ")), alertBar());
  fill(byId("colophon"), `Penumbra ${known.version ?? ""}. Visibility is the share of the light that a point sees. `,
    "docs/REPORT.md says how to read this page.");
  byId("licence").textContent = pageData("chart-licence");
  byId("skip").addEventListener("click", (event) => { event.preventDefault(); byId("page").focus(); });
}

async function draw(view) {
  const page = pages.find(({id}) => id === (view.page ?? "")) ?? pages[0];
  document.title = [view.scene ?? page.title, run.name, "Penumbra"].filter(Boolean).join(" · ");
  for (const link of byId("nav").children)
    link.dataset.page === page.id ? link.setAttribute("aria-current", "page") : link.removeAttribute("aria-current");
  const place = el("div", {id: "page", tabIndex: -1, data: {page: page.id || "overview"}});
  byId("page").replaceWith(place);
  try {
    await page.draw(place, view);
  } catch (error) {
    fill(place, el("p", {class: "alert bad"}, `This page cannot be shown: ${error.message}`));
    console.error(error);
  }
  place.dataset.drawn = "1";
}

header();
onGo((view) => {
  scrollTo(0, 0);
  draw(view);
});
draw(state());
