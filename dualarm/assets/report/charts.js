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

  const columns = data.runs.map((run) =>
    (run.signals.get(signal) ?? new Float64Array(data.times.length)).map((value) => value * scale),
  );
  const target = chart.target && data.runs[0].signals.get(chart.target)?.at(-1) * scale;
  const plot = new uPlot(
    options(chart, target, columns, data, clock, frame),
    [data.times, ...columns.toReversed()],
    frame,
  );
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
