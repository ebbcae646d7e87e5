// The grasp from above: hubs at the left, one object's width apart, arms to the right, the object between their tips.
// In metres with y upwards; the drawing is in mm with y downwards.

const MM = 1000;
/** Length in mm of the arrow of 1 N; the longest, and the way from a tip to its arrow, in lengths of an arm and of the object. */
const FORCE = 50;
const LONGEST_ARROW = 0.6;
const ARROW_GAP = 0.05;
/** Sweep of the arc of 1 N·m, and the largest, in degrees. */
const TORQUE = 400;
const LARGEST_SWEEP = 300;

/** The picture of one run in `parent`, in a frame with this room; `draw(time, exaggeration)` shows it as it is at a time. */
function createScene(parent, run, room) {
  const { arm: length, object: width } = run.geometry;
  const signals = [...run.signals.keys()];
  const shapes = [1, 2].map((arm) => signals.filter((name) => name.startsWith(`deflection${arm}[`)));
  const svg = element(parent, "svg", {
    class: "scene",
    role: "img",
    "aria-label": `Arms and object, ${run.title}`,
  });
  const arms = [0, 1].map((index) => createArm(svg, index, index * width, width));
  const object = element(svg, "g", {});
  element(object, "path", { class: "object", d: objectOutline(length, width) });
  const drive = element(svg, "path", { class: "drive" });
  arms.forEach((arm) => svg.append(arm.line, arm.tip, arm.force));

  const look = (exaggeration) => {
    const { left, right, low, high } = frameAtRest(run.geometry);
    const { below, above } = room(exaggeration);
    const box = [left, -high - above, right - left, high + above - low + below];
    svg.setAttribute("viewBox", box.map((value) => round(value * MM)).join(" "));
  };
  let looked = NaN;

  return function draw(time, exaggeration) {
    if (exaggeration !== looked) look((looked = exaggeration));
    const value = (name) => sample(run, name, time);
    // How far the object is from its place at rest; both tips move with it.
    const shift = value("y_object") - width / 2;
    const targetShift = value("y_object_d") - width / 2;
    object.setAttribute("transform", `translate(0 ${-shift * exaggeration * MM})`);
    const centre = width / 2 + shift * exaggeration;
    drive.setAttribute("d", arrow(length, centre, centre + arrowLength(value("u"), length)));
    arms.forEach((arm, index) => {
      const angle = value(`theta${index + 1}`);
      const points =
        shapes[index].length > 1
          ? shapes[index].map((name, at) => {
              const x = (length * at) / (shapes[index].length - 1);
              return { x, y: arm.base + exaggeration * (x * angle - value(name)) };
            })
          : // Without the arm's shape: as it would be at rest between its hub and the object.
            nodes(length).map((x) => ({ x, y: arm.base + exaggeration * targetShape(length, angle, shift)(x) }));
      const target = targetShape(length, value(`theta${index + 1}_d`), targetShift);
      arm.line.setAttribute("d", curve(points, exaggeration * angle));
      const rest = nodes(length).map((x) => ({ x, y: arm.base + exaggeration * target(x) }));
      const isKnown = Number.isFinite(rest.at(-1).y);
      arm.ghost.setAttribute("d", isKnown ? curve(rest, exaggeration * value(`theta${index + 1}_d`)) : "");
      arm.spoke.setAttribute("transform", `rotate(${(-Math.atan(exaggeration * angle) * 180) / Math.PI})`);
      arm.torque.setAttribute("d", arc(width * 0.2, value(`tau${index + 1}`)));
      const tip = points.at(-1);
      arm.tip.setAttribute("cx", tip.x * MM);
      arm.tip.setAttribute("cy", -tip.y * MM);
      drawForce(arm.force, arrowLength(value(`contact_force${index + 1}`), length), tip, index === 0 ? 1 : -1, width * ARROW_GAP);
    });
  };
}

/** Places along an arm. */
function nodes(length) {
  return Array.from({ length: 11 }, (_, at) => (length * at) / 10);
}

function createArm(svg, index, base, width) {
  const hub = element(svg, "g", { transform: `translate(0 ${-base * MM})` });
  const radius = 0.12 * width * MM;
  element(hub, "rect", {
    class: "mount",
    x: -1.25 * radius,
    y: -1.25 * radius,
    width: 2.5 * radius,
    height: 2.5 * radius,
    rx: 3,
  });
  element(hub, "circle", { class: "hub", r: radius });
  const spoke = element(hub, "g", {});
  element(spoke, "path", { class: "spoke", d: `M${-0.55 * radius} 0 H${0.55 * radius}` });
  const torque = element(hub, "path", { class: "drive" });
  const label = element(hub, "text", { x: 1.6 * radius, y: (index === 0 ? 1.7 : -1.3) * radius });
  label.textContent = `arm ${index + 1}`;
  return {
    base,
    spoke,
    torque,
    ghost: element(svg, "path", { class: "ghost" }),
    line: element(svg, "path", { class: "arm", "data-arm": index + 1 }),
    tip: element(svg, "circle", { class: "tip", "data-arm": index + 1, r: 0.03 * width * MM }),
    force: element(svg, "path", { class: "force", "data-arm": index + 1 }),
  };
}

