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
function createPanel(parent, run, room) {
  const panel = document.createElement("article");
  panel.className = `run run-${run.index}`;
  panel.dataset.key = run.key;
  const header = document.createElement("header");
  const title = document.createElement("h3");
  title.textContent = run.title;
  const status = document.createElement("span");
  header.append(title, status);
  panel.append(header);
  parent.append(panel);
  const draw = createScene(panel, run, room);
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

  return (time, exaggeration) => {
    draw(time, exaggeration);
    VALUES.forEach(({ signal, unit, decimals, scale = 1 }, at) => {
      cells[at].textContent = `${format(sample(run, signal, time) * scale, decimals)} ${unit}`;
    });
    const { text, kind } = stateOfGrasp(run, time);
    status.textContent = text;
    status.className = `status ${kind}`;
  };
}

/** What one would say about the grasp at this time. */
function stateOfGrasp(run, time) {
  const pulling = [1, 2].filter((arm) => sample(run, `contact_force${arm}`, time) < -5e-4);
  if (pulling.length === 1) return { text: `arm ${pulling[0]} pulls: no real contact`, kind: "pulls" };
  if (pulling.length === 2) return { text: "both arms pull: no real contact", kind: "pulls" };
  const open = [1, 2].filter((arm) => sample(run, `gap${arm}`, time) > 1e-9);
  if (open.length === 1) return { text: `tip ${open[0]} does not touch the object`, kind: "pulls" };
  if (open.length === 2) return { text: "no tip touches the object", kind: "pulls" };
  if (!run.judged) return { text: "", kind: "" };
  if (run.settling === null) return { text: "does not settle", kind: "" };
  const settling = `${format(run.settling, 3)} s`;
  const since = run.since > run.times[0] ? `${settling} after the change at ${format(run.since, 3)} s` : settling;
  if (time >= run.since + run.settling) return { text: `within ±2 % since ${since}`, kind: "settled" };
  return { text: `within ±2 % at ${since}`, kind: "" };
}

async function main() {
  const data = await readData(document.getElementById("data"));
  const { times, runs } = data;
  createFigures();
  if (times.length === 0) {
    createTheme(document.getElementById("theme"), () => {});
    document.documentElement.dataset.ready = "true";
    return;
  }
  const clock = createClock(times[0], Math.max(times.at(-1), times[0] + SHORTEST_SPAN));
  const exaggeration = document.getElementById("exaggeration");
  const scenes = document.getElementById("scenes");
  const grasps = runs.filter((run) => run.geometry);
  const room = createRoom(grasps);
  if (exaggeration) exaggeration.value = fittingExaggeration(grasps, room);
  const panels = grasps.map((run) => createPanel(scenes, run, room));
  const drawPanels = () => panels.forEach((draw) => draw(clock.shown, Number(exaggeration.value)));
  clock.on("time", drawPanels);
  exaggeration?.addEventListener("change", drawPanels);
  const charts = createCharts(document.getElementById("charts"), data, clock);
  createTheme(document.getElementById("theme"), charts.redraw);
  createControls(clock, data, charts);
  createDownloads(data);

  // Begin where there is something to see: when the first controller holds the object and the others are on their way.
  const settled = runs.filter((run) => run.settling !== null).map((run) => run.since + run.settling);
  clock.look(times[0], times.at(-1));
  clock.set(settled.length > 0 ? Math.min(...settled) : times[0]);
  document.documentElement.dataset.ready = "true";
}

main().catch((error) => {
  const problem = document.getElementById("problem");
  problem.textContent = `The animation and the curves cannot be shown in this browser: ${error.message}. The tables below are complete.`;
  problem.hidden = false;
  throw error;
});
