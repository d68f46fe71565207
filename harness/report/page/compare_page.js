// Two images of one frame against each other: slider, flip, side by side, signed error.
import {choice, copyButton, dropDown, el, fill} from "./dom.js";
import {milliseconds, number} from "./format.js";
import {inspector} from "./inspector.js";
import {canvasOf, classNames, painted} from "./paint.js";
import {frameSize, hasImage, truthOf, visibilityOfRow} from "./planes.js";
import {commandOf, rowOf, run, sceneOf, scenes, settings} from "./run.js";
import {go, keep, linkTo, state} from "./state.js";
import {viewport} from "./viewport.js";

const kReference = "reference";
const layouts = [["slider", "Slider"], ["flip", "Flip"], ["side", "Side by side"], ["error", "Signed error"]];
const looks = [["shaded", "Shaded"], ["visibility", "Visibility"], ["classes", "Classes"]];

const oneOf = (choices, id) => (choices.some(([own]) => own === id) ? id : choices[0][0]);

// What the hash asks for, as far as the run has it.
function chosenOf(view) {
  const scene = sceneOf.get(view.scene) ?? scenes[0];
  const wanted = Number(view.frame ?? NaN);
  const frame = scene.frames.includes(wanted) ? wanted : scene.frames[0];
  const own = settings.map(({name}) => name).filter((name) => {
    const row = rowOf(scene.id, frame, name);
    return row && hasImage(row, scene);
  });
  const sides = [kReference, ...own];
  return {scene, frame, sides,
          a: sides.includes(view.a) ? view.a : kReference,
          b: sides.includes(view.b) ? view.b : own[0] ?? kReference,
          layout: oneOf(layouts, view.layout), look: oneOf(looks, view.look),
          mask: classNames.includes(view.mask) ? view.mask : "",
          at: Math.min(1, Math.max(0, Number(view.at ?? 0.5) || 0))};
}

function scaleLegend() {
  const canvas = el("canvas", {width: run.error_colours.length, height: 1, class: "scale", role: "img",
    "aria-label": "blue: too dark, white: right, red: leaks light"});
  const image = new ImageData(canvas.width, 1);
  run.error_colours.forEach((colour, i) => image.data.set([...colour, 255], 4 * i));
  canvas.getContext("2d").putImageData(image, 0, 0);
  return el("div", {class: "legend small"}, el("span", {}, `−${run.error_scale} too dark`), canvas,
    el("span", {}, `+${run.error_scale} leaks`));
}

function caption(chosen, side) {
  const row = side === kReference ? null : rowOf(chosen.scene.id, chosen.frame, side);
  if (!row) return el("span", {}, el("strong", {}, kReference));
  return el("span", {}, el("strong", {}, side), el("span", {class: "soft"},
    ` ${row.rmse === null ? "" : `rmse ${number(row.rmse)}`} ${milliseconds(row.frame_ms)}`));
}

