// Which charts there are. `scale` turns a signal into the unit of its chart, `also` is a second signal in dashes,
// `commands` says that this is what a controller commands.

const DEGREES = 180 / Math.PI;

/** Charts of a grasp, in the order of the page. */
const GRASP = [
  { signal: "contact_force1", title: "Contact force f₁", unit: "N", decimals: 3, target: "lambda2_d", band: 0.02 },
  { signal: "contact_force2", title: "Contact force f₂", unit: "N", decimals: 3, target: "lambda2_d", band: 0.02 },
  { signal: "y_object", title: "Object position y", unit: "mm", decimals: 2, scale: 1000, target: "y_object_d" },
  { signal: "theta1", title: "Hub angle θ₁", unit: "°", decimals: 3, scale: DEGREES, target: "theta1_d" },
  { signal: "theta2", title: "Hub angle θ₂", unit: "°", decimals: 3, scale: DEGREES, target: "theta2_d" },
  { signal: "energy", title: "Energy of arms and object", unit: "mJ", decimals: 3, scale: 1000 },
  { signal: "tau1", title: "Torque τ₁", unit: "N·m", decimals: 3, kick: true, commands: true, also: "tau1_cmd" },
  { signal: "tau2", title: "Torque τ₂", unit: "N·m", decimals: 3, kick: true, commands: true, also: "tau2_cmd" },
  { signal: "u", title: "Force u at the object", unit: "N", decimals: 3, kick: true, commands: true, also: "u_cmd" },
];

/** Charts of contacts that can open; of tip 2 in dashes. */
const CONTACTS = [
  { signal: "gap1", title: "Gap at tip 1, and at tip 2 (dashed)", unit: "mm", decimals: 4, scale: 1000, also: "gap2" },
  { signal: "in_contact", title: "Both tips press", decimals: 0 },
  { signal: "impacts1", title: "Impacts of tip 1 so far, and of tip 2 (dashed)", decimals: 0, also: "impacts2" },
  {
    signal: "indentation1",
    title: "Indentation of the object at tip 1, and at tip 2 (dashed)",
    unit: "mm",
    decimals: 4,
    scale: 1000,
    also: "indentation2",
  },
  { signal: "impact_loss", title: "Energy lost in impacts and faces", unit: "mJ", decimals: 4, scale: 1000 },
];

/** Charts of what an adaptive controller learns. */
const ESTIMATES = [
  { signal: "m_hat", title: "Estimated mass m̂", unit: "kg", decimals: 4 },
  { signal: "J1_hat", title: "Estimated inertia Ĵ₁", unit: "kg·m²", decimals: 5 },
  { signal: "J2_hat", title: "Estimated inertia Ĵ₂", unit: "kg·m²", decimals: 5 },
  { signal: "epsilon_hat", title: "Estimated disturbance of the object ε̂", unit: "N", decimals: 4 },
  { signal: "pi1_hat", title: "Estimated disturbance of hub 1 π̂₁", unit: "N·m", decimals: 4 },
  { signal: "pi2_hat", title: "Estimated disturbance of hub 2 π̂₂", unit: "N·m", decimals: 4 },
  { signal: "W_norm", title: "Network of the object ‖Ŵ‖", decimals: 5 },
  { signal: "U1_norm", title: "Network of hub 1 ‖Û₁‖", decimals: 5 },
  { signal: "U2_norm", title: "Network of hub 2 ‖Û₂‖", decimals: 5 },
];

/** Charts of what `--monitor` records, as logarithms: exponentials are lines. */
const MONITORED = [
  { signal: "log10_lyapunov_H", title: "log₁₀ H, and of the bound it is proved to keep (dashed)", also: "log10_lyapunov_bound" },
  { signal: "log10_lyapunov_E", title: "log₁₀ of the arms’ part E" },
  { signal: "log10_lyapunov_V_o", title: "log₁₀ of the object’s part V₀" },
  { signal: "log10_lyapunov_V_I1", title: "log₁₀ of hub 1’s part" },
  { signal: "log10_lyapunov_V_I2", title: "log₁₀ of hub 2’s part" },
];

/** At most this many charts without being asked for, where no signal is known. */
const MOST_CHARTS = 9;

/** Groups of charts for what the runs have, and the signals that none of them shows. */
function catalogue(data) {
  const names = [...new Set(data.runs.flatMap((run) => [...run.signals.keys()]))];
  const has = ({ signal }) => names.includes(signal);
  const moves = ({ signal, also }) =>
    data.runs.some((run) => isMoving(run.signals.get(signal)) || isMoving(run.signals.get(also)));
  // Where no tip ever leaves the object, there is nothing to show of it.
  const opens = ["gap1", "gap2", "impacts1", "impacts2", "indentation1"].some((signal) => moves({ signal }));
  const groups = [
    { title: "", charts: GRASP.filter(has) },
    { title: "The contacts", open: true, charts: opens ? CONTACTS.filter((chart) => has(chart) && moves(chart)) : [] },
    { title: "What the certificate monitors", open: true, charts: MONITORED.filter(has) },
    { title: "What the controller estimates", charts: ESTIMATES.filter(has) },
  ].filter((group) => group.charts.length > 0);
  const isShown = (name) => groups.some(({ charts }) => charts.some(({ signal, also }) => signal === name || also === name));
  let others = names.filter((name) => !isShown(name));
  if (groups.length === 0) {
    const moving = others.filter((name) => data.runs.some((run) => isMoving(run.signals.get(name))));
    const first = (moving.length > 0 ? moving : others).slice(0, MOST_CHARTS);
    groups.push({ title: "", charts: first.map((name) => plainChart(data, name)) });
    others = others.filter((name) => !first.includes(name));
  }
  return { groups, others };
}

function isMoving(values) {
  return values !== undefined && values.some((value) => value !== values[0]);
}

/** A chart of a signal that is not known: under its name, in its own unit. */
function plainChart(data, name) {
  const unit = data.runs.map((run) => run.units.get(name)).find((known) => known);
  // The unit of a pure number is 1.
  return { signal: name, title: name, unit: unit === "1" ? undefined : unit?.replaceAll(".", "·") };
}
