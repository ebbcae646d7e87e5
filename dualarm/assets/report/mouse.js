// A mouse on a chart.

/** Pointing shows that instant everywhere, a click keeps it; Ctrl and the wheel (or a pinch on a touchpad) zoom. */
function bindMouse(plot, clock) {
  const { over } = plot;
  const timeAt = (event) => plot.posToVal(event.clientX - over.getBoundingClientRect().left, "x");
  over.addEventListener("pointermove", (event) => {
    if (event.pointerType === "mouse") clock.hover(timeAt(event));
  });
  over.addEventListener("pointerleave", () => clock.hover(null));
  over.addEventListener("click", (event) => clock.set(timeAt(event)));
  over.addEventListener(
    "wheel",
    (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      clock.zoom(Math.exp(event.deltaY / 200), timeAt(event));
    },
    { passive: false },
  );
}