// The images and all that moves on them. Returns {box, update(changes)}.
function stage(chosen, truth, images, view) {
  const sides = [chosen.a, chosen.b];
  const pictures = new Map();
  const picture = (side, look) => {
    const mask = chosen.mask ? classNames.indexOf(chosen.mask) : null;
    const key = `${side} ${look} ${mask}`;
    if (!pictures.has(key)) pictures.set(key, canvasOf(painted(truth, images.get(side) ?? truth.reference, look, mask)));
    return pictures.get(key);
  };
  const info = inspector(truth, [...new Set(sides)].map((name) => ({name, v: images.get(name)})));
  let pinned = null, flipped = view.flipped === "1";
  const box = el("div", {class: "stage"});

  const canvases = [0, 1].map((i) => el("canvas", {class: "view", tabindex: "0", data: {side: String(i)},
    "aria-label": "Image; plus and minus zoom, arrows move, shift and arrows pick a pixel, space flips"}));
  const divider = el("input", {type: "range", min: "0", max: "1", step: "0.001", value: String(chosen.at), id: "slider",
    "aria-label": "Where the second image begins", oninput: () => {
      chosen.at = Number(divider.value);
      draw();
      keep({at: chosen.at.toFixed(3)});
    }});
  const flipButton = el("button", {type: "button", id: "flip", onclick: flip}, "Flip (space)");
  function flip() {
    flipped = !flipped;
    keep({flipped: flipped ? "1" : ""});
    draw();
  }
  const legend = scaleLegend();
  const names = [0, 1].map(() => el("figcaption"));
  const figures = [0, 1].map((i) => el("figure", {}, canvases[i], names[i]));

  const port = viewport(truth, {
    redraw: () => draw(),
    settled: () => keep({zoom: port.view.zoom > 1 ? port.view.zoom.toFixed(2) : "",
                         x: port.view.zoom > 1 ? port.view.x.toFixed(1) : "", y: port.view.zoom > 1 ? port.view.y.toFixed(1) : ""}),
    zoom: Number(view.zoom) || 1, x: Number(view.x) || undefined, y: Number(view.y) || undefined});

  function mark(canvas) {
    if (!pinned) return;
    const scale = port.scaleOf(canvas), context = canvas.getContext("2d");
    const x = canvas.width / 2 + (pinned.x - port.view.x) * scale, y = canvas.height / 2 + (pinned.y - port.view.y) * scale;
    const size = Math.max(scale, 7), shift = (scale - size) / 2;
    for (const [colour, width] of [["#000", 4], ["#fff", 2]]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.strokeRect(x + shift, y + shift, size, size);
    }
  }

  function draw() {
    const two = chosen.layout === "side" || (chosen.layout === "error" && chosen.a !== kReference);
    figures[1].hidden = !two;
    divider.hidden = chosen.layout !== "slider";
    flipButton.hidden = chosen.layout !== "flip";
    legend.hidden = chosen.layout !== "error";
    box.classList.toggle("two", two);
    for (const canvas of two ? canvases : canvases.slice(0, 1)) {
      const width = Math.round(canvas.clientWidth * devicePixelRatio) || truth.width;
      canvas.width = width;
      canvas.height = Math.round((width * truth.height) / truth.width);
    }
    const [first, second] = canvases;
    const look = chosen.look;
    if (chosen.layout === "slider") {
      const middle = Math.round(chosen.at * first.width);
      port.draw(first, picture(chosen.a, look), 0, middle);
      port.draw(first, picture(chosen.b, look), middle);
      const context = first.getContext("2d");
      context.fillStyle = "#fff";
      context.fillRect(middle - 1, 0, 2, first.height);
      fill(names[0], caption(chosen, chosen.a), el("span", {class: "right"}, caption(chosen, chosen.b)));
    } else if (chosen.layout === "flip") {
      const side = flipped ? chosen.a : chosen.b;
      port.draw(first, picture(side, look));
      fill(names[0], caption(chosen, side));
    } else if (chosen.layout === "side") {
      port.draw(first, picture(chosen.a, look));
      port.draw(second, picture(chosen.b, look));
      names.forEach((name, i) => fill(name, caption(chosen, sides[i])));
    } else {
      const shown = two ? sides : [chosen.b];
      shown.forEach((side, i) => {
        port.draw(canvases[i], picture(side, "error"));
        fill(names[i], caption(chosen, side), el("span", {class: "soft"}, "less the reference"));
      });
    }
    canvases.forEach(mark);
  }

  const pixelAt = ({x, y}) => {
    const pixel = {x: Math.floor(x), y: Math.floor(y)};
    return pixel.x >= 0 && pixel.y >= 0 && pixel.x < truth.width && pixel.y < truth.height ? pixel : null;
  };
  function pin(pixel) {
    pinned = pixel;
    info.show(pixel);
    if (pixel) port.show({x: pixel.x + 0.5, y: pixel.y + 0.5});
    keep({pixel: pixel ? `${pixel.x},${pixel.y}` : ""});
    draw();
  }
  for (const canvas of canvases) {
    port.listen(canvas, {
      tapped: (at) => {
        const pixel = pixelAt(at);
        pin(pixel && pinned && pixel.x === pinned.x && pixel.y === pinned.y ? null : pixel);
      },
      over: (at) => { if (!pinned) info.show(pixelAt(at)); }});
    canvas.addEventListener("keydown", (event) => {
      const step = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
      if (step && event.shiftKey) {
        const from = pinned ?? {x: Math.floor(port.view.x), y: Math.floor(port.view.y)};
        const next = pixelAt({x: from.x + step[0], y: from.y + step[1]});
        if (next) pin(next);
      } else if (step) {
        port.view.x += (step[0] * truth.width) / (10 * port.view.zoom);
        port.view.y += (step[1] * truth.height) / (10 * port.view.zoom);
        port.changed();
      } else if (event.key === "+" || event.key === "=") port.zoomAt(1.5);
      else if (event.key === "-") port.zoomAt(1 / 1.5);
      else if (event.key === "0") port.zoomAt(1e-9);
      else if (event.key === " " && chosen.layout === "flip") flip();
      else return;
      event.preventDefault();
    });
  }
  const zoomButtons = el("span", {class: "group"},
    el("button", {type: "button", "aria-label": "Zoom out", onclick: () => port.zoomAt(1 / 1.5)}, "−"),
    el("button", {type: "button", "aria-label": "Zoom in", onclick: () => port.zoomAt(1.5)}, "+"),
    el("button", {type: "button", onclick: () => port.zoomAt(1e-9)}, "Fit"));

  fill(box, el("div", {class: "figures"}, figures), divider,
    el("div", {class: "row spread"}, el("span", {class: "row"}, zoomButtons, flipButton), legend), info.box);
  const asked = /^(\d+),(\d+)$/.exec(view.pixel ?? "");
  if (asked) {
    pinned = pixelAt({x: Number(asked[1]), y: Number(asked[2])});
    info.show(pinned);
  }
  new ResizeObserver(draw).observe(box);
  return {box, update: (changes) => { Object.assign(chosen, changes); draw(); }};
}

