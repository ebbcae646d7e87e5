// Puts the page together.

/** Signals whose values are below each picture. */
const VALUES = [
  { signal: "contact_force1", name: "f₁", unit: "N", decimals: 3 },
  { signal: "theta1", name: "θ₁", unit: "°", decimals: 2, scale: DEGREES },
  { signal: "tau1", name: "τ₁", unit: "N·m", decimals: 3 },
  { signal: "contact_force2", name: "f₂", unit: "N", decimals: 3 },
  { signal: "theta2", name: "θ₂", unit: "°", decimals: 2, scale: DEGREES },
  { signal: "tau2", name: "τ₂", unit: "N·m", decimals: 3 },
];

/** The panel of one run: title, state of the grasp, picture, values. */
function createPanel(parent, run, index, data) {
  const panel = document.createElement("article");
  panel.className = `run run-${index}`;
  panel.dataset.key = run.key;
  const header = document.createElement("header");
  const title = document.createElement("h3");
  title.textContent = run.title;
  const status = document.createElement("span");
  header.append(title, status);
  panel.append(header);
  parent.append(panel);
  const draw = createScene(panel, run, data);
  const list = document.createElement("dl");
  list.className = "values";
  const cells = VALUES.map(({ name }) => {
    const [pair, term, value] = ["div", "dt", "dd"].map((tag) => document.createElement(tag));
    term.textContent = name;
    pair.append(term, value);
    list.append(pair);
    return value;
  });
  panel.append(list);

  return (place, time, exaggeration) => {
    draw(place, exaggeration);
    VALUES.forEach(({ signal, unit, decimals, scale = 1 }, at) => {
      cells[at].textContent = `${format(sample(run, signal, place) * scale, decimals)} ${unit}`;
    });
    const { text, kind } = stateOfGrasp(run, place, time - data.times[0]);
    status.textContent = text;
    status.className = `status ${kind}`;
  };
}

/** What one would say about the grasp at this time. */
function stateOfGrasp(run, place, passed) {
  const pulling = [1, 2].filter((arm) => sample(run, `contact_force${arm}`, place) < -5e-4);
  if (pulling.length === 1) return { text: `arm ${pulling[0]} pulls: no real contact`, kind: "pulls" };
  if (pulling.length === 2) return { text: "both arms pull: no real contact", kind: "pulls" };
  if (run.settling === null) return { text: "does not settle", kind: "" };
  const settling = `${format(run.settling, 3)} s`;
  if (passed >= run.settling) return { text: `within ±2 % since ${settling}`, kind: "settled" };
  return { text: `within ±2 % at ${settling}`, kind: "" };
}

async function main() {
  const data = await readData(document.getElementById("data"));
  const { times, runs } = data;
  const clock = createClock(times[0], times.at(-1));
  const exaggeration = document.getElementById("exaggeration");
  const scenes = document.getElementById("scenes");
  const panels = runs.map((run, index) => createPanel(scenes, run, index, data));
  const drawPanels = () => {
    const place = locate(times, clock.shown);
    panels.forEach((draw) => draw(place, clock.shown, Number(exaggeration.value)));
  };
  clock.on("time", drawPanels);
  exaggeration.addEventListener("change", drawPanels);
  const charts = createCharts(document.getElementById("charts"), data, clock);
  createTheme(document.getElementById("theme"), charts.redraw);
  createControls(clock, data, charts);

  // Begin where there is something to see: when the first controller holds the object and the others are on their way.
  const settled = runs.map((run) => run.settling).filter((time) => time !== null);
  clock.look(times[0], times.at(-1));
  clock.set(times[0] + (settled.length > 0 ? Math.min(...settled) : 0));
  document.documentElement.dataset.ready = "true";
}

main().catch((error) => {
  const problem = document.getElementById("problem");
  problem.textContent = `The animation and the curves cannot be shown in this browser: ${error.message}. The tables below are complete.`;
  problem.hidden = false;
  throw error;
});
