// How a chart looks: axes, ranges, curves and target, as uPlot wants them said.

const HEIGHT = 210;
/** How long the kick lasts that PD and PDS begin with, in s; a longer span leaves it out of the vertical axis. */
const KICK = 0.02;
const LONG_SPAN = 0.2;
const DASHES = [6, 4];
/** How far the axis follows commands beyond what actuators deliver, in parts of what they deliver in the whole run. */
const COMMANDS = 0.25;

/** `chart` says what is drawn, `curves` and `targets` are its columns. */
function options(chart, curves, targets, data, clock, frame) {
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
      y: { range: () => verticalRange(chart, curves, targets, data.times, clock.view) },
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
        size: (plot, values) => Math.max(54, 14 + 7 * Math.max(0, ...(values ?? []).map((text) => text.length))),
        gap: 4,
        values: (plot, splits, index, space, step) => splits.map((value) => tick(value, step)),
      },
    ],
    series: [{}, ...curves.map(curveStyle)],
    hooks: {
      drawAxes: [(plot) => targets.forEach((values) => drawTarget(plot, values, chart.band))],
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
  const values = `between ${format(y.min, digits)} and ${format(y.max, digits)} ${chart.unit ?? ""}`;
  return `${chart.title} ${time}, ${values}: ${runs.map((run) => run.title).join(", ")}`;
}

function curveStyle({ run, dashed }) {
  return {
    label: run.title,
    stroke: () => colour(`--run-${run.index}`),
    fill: () => see(colour(`--run-${run.index}`)),
    width: dashed ? 1.2 : 1.6,
    dash: dashed ? DASHES : undefined,
    pxAlign: 0,
    points: { show: false },
    paths: tracePaths,
  };
}

/** A colour that lets others through. */
function see(opaque) {
  return opaque.replace("rgb(", "rgba(").replace(")", ", 0.28)");
}

/** The times of ticks with their unit. */
function timeTicks(splits, step, { from, to }) {
  const [factor, unit] = to - from < 0.2 ? [1000, "ms"] : [1, "s"];
  return splits.map((time) => `${format(factor * time, decimals(factor * step))} ${unit}`);
}

/** A value beside its axis: with a power of ten where it has too many zeros. */
function tick(value, step) {
  const size = Math.max(Math.abs(value), step);
  if (size < 1e6 && step >= 0.9e-5) return format(value, decimals(step));
  return value === 0 ? "0" : value.toExponential(Math.max(0, Math.floor(Math.log10(Math.abs(value) / step) + 1e-6))).replaceAll("-", "−");
}

/** Digits after the point that ticks with this distance need: none is cut off, as 0.25 would be with one. */
function decimals(step) {
  for (let digits = 0; digits < 9; digits++) {
    const scaled = step * 10 ** digits;
    if (scaled >= 1 - 1e-9 && Math.abs(scaled - Math.round(scaled)) < 1e-6 * scaled) return digits;
  }
  return 9;
}

/** What the curves in view reach, commands and the target if they are near, and a little air. */
function verticalRange(chart, curves, targets, times, { from, to }) {
  const isLong = chart.kick && to - from > LONG_SPAN && from < times[0] + KICK;
  const first = locate(times, isLong ? times[0] + KICK : from).row;
  const last = locate(times, to).row + 1;
  const shown = curves.filter(({ run }) => !run.hidden);
  // Commands can be far beyond what any actuator delivers, and would make a line of that.
  const isCommand = ({ dashed }) => Boolean(chart.commands) && dashed;
  const delivered = shown.filter((curve) => !isCommand(curve));
  let [low, high] = reach(delivered, first, last);
  const [lowest, highest] = reach(shown.filter(isCommand), first, last);
  // The whole run, and not what is in view: a dead zone stays in the picture where what is delivered hardly changes.
  const [bottom, top] = reach(delivered, 0, times.length);
  const more = COMMANDS * (Math.max(top, 0) - Math.min(bottom, 0));
  const [least, most] = more > 0 && more < Infinity ? [low - more, high + more] : [-Infinity, Infinity];
  low = Math.min(low, Math.max(lowest, least));
  high = Math.max(high, Math.min(highest, most));
  if (!(low <= high && high - low < Infinity)) return [-1, 1];
  for (const values of targets) {
    // The target belongs into the picture until one looks closer than the curves are to it.
    const target = values[Math.min(last, values.length - 1)];
    if (Math.max(Math.abs(target - low), Math.abs(target - high)) < 3 * (high - low)) {
      low = Math.min(low, target);
      high = Math.max(high, target);
    }
  }
  // Ticks have to be different numbers, however little of a large value changes.
  const size = Math.max(Math.abs(low), Math.abs(high));
  const air = high > low ? Math.max(0.07 * (high - low), 1e-12 * size) : Math.max(0.1 * size, 1e-6);
  return [low - air, high + air];
}

/** The smallest and the largest value of curves between two rows. */
function reach(curves, first, last) {
  let [low, high] = [Infinity, -Infinity];
  for (const { values } of curves) {
    for (let row = first; row <= last && row < values.length; row++) {
      if (values[row] < low) low = values[row];
      if (values[row] > high) high = values[row];
    }
  }
  return [low, high];
}

/** Where a target is, as few points as its shape needs. */
function corners(times, values) {
  const kept = [];
  values.forEach((value, row) => {
    if (Number.isFinite(value) && (value !== values[row - 1] || value !== values[row + 1])) kept.push([times[row], value]);
  });
  return kept;
}

function drawTarget(plot, values, band) {
  const { ctx } = plot;
  const { left, top, width, height } = plot.bbox;
  const points = corners(plot.data[0], values);
  const along = (factor) => points.map(([time, value]) => [plot.valToPos(time, "x", true), plot.valToPos(value * factor, "y", true)]);
  const draw = (path) => path.forEach(([x, y]) => ctx.lineTo(x, y));
  ctx.save();
  ctx.beginPath();
  ctx.rect(left, top, width, height);
  ctx.clip();
  if (band) {
    ctx.fillStyle = colour("--band");
    ctx.beginPath();
    draw(along(1 + band));
    draw(along(1 - band).toReversed());
    ctx.fill();
  }
  ctx.strokeStyle = colour("--soft");
  ctx.lineWidth = devicePixelRatio;
  ctx.setLineDash([5 * devicePixelRatio, 4 * devicePixelRatio]);
  ctx.beginPath();
  draw(along(1));
  ctx.stroke();
  ctx.restore();
}
