// The charts of the page: uPlot draws, the clock says which span and which instant.

/** All charts in `parent`, in groups; of a folded group when it is unfolded. */
function createCharts(parent, data, clock) {
  const { groups, others } = catalogue(data);
  const charts = [];
  const add = (place, chart) => {
    const made = createChart(place, chart, data, clock);
    charts.push(made);
    made.point(clock.shown);
    return made;
  };
  for (const { title, open, charts: wanted } of groups) {
    const place = document.createElement("div");
    place.className = "charts";
    if (title === "") {
      parent.append(place);
      wanted.forEach((chart) => add(place, chart));
      continue;
    }
    const group = document.createElement("details");
    const summary = document.createElement("summary");
    summary.textContent = title;
    group.append(summary, place);
    parent.append(group);
    group.addEventListener("toggle", () => wanted.forEach((chart) => add(place, chart)), { once: true });
    group.open = Boolean(open);
  }
  offerOthers(parent, others, (name) => add(lastPlace(parent), plainChart(data, name)));
  clock.on("view", () => charts.forEach((chart) => chart.look()));
  clock.on("time", () => charts.forEach((chart) => chart.point(clock.shown)));
  addEventListener("beforeprint", () => charts.forEach((chart) => chart.print()));
  return {
    redraw: () => charts.forEach(({ plot }) => plot.redraw(false, true)),
    /** Shows or hides a run in all charts; true if it is now shown. */
    toggle(run) {
      run.hidden = !run.hidden;
      charts.forEach((chart) => chart.show(run));
      return !run.hidden;
    },
  };
}

/** Where charts go that the user adds. */
function lastPlace(parent) {
  const last = parent.querySelector(".charts.added");
  if (last) return last;
  const place = document.createElement("div");
  place.className = "charts added";
  parent.append(place);
  return place;
}

/** The list of signals that no chart shows yet. */
function offerOthers(parent, names, add) {
  const [label, select] = ["more", "signal"].map((id) => document.getElementById(id));
  label.hidden = names.length === 0;
  const option = (text, value) => select.append(new Option(text, value));
  option(`one of ${names.length}`, "");
  names.forEach((name) => option(name, name));
  select.addEventListener("change", () => {
    if (select.value === "") return;
    const added = add(select.value);
    select.selectedOptions[0].disabled = true;
    select.value = "";
    added.figure.scrollIntoView({ block: "nearest" });
  });
}

/** The columns of a chart, those of the first run last, on top of others that vibrate. */
function curvesOf(chart, data) {
  const { signal, also, scale = 1 } = chart;
  const curves = [];
  for (const run of data.runs.toReversed()) {
    if (!run.signals.has(signal)) continue;
    const values = aligned(run, signal, data.times, scale);
    if (also && run.signals.has(also)) {
      const commanded = aligned(run, also, data.times, scale);
      if (differ(values, commanded)) curves.push({ run, values: commanded, dashed: true });
    }
    curves.push({ run, values, dashed: false });
  }
  return curves;
}

/** Whether two columns are apart by more than the page's digits. */
function differ(a, b) {
  let largest = 0;
  for (const value of a) largest = Math.max(largest, Math.abs(value) || 0);
  return a.some((value, row) => Math.abs(value - b[row]) > 1e-4 * largest);
}

/** The targets of a chart, each once. */
function targetsOf({ target, scale = 1 }, data) {
  const targets = [];
  for (const run of data.runs.filter((run) => target && run.signals.has(target))) {
    const values = aligned(run, target, data.times, scale);
    const isSame = (known) => known.every((value, row) => !(Math.abs(value - values[row]) > 1e-6 * Math.abs(value)));
    const known = targets.find(isSame);
    // One of two runs with the same target may be longer.
    if (known) known.forEach((value, row) => Number.isNaN(value) && (known[row] = values[row]));
    else targets.push(values);
  }
  return targets;
}

function createChart(parent, chart, data, clock) {
  const { signal, scale = 1 } = chart;
  const figure = document.createElement("figure");
  figure.className = "chart";
  figure.dataset.signal = signal;
  const caption = document.createElement("figcaption");
  const title = document.createElement("strong");
  title.textContent = chart.unit ? `${chart.title} (${chart.unit})` : chart.title;
  const take = document.createElement("span");
  take.className = "take";
  caption.append(title, take);
  const values = data.runs.map((run) => {
    const label = document.createElement("span");
    const swatch = document.createElement("i");
    swatch.className = `swatch run-${run.index}`;
    const value = document.createElement("span");
    label.append(swatch, value);
    label.title = run.title;
    label.hidden = Boolean(run.hidden);
    caption.append(label);
    return { run, label, value };
  });
  const frame = document.createElement("div");
  frame.setAttribute("role", "img");
  const printed = document.createElement("div");
  printed.className = "printed";
  figure.append(caption, frame, printed);
  parent.append(figure);

  const curves = curvesOf(chart, data);
  const targets = targetsOf(chart, data);
  const columns = curves.map((curve) => withGaps(curve.values));
  const plot = new uPlot(options(chart, curves, targets, data, clock, frame), [data.times, ...columns], frame);
  curves.forEach(({ run }, at) => run.hidden && plot.setSeries(at + 1, { show: false }));
  const draw = () => drawChart(chart, curves, targets, data, clock.view);
  addTake(take, signal, chart.title, draw);
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

  return {
    figure,
    plot,
    look() {
      plot.setScale("x", { min: clock.view.from, max: clock.view.to });
    },
    point(time) {
      for (const { run, value } of values) {
        const now = sample(run, signal, time) * scale;
        value.textContent = chart.decimals === undefined ? short(now) : format(now, chart.decimals);
      }
      const { from, to } = clock.view;
      playhead.style.left = `${(100 * (clock.time - from)) / (to - from)}%`;
    },
    show(run) {
      values.find((one) => one.run === run).label.hidden = run.hidden;
      curves.forEach((curve, at) => curve.run === run && plot.setSeries(at + 1, { show: !run.hidden }));
    },
    print() {
      printed.innerHTML = draw();
    },
  };
}

/** uPlot leaves gaps where there is null. */
function withGaps(values) {
  return values.some(Number.isNaN) ? Array.from(values, (value) => (Number.isNaN(value) ? null : value)) : values;
}
