// A chart as an SVG document of its own: to take away, and to print.

const PAPER = { width: 640, height: 360, left: 62, right: 14, top: 62, bottom: 34 };
let drawings = 0;

/** The chart as it is zoomed, in light colours. */
function drawChart(chart, curves, targets, data, view) {
  const { width, height, left, right, top, bottom } = PAPER;
  const [low, high] = verticalRange(chart, curves, targets, data.times, view);
  const toX = (time) => left + ((time - view.from) / (view.to - view.from)) * (width - left - right);
  const toY = (value) => height - bottom - ((value - low) / (high - low)) * (height - top - bottom);
  const clip = `plot-${++drawings}`;
  const [ink, soft, grid] = ["--ink", "--soft", "--grid"].map((name) => colour(name, "light"));
  const parts = [
    `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" width="${width}" height="${height}" role="img" font-family="Noto Sans, system-ui, sans-serif" font-size="12">`,
    `<title>${markup(chart.title)}</title><rect width="${width}" height="${height}" fill="#fff"/>`,
    `<clipPath id="${clip}"><rect x="${left}" y="${top}" width="${width - left - right}" height="${height - top - bottom}"/></clipPath>`,
    `<text x="14" y="22" font-size="14" font-weight="600" fill="${ink}">${markup(chart.unit ? `${chart.title} (${chart.unit})` : chart.title)}</text>`,
    legend(curves, ink),
  ];
  const valueStep = roundStep((high - low) / 6);
  for (const value of multiples(valueStep, low, high)) {
    parts.push(line([left, toY(value)], [width - right, toY(value)], grid));
    parts.push(`<text x="${left - 7}" y="${px(toY(value) + 4)}" text-anchor="end" fill="${soft}">${tick(value, valueStep)}</text>`);
  }
  const timeStep = roundStep((view.to - view.from) / 7);
  const times = multiples(timeStep, view.from, view.to);
  timeTicks(times, timeStep, view).forEach((text, at) => {
    const x = toX(times[at]);
    parts.push(line([x, top], [x, height - bottom], grid));
    parts.push(`<text x="${px(x)}" y="${height - bottom + 18}" text-anchor="middle" fill="${soft}">${text}</text>`);
  });
  parts.push(`<g clip-path="url(#${clip})" fill="none" stroke-linejoin="round">`);
  for (const values of targets) {
    const points = corners(data.times, values);
    const along = (factor) => points.map(([time, value]) => [toX(time), toY(value * factor)]);
    if (chart.band) {
      const area = [...along(1 + chart.band), ...along(1 - chart.band).toReversed()];
      parts.push(`<path d="${path(area)}Z" fill="${soft}" fill-opacity="0.14"/>`);
    }
    parts.push(`<path d="${path(along(1))}" stroke="${soft}" stroke-dasharray="5 4"/>`);
  }
  const first = Math.max(locate(data.times, view.from).row - 1, 0);
  const last = Math.min(locate(data.times, view.to).row + 1, data.times.length - 1);
  for (const { run, values, dashed } of curves) {
    if (run.hidden) continue;
    const stroke = `stroke="${colour(`--run-${run.index}`, "light")}" stroke-width="${dashed ? 1.2 : 1.6}"`;
    const { lines, bands } = trace(data.times, values, first, last, toX, toY);
    for (const { upper, lower } of bands) {
      const fill = colour(`--run-${run.index}`, "light");
      parts.push(`<path d="${path([...upper, ...lower.toReversed()])}Z" fill="${fill}" fill-opacity="0.28"/>`);
      parts.push(`<path d="${path(upper)}${path(lower)}" ${stroke}/>`);
    }
    const dash = dashed ? ' stroke-dasharray="6 4"' : "";
    for (const points of lines) parts.push(`<path d="${path(points)}" ${stroke}${dash}/>`);
  }
  return `${parts.join("\n")}\n</g></svg>\n`;
}

/** Every run once, in one line above the plot. */
function legend(curves, ink) {
  const entries = curves.toReversed().filter(({ run, dashed }) => !run.hidden && !dashed);
  let left = 14;
  return entries
    .map(({ run }) => {
      const [from, text] = [left, left + 25];
      left = text + 7 * run.title.length + 18;
      return `<path d="M${from} 41h18" stroke="${colour(`--run-${run.index}`, "light")}" stroke-width="2.4"/><text x="${text}" y="45" fill="${ink}">${markup(run.title)}</text>`;
    })
    .join("");
}

function path(points) {
  return points.map(([x, y], at) => `${at === 0 ? "M" : "L"}${px(x)} ${px(y)}`).join("");
}

function line([x1, y1], [x2, y2], stroke) {
  return `<path d="M${px(x1)} ${px(y1)}L${px(x2)} ${px(y2)}" stroke="${stroke}"/>`;
}

/** A tenth of a px is enough; far outside is far enough. */
function px(value) {
  return Math.round(Math.min(Math.max(value, -1e4), 1e4) * 10) / 10;
}

/** The next 1, 2 or 5 of a power of ten. */
function roundStep(wanted) {
  const power = 10 ** Math.floor(Math.log10(wanted));
  return [1, 2, 5, 10].find((factor) => factor * power >= wanted * (1 - 1e-9)) * power;
}

function multiples(step, low, high) {
  const found = [];
  for (let index = Math.ceil(low / step - 1e-9); index * step <= high + 1e-9 * step; index++) found.push(index * step);
  return found;
}

function markup(text) {
  return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll('"', "&quot;");
}
