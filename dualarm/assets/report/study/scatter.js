// One axis across, one up, a point for each run; what is no success is a cross.

function createScatter(canvas, choose) {
  const MARGIN = { left: 76, right: 18, top: 26, bottom: 44 };
  const NEAR = 12;
  let points = [];

  function draw(rows) {
    const { context, width, height } = prepare(canvas);
    const [w, h] = [width - MARGIN.left - MARGIN.right, height - MARGIN.top - MARGIN.bottom];
    const across = (place) => MARGIN.left + place * w;
    const up = (place) => MARGIN.top + (1 - place / 1.06) * h;
    grid(context, across, up);
    points = rows.map((row) => ({ row, x: across(Math.min(view.x.at(row), 1.02)), y: up(view.y.at(row)) }));
    context.globalAlpha = rows.length > 3000 ? 0.45 : 0.75;
    const radius = rows.length > 1000 ? 1.5 : 2.5;
    for (const { row, x, y } of points) {
      context.fillStyle = context.strokeStyle = colourOf(row);
      if (succeeded(row)) {
        context.fillRect(x - radius, y - radius, 2 * radius, 2 * radius);
      } else {
        context.beginPath();
        context.moveTo(x - 3, y - 3);
        context.lineTo(x + 3, y + 3);
        context.moveTo(x - 3, y + 3);
        context.lineTo(x + 3, y - 3);
        context.stroke();
      }
    }
    context.globalAlpha = 1;
    const chosen = points.find(({ row }) => row === view.chosen);
    canvas.dataset.chosen = chosen ? `${chosen.x} ${chosen.y}` : "";
    if (chosen) {
      context.strokeStyle = colour("--ink");
      context.lineWidth = 2;
      context.beginPath();
      context.arc(chosen.x, chosen.y, 7, 0, 2 * Math.PI);
      context.stroke();
    }
  }

  function grid(context, across, up) {
    context.strokeStyle = colour("--grid");
    context.fillStyle = colour("--soft");
    const line = (from, to) => {
      context.beginPath();
      context.moveTo(...from);
      context.lineTo(...to);
      context.stroke();
    };
    let free = -Infinity;
    for (const value of ticks(view.x)) {
      const x = across(view.x.place(value));
      line([x, up(0)], [x, up(1.06)]);
      const text = caption(view.x, value);
      const half = context.measureText(text).width / 2;
      // Texts do not touch: the next one is left out then.
      if (x - half < free) continue;
      free = x + half + 8;
      context.textAlign = "center";
      context.fillText(text, x, up(0) + 16);
    }
    for (const value of ticks(view.y)) {
      const y = up(view.y.place(value));
      line([across(0), y], [across(1), y]);
      context.textAlign = "right";
      context.fillText(caption(view.y, value), across(0) - 6, y + 4);
    }
    context.fillStyle = colour("--ink");
    context.textAlign = "center";
    context.fillText(view.x.label, across(0.5), up(0) + 36);
    context.textAlign = "left";
    context.fillText(view.y.label, 8, 16);
  }

  canvas.addEventListener("click", ({ offsetX, offsetY }) => {
    let [best, distance] = [null, NEAR * NEAR];
    for (const { row, x, y } of points) {
      const square = (x - offsetX) ** 2 + (y - offsetY) ** 2;
      if (square <= distance) [best, distance] = [row, square];
    }
    choose(best);
  });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step || points.length === 0) return;
    event.preventDefault();
    const order = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
    const present = order.findIndex(({ row }) => row === view.chosen);
    choose(order[present < 0 ? 0 : (present + step + order.length) % order.length].row);
  });
  return draw;
}

/** How an axis writes one of its values. */
function caption(axis, value) {
  return axis.texts ? (axis.texts[Math.round(value)] ?? "") : format(value);
}
