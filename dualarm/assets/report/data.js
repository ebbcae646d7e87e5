// The runs of this page, and their signals at any time.

/** What is in the page: times in s, lengths in m, runs with their signals. */
async function readData(element) {
  const { time, arm, object, runs } = JSON.parse(element.textContent);
  const times = (await unpack(time)).get("time");
  const unpacked = await Promise.all(runs.map((run) => unpack(run.data)));
  return { times, arm, object, runs: runs.map((run, index) => ({ ...run, signals: unpacked[index] })) };
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

/** A signal between two rows, on the straight line; NaN if the run has no such signal. */
function sample(run, name, { row, share }) {
  const values = run.signals.get(name);
  if (!values) return NaN;
  return share === 0 ? values[row] : values[row] + share * (values[row + 1] - values[row]);
}

/** A number with a proper minus sign and no negative zero. */
function format(value, decimals) {
  if (!Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}
