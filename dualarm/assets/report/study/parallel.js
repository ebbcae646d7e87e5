// Parallel coordinates: an axis for each parameter and the chosen figure, a line for each run.

function createParallel(canvas, choose, changed) {
  const MARGIN = { left: 34, right: 34, top: 66, bottom: 38 };
  const NEAR = 6;
  let [shownAxes, rows] = [[], []];
  let [across, up, placeAt] = [];
  let drag = null;

  function draw(shown) {
    rows = shown;
    shownAxes = [...axes.filter(({ role }) => role === "parameter"), view.y];
    // On a narrow screen the axes keep their distance, and the plot is moved sideways.
    canvas.style.setProperty("--axes", shownAxes.length);
    const { context, width, height } = prepare(canvas);
    const [w, h] = [width - MARGIN.left - MARGIN.right, height - MARGIN.top - MARGIN.bottom];
    across = (index) => MARGIN.left + (shownAxes.length > 1 ? index / (shownAxes.length - 1) : 0.5) * w;
    up = (place) => MARGIN.top + (1 - place / 1.06) * h;
    placeAt = (y) => 1.06 * (1 - (y - MARGIN.top) / h);
    context.globalAlpha = Math.min(0.6, Math.max(0.03, 60 / Math.max(rows.length, 1)));
    for (const row of rows) line(context, row, colourOf(row), 1);
    context.globalAlpha = 1;
    if (view.chosen !== null) line(context, view.chosen, colour("--ink"), 2.5);
    shownAxes.forEach((axis, index) => drawAxis(context, axis, index));
  }

  function line(context, row, style, width) {
    context.strokeStyle = style;
    context.lineWidth = width;
    context.beginPath();
    shownAxes.forEach((axis, index) => context.lineTo(across(index), up(axis.at(row))));
    context.stroke();
  }

  function drawAxis(context, axis, index) {
    const x = across(index);
    context.strokeStyle = colour("--soft");
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(x, up(0));
    context.lineTo(x, up(1.06));
    context.stroke();
    const kept = view.kept.get(axis.name);
    if (kept) {
      context.fillStyle = colour("--focus");
      context.globalAlpha = 0.4;
      context.fillRect(x - 5, up(kept[1]), 10, up(kept[0]) - up(kept[1]));
      context.globalAlpha = 1;
    }
    context.fillStyle = colour("--ink");
    context.textAlign = index === 0 ? "left" : index === shownAxes.length - 1 ? "right" : "center";
    // At the edges names lean inwards, as far as the margin lets them.
    const edge = { left: x - MARGIN.left + 4, right: x + MARGIN.right - 4, center: x }[context.textAlign];
    // Neighbours' texts do not touch: those of every other axis stand farther out, and all are cut at the next but one.
    const room = shownAxes.length > 2 ? 2 * (across(1) - across(0)) - 8 : Infinity;
    const write = (text, y) => context.fillText(fitted(context, text, room), edge, y);
    const ends = [0, 1].map((place) => (axis.texts ? caption(axis, axis.value(place)) : brief(axis.value(place))));
    const [above, below] = index % 2 ? [28, 30] : [MARGIN.top - 8, 16];
    write(axis.name, above - 14);
    context.fillStyle = colour("--soft");
    write(ends[1], above);
    write(ends[0], up(0) + below);
  }

  /** The axis under the pointer, if there is one. */
  function axisAt(x) {
    const index = shownAxes.findIndex((_, at) => Math.abs(across(at) - x) < 9);
    return index < 0 ? null : shownAxes[index];
  }

  canvas.addEventListener("pointerdown", (event) => {
    const axis = axisAt(event.offsetX);
    if (!axis) return;
    canvas.setPointerCapture(event.pointerId);
    drag = { axis, from: placeAt(event.offsetY), moved: false };
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!drag) return;
    const to = placeAt(event.offsetY);
    if (Math.abs(to - drag.from) < 0.01 && !drag.moved) return;
    drag.moved = true;
    view.kept.set(drag.axis.name, [Math.min(drag.from, to), Math.max(drag.from, to)]);
    changed();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (!drag) {
      choose(nearest(event.offsetX, event.offsetY));
      return;
    }
    if (!drag.moved) {
      view.kept.delete(drag.axis.name);
      changed();
    }
    drag = null;
  });

  /** The run whose line passes closest. */
  function nearest(x, y) {
    const right = shownAxes.findIndex((_, index) => across(index) > x);
    if (right < 1) return null;
    const share = (x - across(right - 1)) / (across(right) - across(right - 1));
    let [best, distance] = [null, NEAR];
    for (const row of rows) {
      const [a, b] = [up(shownAxes[right - 1].at(row)), up(shownAxes[right].at(row))];
      const off = Math.abs(a + share * (b - a) - y);
      if (off <= distance) [best, distance] = [row, off];
    }
    return best;
  }
  return draw;
}

/** A text, cut if it is wider than there is room. */
function fitted(context, text, room) {
  if (context.measureText(text).width <= room) return text;
  let length = text.length;
  while (length > 1 && context.measureText(`${text.slice(0, length)}…`).width > room) length -= 1;
  return `${text.slice(0, length)}…`;
}
