// Fingers on a chart: one moves through time, two zoom. Up and down still scrolls the page (touch-action: pan-y).

function bindTouch(plot, clock) {
  const { over } = plot;
  const fingers = new Map();
  let pinch = null;

  const positions = () => [...fingers.values()].map((x) => x - over.getBoundingClientRect().left);
  const share = (x) => x / over.clientWidth;

  over.addEventListener("pointerdown", (event) => {
    if (event.pointerType !== "touch") return;
    fingers.set(event.pointerId, event.clientX);
    if (fingers.size === 2) pinch = { times: positions().map((x) => plot.posToVal(x, "x")) };
  });
  over.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return;
    fingers.set(event.pointerId, event.clientX);
    if (fingers.size === 1 && pinch === null) clock.set(plot.posToVal(positions()[0], "x"));
    if (fingers.size === 2) follow(pinch.times, positions().map(share));
  });
  for (const name of ["pointerup", "pointercancel"]) {
    over.addEventListener(name, (event) => {
      fingers.delete(event.pointerId);
      if (fingers.size === 0) pinch = null;
    });
  }

  /** The span in which both times are again under their fingers. */
  function follow(times, shares) {
    const apart = shares[1] - shares[0];
    if (Math.abs(apart) < 0.02) return;
    const span = (times[1] - times[0]) / apart;
    if (!(span > 0)) return;
    const from = times[0] - shares[0] * span;
    clock.look(from, from + span);
  }
}
