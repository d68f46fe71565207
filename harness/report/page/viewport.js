// Zoom and pan, locked together on all canvases that show the same pixels.

const kMostZoom = 64;

// `size` is the image's; `redraw` is called after every change, `settled` when the reader stops.
export function viewport(size, {redraw, settled, zoom = 1, x = size.width / 2, y = size.height / 2}) {
  const view = {zoom, x, y};
  let timer = 0;
  const changed = () => {
    view.zoom = Math.min(kMostZoom, Math.max(1, view.zoom));
    // The middle of what is seen stays on the image, and all of it is seen at zoom 1.
    const clamp = (value, length) => {
      const half = length / (2 * view.zoom);
      return Math.min(length - half, Math.max(half, value));
    };
    view.x = clamp(view.x, size.width);
    view.y = clamp(view.y, size.height);
    redraw();
    clearTimeout(timer);
    timer = setTimeout(settled, 250);
  };
  // Canvas pixels per image pixel.
  const scaleOf = (canvas) => (canvas.width / size.width) * view.zoom;
  const toImage = (canvas, event) => {
    const box = canvas.getBoundingClientRect();
    const scale = scaleOf(canvas) * (box.width / canvas.width);
    return {x: (event.clientX - box.left - box.width / 2) / scale + view.x,
            y: (event.clientY - box.top - box.height / 2) / scale + view.y};
  };
  const zoomAt = (factor, at = view) => {
    const zoom = Math.min(kMostZoom, Math.max(1, view.zoom * factor));
    const kept = view.zoom / zoom;
    view.x = at.x + (view.x - at.x) * kept;
    view.y = at.y + (view.y - at.y) * kept;
    view.zoom = zoom;
    changed();
  };

  // Draws `picture` as the view says, only where the canvas' x lies in [from, to).
  const draw = (canvas, picture, from = 0, to = canvas.width) => {
    const context = canvas.getContext("2d");
    const scale = scaleOf(canvas);
    context.save();
    context.beginPath();
    context.rect(from, 0, to - from, canvas.height);
    context.clip();
    // Single pixels are for who looks close.
    context.imageSmoothingEnabled = view.zoom < 3;
    context.imageSmoothingQuality = "high";
    context.setTransform(scale, 0, 0, scale, canvas.width / 2 - view.x * scale, canvas.height / 2 - view.y * scale);
    context.drawImage(picture, 0, 0);
    context.restore();
  };

  // Lets the reader move the view on `canvas`. `tapped(at)` is a click without a drag, `over(at)` a pointer.
  const listen = (canvas, {tapped, over}) => {
    const pointers = new Map();
    let moved = 0;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      zoomAt(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015)), toImage(canvas, event));
    }, {passive: false});
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      pointers.set(event.pointerId, event);
      moved = 0;
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return over(toImage(canvas, event));
      const from = toImage(canvas, before), to = toImage(canvas, event);
      moved += Math.abs(event.clientX - before.clientX) + Math.abs(event.clientY - before.clientY);
      const other = [...pointers.values()].find(({pointerId}) => pointerId !== event.pointerId);
      pointers.set(event.pointerId, event);
      if (other) {
        const distance = (a) => Math.hypot(a.clientX - other.clientX, a.clientY - other.clientY);
        return zoomAt(distance(event) / Math.max(1, distance(before)), toImage(canvas, other));
      }
      view.x += from.x - to.x;
      view.y += from.y - to.y;
      return changed();
    });
    const released = (event) => {
      if (pointers.delete(event.pointerId) && event.type === "pointerup" && moved < 5) tapped(toImage(canvas, event));
    };
    canvas.addEventListener("pointerup", released);
    canvas.addEventListener("pointercancel", released);
  };

  const show = ({x: column, y: row}) => {
    const half = {x: size.width / (2 * view.zoom), y: size.height / (2 * view.zoom)};
    if (Math.abs(column - view.x) <= half.x && Math.abs(row - view.y) <= half.y) return;
    view.x = column;
    view.y = row;
    changed();
  };
  return {view, draw, listen, zoomAt, changed, scaleOf, show};
}