function commandCard(chosen) {
  const named = [...new Set([chosen.a, chosen.b])].filter((side) => side !== kReference);
  return el("div", {}, named.map((side) => {
    const row = rowOf(chosen.scene.id, chosen.frame, side);
    const command = commandOf(row);
    return el("div", {class: "card"}, el("div", {class: "row spread"}, el("strong", {}, side),
      command ? copyButton(() => command, "Copy command") : null),
      row.params ? el("p", {class: "small soft mono"}, row.params.replaceAll(";", "; ")) : null,
      row.message ? el("p", {class: "small"}, row.message) : null,
      row.effects_missing ? el("p", {class: "small warn"}, `Effects it lacks here: ${row.effects_missing}`) : null,
      command ? el("pre", {}, command) : null);
  }));
}

export async function comparePage(page, view) {
  const chosen = chosenOf(view);
  const here = {page: "compare", scene: chosen.scene.id, frame: chosen.frame};
  const again = (changes) => go({...state(), ...here, a: chosen.a, b: chosen.b, pixel: "", ...changes});
  const sideChoices = chosen.sides.map((side) => [side, side]);
  const place = el("div", {class: "soft"}, "Reading the images…");
  let shown = null;
  const detail = (key, value, plain) => { keep({[key]: value === plain ? "" : value}); shown?.update({[key]: value}); };
  const classes = run.class_colours.map(({name}) => name);
  fill(page,
    el("div", {class: "row spread"}, el("h1", {}, el("a", {href: linkTo({page: "scene", scene: chosen.scene.id})}, chosen.scene.id),
      chosen.scene.frames.length > 1 ? `, frame ${chosen.frame}` : ""),
      el("span", {class: "row"},
        dropDown("Scene", scenes.map(({id}) => [id, id]), chosen.scene.id, (scene) => again({scene, frame: "", zoom: "", x: "", y: ""})),
        chosen.scene.frames.length > 1 ?
          dropDown("Frame", chosen.scene.frames.map((f) => [String(f), String(f)]), String(chosen.frame), (frame) => again({frame})) : null)),
    el("div", {class: "card"},
      el("div", {class: "row"}, dropDown("A", sideChoices, chosen.a, (a) => again({a})),
        el("button", {type: "button", "aria-label": "Exchange A and B", onclick: () => again({a: chosen.b, b: chosen.a})}, "⇄"),
        dropDown("B", sideChoices, chosen.b, (b) => again({b}))),
      el("div", {class: "row compare-tools"},
        choice("Layout", layouts, chosen.layout, (layout) => detail("layout", layout, "slider")),
        choice("Look", looks, chosen.look, (look) => detail("look", look, "shaded")),
        dropDown("Only", [["", "all pixels"], ...classes.map((name) => [name, name])], chosen.mask, (mask) => detail("mask", mask, ""))),
      place),
    commandCard(chosen));
  if (!frameSize(chosen.scene, chosen.frame)) return fill(place, "The run has no images of this frame.");
  const truth = await truthOf(chosen.scene, chosen.frame);
  const images = new Map();
  for (const side of new Set([chosen.a, chosen.b]))
    if (side !== kReference)
      images.set(side, await visibilityOfRow(rowOf(chosen.scene.id, chosen.frame, side), truth.width));
  shown = stage(chosen, truth, images, view);
  place.replaceWith(shown.box);
  return shown.update({});
}
