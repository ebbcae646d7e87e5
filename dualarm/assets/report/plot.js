// How a chart looks: axes, ranges, curves and target, as uPlot wants them said.

const HEIGHT = 210;
/** How long the kick lasts that PD and PDS begin with, in s; a longer span leaves it out of the vertical axis. */
const KICK = 0.02;
const LONG_SPAN = 0.2;

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
      {
        ...axis,
        space: 64,
        size: 24,
        gap: 4,
        values: (plot, splits, index, space, step) => timeTicks(splits, step, clock.view),
      },
      {
        ...axis,
        space: 32,
        size: 54,
        gap: 4,
        values: (plot, splits, index, space, step) => splits.map((value) => format(value, decimals(step))),
      },
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
  const digits = Math.min(Math.max(2 - Math.floor(Math.log10(y.max - y.min)), 0), 9);
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

/** Digits after the point that ticks with this distance need: none is cut off, as 0.25 would be with one. */
function decimals(step) {
  for (let digits = 0; digits < 9; digits++) {
    const scaled = step * 10 ** digits;
    if (scaled >= 1 - 1e-9 && Math.abs(scaled - Math.round(scaled)) < 1e-6 * scaled) return digits;
  }
  return 9;
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
