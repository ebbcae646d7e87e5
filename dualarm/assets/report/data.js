// The runs of this page, and their signals at any time.

/** What is in the page: runs, each with times in s, signals and units, and all of their times. */
async function readData(element) {
  const { runs } = JSON.parse(element.textContent);
  const read = await Promise.all(runs.map(readRun));
  return { runs: read, times: united(read.map((run) => run.times)) };
}

async function readRun(run, index) {
  const signals = await unpack(run.data);
  const times = signals.get("time");
  signals.delete("time");
  const units = new Map(run.data.columns.map(({ name, unit }) => [name, unit]));
  return { ...run, index, times, signals, units, place: { time: NaN } };
}

/** Every time of any run, once. Runs on one grid, the usual case, share theirs. */
function united(lists) {
  const [first = new Float64Array(0), ...others] = lists;
  const isSame = (times) => times.length === first.length && times.every((time, row) => time === first[row]);
  if (others.every(isSame)) return first;
  const sorted = Float64Array.from(lists.flatMap((times) => [...times])).sort();
  const near = 1e-9 * (sorted.at(-1) - sorted[0]);
  return sorted.filter((time, row) => row === 0 || time - sorted[row - 1] > near);
}

/** The row at or before a time, and how far it is to the next one (0 to 1). */
function locate(times, time) {
  let low = 0;
  let high = times.length - 1;
  if (!(time > times[low])) return { row: low, share: 0 };
  if (time >= times[high]) return { row: high, share: 0 };
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  return { row: low, share: (time - times[low]) / (times[high] - times[low]) };
}

/** A signal at a time, between two rows on the straight line; NaN if the run has no such signal. */
function sample(run, name, time) {
  const values = run.signals.get(name);
  if (!values) return NaN;
  if (run.place.time !== time) run.place = { time, ...locate(run.times, time) };
  return between(values, run.place);
}

function between(values, { row, share }) {
  return share === 0 ? values[row] : values[row] + share * (values[row + 1] - values[row]);
}

/** A signal at each of the times, NaN before and after its run. */
function aligned(run, name, times, scale = 1) {
  const values = run.signals.get(name);
  if (run.times.length === times.length) return values.map((value) => value * scale);
  const [from, to] = [run.times[0], run.times.at(-1)];
  return times.map((time) => (time < from || time > to ? NaN : between(values, locate(run.times, time)) * scale));
}

/** A number with a proper minus sign and no negative zero. */
function format(value, decimals) {
  if (!Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

/** A number of any size in about five digits. */
function short(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-4 || size >= 1e6) ? value.toExponential(3) : String(Number(value.toPrecision(5)));
  return text.replaceAll("-", "−");
}
