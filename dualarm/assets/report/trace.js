// A curve as the eye can tell it apart: lines, and bands where it swings faster than the screen can show.

/** Width in px in which a swing and back is too fast to be seen. */
const BIN = 4;
/** Smaller swings in px are no thicker than the line. */
const SMALLEST = 3;

/**
 * Lines `[[x, y], …]` and bands `{ upper, lower }` in px of the rows from `first` to `last`. `toX` and `toY` give px; `size` is
 * how many of them are one px of the screen.
 */
function trace(xs, ys, first, last, toX, toY, size = 1) {
  const pieces = { lines: [], bands: [] };
  let from = first;
  for (let row = first; row <= last + 1; row++) {
    if (row <= last && ys[row] !== null && Number.isFinite(ys[row])) continue;
    if (row > from) traceWhole(pieces, binned(xs, ys, from, row - 1, toX, toY, size), size);
    from = row + 1;
  }
  return pieces;
}

/** Points of rows without a gap, in bins of a few px. */
function binned(xs, ys, first, last, toX, toY, size) {
  const bins = [];
  let bin = null;
  let extreme = toY(ys[first]);
  let direction = 0;
  for (let row = first; row <= last; row++) {
    const [x, y] = [toX(xs[row]), toY(ys[row])];
    const place = Math.floor(x / (BIN * size));
    if (bin === null || bin.place !== place) {
      bin = { place, points: [], low: y, high: y, turns: 0, fast: false };
      bins.push(bin);
    }
    bin.points.push([x, y]);
    bin.low = Math.min(bin.low, y);
    bin.high = Math.max(bin.high, y);
    // A turn is one only if the curve has left its extreme by a px.
    if (direction === 0 ? Math.abs(y - extreme) > size : direction * (y - extreme) < -size) {
      if (direction !== 0) bin.turns += 1;
      direction = Math.sign(y - extreme);
      extreme = y;
    } else if (direction * (y - extreme) > 0) extreme = y;
  }
  return bins;
}

function traceWhole(pieces, bins, size) {
  const isFast = bins.map((bin) => bin.turns >= 2 && bin.high - bin.low > SMALLEST * size);
  const near = (at) => isFast[at - 1] || isFast[at + 1];
  const both = (at) => isFast[at - 1] && isFast[at + 1];
  bins.forEach((bin, at) => (bin.fast = isFast[at] ? near(at) : both(at)));
  for (let at = 0; at < bins.length; ) {
    let end = at + 1;
    while (end < bins.length && bins[end].fast === bins[at].fast) end++;
    const part = bins.slice(at, end);
    if (bins[at].fast) {
      pieces.bands.push(band(part));
    } else {
      const before = at > 0 ? [bins[at - 1].points.at(-1)] : [];
      const after = end < bins.length ? [bins[end].points[0]] : [];
      pieces.lines.push([...before, ...part.flatMap((bin) => thinned(bin.points, size)), ...after]);
    }
    at = end;
  }
}

/** Both edges of what swings. */
function band(bins) {
  const edge = (side) => {
    const middle = bins.map((bin) => [(bin.points[0][0] + bin.points.at(-1)[0]) / 2, bin[side]]);
    return [[bins[0].points[0][0], bins[0][side]], ...middle, [bins.at(-1).points.at(-1)[0], bins.at(-1)[side]]];
  };
  return { upper: edge("low"), lower: edge("high") };
}

/** Of the points within a px the first, the extremes and the last. */
function thinned(points, size) {
  if (points.length < 4 * BIN) return points;
  const kept = [];
  for (let at = 0; at < points.length; ) {
    const column = Math.floor(points[at][0] / size);
    let end = at;
    let [low, high] = [at, at];
    while (end < points.length && Math.floor(points[end][0] / size) === column) {
      if (points[end][1] < points[low][1]) low = end;
      if (points[end][1] > points[high][1]) high = end;
      end++;
    }
    const wanted = [...new Set([at, low, high, end - 1])].sort((a, b) => a - b);
    kept.push(...wanted.map((index) => points[index]));
    at = end;
  }
  return kept;
}

/** Draws a curve on uPlot's canvas: the lines and the edges of bands, and what is between these. */
function tracePaths(plot, index, first, last) {
  const toX = (value) => plot.valToPos(value, "x", true);
  const toY = (value) => plot.valToPos(value, "y", true);
  const pieces = trace(plot.data[0], plot.data[index], first, last, toX, toY, devicePixelRatio);
  const [stroke, fill] = [new Path2D(), new Path2D()];
  const along = (path, points, isNew) => {
    points.forEach(([x, y], at) => (at === 0 && isNew ? path.moveTo(x, y) : path.lineTo(x, y)));
  };
  for (const points of pieces.lines) along(stroke, points, true);
  for (const { upper, lower } of pieces.bands) {
    along(stroke, upper, true);
    along(stroke, lower, true);
    along(fill, upper, true);
    along(fill, lower.toReversed(), false);
    fill.closePath();
  }
  return { stroke, fill, clip: null, band: null, gaps: null, flags: 3 };
}
