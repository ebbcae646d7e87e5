// One chart per signal, one curve per run: uPlot draws, the clock says which span and which instant.

const DEGREES = 180 / Math.PI;
/** What is drawn, in the order of the page; `scale` turns the signal into its unit. */
const CHARTS = [
  { signal: "contact_force1", title: "Contact force f₁", unit: "N", decimals: 3, target: "lambda2_d", band: 0.02 },
  { signal: "contact_force2", title: "Contact force f₂", unit: "N", decimals: 3, target: "lambda2_d", band: 0.02 },
  { signal: "y_object", title: "Object position y", unit: "mm", decimals: 2, scale: 1000, target: "y_object_d" },
  { signal: "theta1", title: "Hub angle θ₁", unit: "°", decimals: 3, scale: DEGREES, target: "theta1_d" },
  { signal: "theta2", title: "Hub angle θ₂", unit: "°", decimals: 3, scale: DEGREES, target: "theta2_d" },
  { signal: "energy", title: "Energy of arms and object", unit: "mJ", decimals: 3, scale: 1000 },
  { signal: "tau1", title: "Torque τ₁", unit: "N·m", decimals: 3, kick: true },
  { signal: "tau2", title: "Torque τ₂", unit: "N·m", decimals: 3, kick: true },
  { signal: "u", title: "Force u at the object", unit: "N", decimals: 3, kick: true },
];
/** How long the kick lasts that PD and PDS begin with, in s; a longer span leaves it out of the vertical axis. */
const KICK = 0.02;
const LONG_SPAN = 0.2;
const HEIGHT = 210;

/** All charts in `parent`. */
function createCharts(parent, data, clock) {
  const visible = data.runs.map(() => true);
  const charts = CHARTS.filter(({ signal }) => data.runs.some((run) => run.signals.has(signal))).map((chart) =>
    createChart(parent, chart, data, clock),
  );
  clock.on("view", () => charts.forEach((chart) => chart.look()));
  clock.on("time", () => {
    const place = locate(data.times, clock.shown);
    charts.forEach((chart) => chart.point(place));
  });
  return {
    redraw: () => charts.forEach(({ plot }) => plot.redraw(false, true)),
    /** Shows or hides a run in all charts; true if it is now shown. */
    toggle(index) {
      visible[index] = !visible[index];
      charts.forEach((chart) => chart.show(index, visible[index]));
      return visible[index];
    },
  };
}

function createChart(parent, chart, data, clock) {
  const { signal, scale = 1 } = chart;
  const figure = document.createElement("figure");
  figure.className = "chart";
  figure.dataset.signal = signal;
  const caption = document.createElement("figcaption");
  const title = document.createElement("strong");
  title.textContent = `${chart.title} (${chart.unit})`;
  caption.append(title);
  const values = data.runs.map((run, index) => {
    const label = document.createElement("span");
    const swatch = document.createElement("i");
    swatch.className = `swatch run-${index}`;
    const value = document.createElement("span");
    label.append(swatch, value);
    label.title = run.title;
    caption.append(label);
    return { label, value };
  });
  const frame = document.createElement("div");
  frame.setAttribute("role", "img");
  figure.append(caption, frame);
  parent.append(figure);

  const columns = data.runs.map((run) => (run.signals.get(signal) ?? new Float64Array(data.times.length)).map((value) => value * scale));
  const target = chart.target && data.runs[0].signals.get(chart.target)?.at(-1) * scale;
  const plot = new uPlot(options(chart, target, columns, data, clock, frame), [data.times, ...columns.toReversed()], frame);
  const playhead = document.createElement("div");
  playhead.className = "playhead";
  plot.over.append(playhead);
  new ResizeObserver(() => {
    if (frame.clientWidth > 0 && frame.clientWidth !== plot.width) {
      plot.setSize({ width: frame.clientWidth, height: HEIGHT });
    }
  }).observe(frame);
  bindMouse(plot, clock);
  bindTouch(plot, clock);

  function movePlayhead() {
    const { from, to } = clock.view;
    playhead.hidden = !(clock.time >= from && clock.time <= to);
    playhead.style.left = `${(100 * (clock.time - from)) / (to - from)}%`;
  }
  return {
    plot,
    look() {
      plot.setScale("x", { min: clock.view.from, max: clock.view.to });
    },
    point(place) {
      data.runs.forEach((run, index) => {
        values[index].value.textContent = format(sample(run, signal, place) * scale, chart.decimals);
      });
      movePlayhead();
    },
    show(index, isShown) {
      values[index].label.hidden = !isShown;
      plot.setSeries(series(data.runs, index), { show: isShown });
    },
  };
}

