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
    for (const { row, x, y } of points) {
      context.fillStyle = context.strokeStyle = colourOf(row);
      if (succeeded(row)) {
        context.fillRect(x - 1.5, y - 1.5, 3, 3);
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
    for (const place of [0, 0.25, 0.5, 0.75, 1]) {
      context.beginPath();
      context.moveTo(across(0), up(place));
      context.lineTo(across(1), up(place));
      context.moveTo(across(place), up(0));
      context.lineTo(across(place), up(1.06));
      context.stroke();
      context.textAlign = place === 1 ? "right" : "center";
      context.fillText(tick(view.x, place), across(place) + (place === 1 ? MARGIN.right - 4 : 0), up(0) + 16);
      context.textAlign = "right";
      context.fillText(tick(view.y, place), across(0) - 6, up(place) + 4);
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

/** What stands at a place of an axis. */
function tick(axis, place) {
  const value = axis.value(place);
  return axis.texts ? (axis.texts[Math.round(value)] ?? "") : format(value);
}