function element(parent, name, attributes) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  parent.append(node);
  return node;
}

/** A body with a round pad at each face; the pads' outermost points, at x = l, are the faces that the tips touch. */
function objectOutline(length, width) {
  const [x, top] = [length * MM, -width * MM];
  const [half, pad, radius, edge] = [0.24, 0.18, 0.06, 0.05].map((share) => share * width * MM);
  const straight = pad - radius;
  return [
    `M${x - radius} ${-radius} A${radius} ${radius} 0 0 0 ${x + radius} ${-radius} v${-straight}`,
    `h${half - radius - edge} q${edge} 0 ${edge} ${-edge} V${top + pad + edge} q0 ${-edge} ${-edge} ${-edge}`,
    `H${x + radius} v${-straight} A${radius} ${radius} 0 0 0 ${x - radius} ${top + radius} v${straight}`,
    `h${-(half - radius - edge)} q${-edge} 0 ${-edge} ${edge} V${-pad - edge} q0 ${edge} ${edge} ${edge} H${x - radius} Z`,
  ].join(" ");
}

/** The arm at its static target (16): clamped at the hub's angle, bent by a force at the tip that is shifted by `shift`. */
function targetShape(length, angle, shift) {
  const bent = length * angle - shift;
  return (x) => x * angle - (bent * x * x * (3 * length - x)) / (2 * length ** 3);
}

/** A smooth curve through points that are equally far apart along x; its slope at the first one is known. */
function curve(points, firstSlope) {
  const step = points[1].x - points[0].x;
  const slope = points.map((point, at) => {
    if (at === 0) return firstSlope;
    const next = points[at + 1] ?? point;
    return (next.y - points[at - 1].y) / (next.x - points[at - 1].x);
  });
  const text = ({ x, y }) => `${round(x * MM)} ${round(-y * MM)}`;
  const handle = (at, sign) =>
    text({ x: points[at].x + (sign * step) / 3, y: points[at].y + (sign * step * slope[at]) / 3 });
  const pieces = points.slice(1).map((point, at) => `C${handle(at, 1)} ${handle(at + 1, -1)} ${text(point)}`);
  return `M${text(points[0])} ${pieces.join(" ")}`;
}

/** How long the arrow of a force is, with its sign. */
function arrowLength(force, arm) {
  return Math.sign(force) * Math.min((Math.abs(force) * FORCE) / MM, LONGEST_ARROW * arm);
}

/** The force on the object at a tip: towards the object if it pushes, away from it if it pulls. */
function drawForce(path, size, tip, towards, gap) {
  const near = tip.y - towards * gap;
  const far = near - towards * Math.abs(size);
  path.setAttribute("d", size < 0 ? arrow(tip.x, near, far) : arrow(tip.x, far, near));
  path.classList.toggle("pulls", size < 0);
}

/** An arrow along y; nothing if it would be too short to see. */
function arrow(x, from, to) {
  const size = (to - from) * MM;
  if (!(Math.abs(size) > 1)) return "";
  const head = Math.sign(size) * Math.min(4.5, 0.6 * Math.abs(size));
  const [middle, end] = [round(x * MM), round(-to * MM)];
  return `M${middle} ${round(-from * MM)} V${end} m${-Math.abs(head) * 0.7} ${head} L${middle} ${end} l${Math.abs(head) * 0.7} ${head}`;
}

/** An arc around a hub's back, counterclockwise for a positive torque. */
function arc(radius, torque) {
  const sweep = Math.sign(torque) * Math.min(Math.abs(torque) * TORQUE, LARGEST_SWEEP);
  if (!(Math.abs(sweep) > 3)) return "";
  const r = radius * MM;
  const at = (degrees, factor = 1) => {
    const angle = (degrees * Math.PI) / 180;
    return `${round(r * factor * Math.cos(angle))} ${round(-r * factor * Math.sin(angle))}`;
  };
  // Centred on the side that the arm leaves free.
  const [from, to] = [180 - sweep / 2, 180 + sweep / 2];
  const back = to - Math.sign(sweep) * Math.min(16, Math.abs(sweep));
  const large = Math.abs(sweep) > 180 ? 1 : 0;
  const side = sweep > 0 ? 0 : 1;
  return `M${at(from)} A${r} ${r} 0 ${large} ${side} ${at(to)} M${at(back, 0.86)} L${at(to)} L${at(back, 1.14)}`;
}

function round(value) {
  return Math.round(value * 1000) / 1000;
}
