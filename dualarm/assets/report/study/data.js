// The rows of the study, which of them are shown, and which one is chosen.

const { command, columns } = JSON.parse(document.getElementById("data").textContent);
const count = columns[0].values.length;
const columnOf = (name) => columns.find((column) => column.name === name);

/** Colours there are; more controllers share them. */
const COLOURS = 8;

/** Columns that can be an axis: parameters and figures, texts by their order of appearance. */
const axes = columns.filter(({ role }) => role === "parameter" || role === "figure").map(createAxis);

function createAxis(column) {
  const texts = column.number ? null : [...new Set(column.values.map(String))];
  const numbers = texts ? column.values.map((value) => texts.indexOf(String(value))) : column.values;
  const known = numbers.filter((value) => value !== null);
  let [low, high] = known.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
  if (!(low <= high)) [low, high] = [0, 1];
  const sorted = Float64Array.from(known).sort();
  const middle = sorted[sorted.length >> 1] ?? low;
  // What was drawn by its logarithm is looked at by it, and so is what spans decades.
  const spansDecades = high / low > 30 && middle - low < 0.1 * (high - low);
  const logarithmic = !texts && low > 0 && (column.log || spansDecades);
  if (low === high) [low, high] = logarithmic ? [low / 2, low * 2] : [low - 0.5, high + 0.5];
  const scale = logarithmic ? Math.log : (value) => value;
  const [first, last] = [scale(low), scale(high)];
  return {
    ...column,
    texts,
    numbers,
    low,
    high,
    logarithmic,
    /** Where a value stands, from 0 to 1. */
    place: (value) => (scale(value) - first) / (last - first),
    /** Where a row stands, from 0 to 1; above 1 where it has no value. */
    at: (row) => (numbers[row] === null ? 1.06 : (scale(numbers[row]) - first) / (last - first)),
    /** The value at a place. */
    value: (place) => {
      const value = first + place * (last - first);
      return logarithmic ? Math.exp(value) : value;
    },
    label: column.unit ? `${column.name} [${column.unit}]` : column.name,
  };
}

const controllers = columnOf("controller") ? [...new Set(columnOf("controller").values)] : ["all runs"];
const groups = columnOf("controller")
  ? columnOf("controller").values.map((name) => controllers.indexOf(name))
  : new Array(count).fill(0);
const succeeded = (row) => (columnOf("success") ? columnOf("success").values[row] : columnOf("status").values[row] === "ok");

/** What the reader wants to see. */
const view = {
  x: null,
  y: null,
  hidden: new Set(),
  onlyFailures: false,
  /** Kept ranges of axes, by name: [from, to] in places. */
  kept: new Map(),
  chosen: null,
};

function isShown(row) {
  if (view.hidden.has(groups[row]) || (view.onlyFailures && succeeded(row))) return false;
  for (const [name, [from, to]] of view.kept) {
    const place = axes.find((axis) => axis.name === name).at(row);
    if (place < from || place > to) return false;
  }
  return true;
}

const shownRows = () => [...Array(count).keys()].filter(isShown);

/** A number for people. */
function format(value) {
  if (value === null) return "–";
  if (typeof value !== "number") return String(value);
  if (Number.isInteger(value) && Math.abs(value) < 1e9) return String(value);
  const size = Math.abs(value);
  return size >= 1e-3 && size < 1e5 ? String(Number(value.toPrecision(4))) : value.toExponential(2);
}

/** A number in three digits, for where there is little room. */
function brief(value) {
  const size = Math.abs(value);
  if (size === 0 || (size >= 1e-3 && size < 1e5)) return String(Number(value.toPrecision(3)));
  return value.toExponential(1).replace("e+", "e");
}

/** Values at which an axis has a line: round ones, and no more than fit; texts by their numbers. */
function ticks({ texts, low, high, logarithmic }) {
  const within = (values) => values.filter((value) => value >= low && value <= high);
  if (texts) {
    const stride = Math.ceil(texts.length / 8);
    return texts.map((_, index) => index).filter((index) => index % stride === 0);
  }
  if (logarithmic) {
    const decades = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++) decades.push(power);
    const every = (digits) => within(decades.flatMap((power) => digits.map((digit) => Number(`${digit}e${power}`))));
    const choices = [[1, 2, 5], [1, 3], [1]].map(every);
    const chosen = choices.find((values) => values.length <= 8) ?? choices[2];
    // Less than a decade may have none of these; there other round values do.
    if (chosen.length > 2) return chosen;
  }
  const least = (high - low) / 6;
  const decade = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].map((digit) => digit * decade).find((size) => size >= least);
  const values = [];
  for (let i = Math.ceil(low / step); i * step <= high; i++) values.push(Number((i * step).toPrecision(12)));
  return values;
}

/** Makes the canvas as fine as the screen and gives its context and size in CSS pixels. */
function prepare(canvas) {
  const { width, height } = canvas.getBoundingClientRect();
  const ratio = devicePixelRatio || 1;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "12px system-ui, sans-serif";
  return { context, width, height };
}

const colourOf = (row) => colour(`--run-${groups[row] % COLOURS}`);