function options(chart, target, columns, data, clock, frame) {
  const axis = {
    stroke: () => colour("--soft"),
    grid: { stroke: () => colour("--grid"), width: 1 },
    ticks: { show: false },
    font: "12px system-ui, sans-serif",
  };
  return {
    width: frame.clientWidth || 300,
    height: HEIGHT,
    legend: { show: false },
    cursor: {
      y: false,
      sync: { key: "time" },
      drag: { x: true, y: false, setScale: false, dist: 5 },
      points: { size: 7 },
      bind: { dblclick: () => () => clock.look(clock.start, clock.stop) },
    },
    scales: {
      x: { time: false, range: () => [clock.view.from, clock.view.to] },
      y: { range: (plot) => verticalRange(plot, chart, target, columns, data.times, clock.view) },
    },
    axes: [
      { ...axis, space: 64, size: 30, gap: 4, values: (plot, splits, index, space, step) => timeTicks(splits, step, clock.view) },
      { ...axis, space: 32, size: 54, gap: 4, values: (plot, splits, index, space, step) => splits.map((value) => format(value, decimals(step))) },
    ],
    series: [{}, ...data.runs.map((run, index) => curveStyle(run, index)).toReversed()],
    hooks: {
      drawAxes: [(plot) => drawTarget(plot, target, chart.band)],
      setSelect: [
        (plot) => {
          const { left, width } = plot.select;
          if (width > 0) {
            plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
            clock.look(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
          }
        },
      ],
      setScale: [(plot) => frame.setAttribute("aria-label", describe(plot, chart, data.runs))],
    },
  };
}

/** What a chart shows, for those who do not see it. */
function describe(plot, chart, runs) {
  const { x, y } = plot.scales;
  const digits = decimals((y.max - y.min) / 100);
  const time = `from ${format(x.min, 4)} to ${format(x.max, 4)} s`;
  const values = `between ${format(y.min, digits)} and ${format(y.max, digits)} ${chart.unit}`;
  return `${chart.title} ${time}, ${values}: ${runs.map((run) => run.title).join(", ")}`;
}

/** Which of uPlot's series belongs to a run: the first run is drawn last, on top of those that vibrate. */
function series(runs, index) {
  return runs.length - index;
}

function curveStyle(run, index) {
  return { label: run.title, stroke: () => colour(`--run-${index}`), width: 1.6, pxAlign: 0, points: { show: false } };
}

/** The times of ticks with their unit. */
function timeTicks(splits, step, { from, to }) {
  const [factor, unit] = to - from < 0.2 ? [1000, "ms"] : [1, "s"];
  return splits.map((time) => `${format(factor * time, decimals(factor * step))} ${unit}`);
}

/** Digits after the point that tell two ticks apart. */
function decimals(step) {
  return Math.min(Math.max(-Math.floor(Math.log10(step) + 1e-9), 0), 9);
}

/** What the curves in view reach, the target and zero if they are near, and a little air. */
function verticalRange(plot, chart, target, columns, times, { from, to }) {
  const isLong = chart.kick && to - from > LONG_SPAN && from < times[0] + KICK;
  const first = locate(times, isLong ? times[0] + KICK : from).row;
  const last = locate(times, to).row + 1;
  let low = Infinity;
  let high = -Infinity;
  columns.forEach((values, index) => {
    if (!plot.series[series(columns, index)].show) return;
    for (let row = first; row <= last && row < values.length; row++) {
      if (values[row] < low) low = values[row];
      if (values[row] > high) high = values[row];
    }
  });
  if (!(low <= high)) return [-1, 1];
  // The target belongs into the picture until one looks closer than the curves are to it.
  if (target !== undefined && Math.max(Math.abs(target - low), Math.abs(target - high)) < 3 * (high - low)) {
    low = Math.min(low, target);
    high = Math.max(high, target);
  }
  const air = high > low ? 0.07 * (high - low) : Math.max(0.1 * Math.abs(high), 1e-6);
  return [low - air, high + air];
}

function drawTarget(plot, target, band) {
  if (target === undefined) return;
  const { ctx } = plot;
  const { left, top, width, height } = plot.bbox;
  ctx.save();
  ctx.beginPath();
  ctx.rect(left, top, width, height);
  ctx.clip();
  const at = (value) => plot.valToPos(value, "y", true);
  if (band) {
    const [upper, lower] = [at(target + band * Math.abs(target)), at(target - band * Math.abs(target))];
    ctx.fillStyle = colour("--band");
    ctx.fillRect(left, upper, width, lower - upper);
  }
  ctx.strokeStyle = colour("--soft");
  ctx.lineWidth = devicePixelRatio;
  ctx.setLineDash([5 * devicePixelRatio, 4 * devicePixelRatio]);
  ctx.beginPath();
  ctx.moveTo(left, at(target));
  ctx.lineTo(left + width, at(target));
  ctx.stroke();
  ctx.restore();
}

/** Pointing shows that instant everywhere, a click keeps it; Ctrl and the wheel (or a pinch on a touchpad) zoom. */
function bindMouse(plot, clock) {
  const { over } = plot;
  const timeAt = (event) => plot.posToVal(event.clientX - over.getBoundingClientRect().left, "x");
  over.addEventListener("pointermove", (event) => {
    if (event.pointerType === "mouse") clock.hover(timeAt(event));
  });
  over.addEventListener("pointerleave", () => clock.hover(null));
  over.addEventListener("click", (event) => clock.set(timeAt(event)));
  over.addEventListener(
    "wheel",
    (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      clock.zoom(Math.exp(event.deltaY / 200), timeAt(event));
    },
    { passive: false },
  );
}
