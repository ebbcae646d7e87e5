// What the pictures need room for: all that a run draws at any of its times. In metres with y upwards.

/** Exaggerations to begin with, and how many times as high as without one a picture may be then. */
const EXAGGERATIONS = [10, 5, 2, 1];
const HIGHEST = 2;

/** Between what moves and the frame, as a share of an arm's length: lines have a width, and tips a radius. */
const EDGE = 0.04;

/** The frame of a run that hardly moves. */
function frameAtRest({ arm, object }) {
  // Hubs with the arcs of their torques, and the object's body.
  const body = 0.26 * object;
  const margin = Math.max(0.27 * arm, body);
  return { left: -Math.max(0.17 * arm, body), right: arm + Math.max(0.3 * arm, body), low: -margin, high: object + margin };
}

/** How much lower and higher than at rest the frames of these runs are at an exaggeration; all alike, to be compared. */
function createRoom(runs) {
  const reaches = runs.map(createReach);
  const known = new Map();
  return function room(exaggeration) {
    if (!known.has(exaggeration)) {
      const needs = runs.map(({ geometry }, index) => {
        const [rest, [low, high]] = [frameAtRest(geometry), reaches[index](exaggeration)];
        const edge = EDGE * geometry.arm;
        return { below: rest.low - low + edge, above: high - rest.high + edge };
      });
      const most = (side) => Math.max(0, ...needs.map((need) => need[side]));
      known.set(exaggeration, { below: most("below"), above: most("above") });
    }
    return known.get(exaggeration);
  };
}

/** The largest exaggeration that leaves the pictures large. */
function fittingExaggeration(runs, room) {
  const height = ({ geometry }, exaggeration) => {
    const [rest, { below, above }] = [frameAtRest(geometry), room(exaggeration)];
    return rest.high - rest.low + below + above;
  };
  const fits = (exaggeration) => runs.every((run) => height(run, exaggeration) <= HIGHEST * height(run, 1));
  return EXAGGERATIONS.find(fits);
}

/** From the lowest to the highest place of a run's lines over all of its times, as a function of the exaggeration. */
function createReach(run) {
  const { arm: length, object: width } = run.geometry;
  const unknown = new Float64Array(run.times.length).fill(NaN);
  const signal = (name) => run.signals.get(name) ?? unknown;
  const shift = signal("y_object").map((place) => place - width / 2);
  const targetShift = signal("y_object_d").map((place) => place - width / 2);
  const drive = signal("u");
  const arms = [1, 2].map((arm) => {
    const [angle, target, force] = ["theta#", "theta#_d", "contact_force#"].map((name) => signal(name.replace("#", arm)));
    const shapes = [...run.signals.keys()].filter((name) => name.startsWith(`deflection${arm}[`)).map(signal);
    const isKnown = shapes.length > 1;
    const ways = isKnown
      ? shapes.map((shape, at) => angle.map((turn, row) => (length * at * turn) / (shapes.length - 1) - shape[row]))
      : nodes(length).map((x) => angle.map((turn, row) => targetShape(length, turn, shift[row])(x)));
    const rest = nodes(length).map((x) => target.map((turn, row) => targetShape(length, turn, targetShift[row])(x)));
    return { base: (arm - 1) * width, side: arm === 1 ? -1 : 1, way: range(...ways, ...rest), tip: ways.at(-1), force };
  });
  const object = range(shift);

  return function reach(exaggeration) {
    const places = [exaggeration * object[0], width + exaggeration * object[1]];
    const pushed = shift.map((way, row) => width / 2 + exaggeration * way + arrowLength(drive[row], length));
    places.push(...range(pushed));
    for (const { base, side, way, tip, force } of arms) {
      places.push(base + exaggeration * way[0], base + exaggeration * way[1]);
      // Arrows of forces are outside of the object.
      const outside = (value) => side * (ARROW_GAP * width + Math.abs(arrowLength(value, length)));
      places.push(...range(tip.map((value, row) => base + exaggeration * value + outside(force[row]))));
    }
    return [Math.min(...places), Math.max(...places)];
  };
}

/** The smallest and the largest of many numbers and zero, without those that are none. */
function range(...lists) {
  let [low, high] = [0, 0];
  for (const values of lists) {
    for (const value of values) {
      if (value < low) low = value;
      else if (value > high) high = value;
    }
  }
  return [low, high];
}
