// Buttons, sliders and keys: they change the clock and show it.

function createControls(clock, data, charts) {
  const [play, scrub, time, speed] = ["play", "scrub", "time", "speed"].map((id) => document.getElementById(id));

  play.addEventListener("click", () => clock.toggle());
  clock.on("playing", () => {
    play.setAttribute("aria-label", clock.playing ? "Pause" : "Play");
    play.firstElementChild.textContent = clock.playing ? "❚❚" : "▶";
  });

  // The slider spans what is in view: zoomed in, it is as fine as the charts are.
  scrub.addEventListener("input", () => {
    const { from, to } = clock.view;
    clock.set(from + Number(scrub.value) * (to - from));
  });
  clock.on("time", () => {
    const { from, to } = clock.view;
    const text = timeText(clock.shown, to - from);
    scrub.value = (clock.time - from) / (to - from);
    scrub.setAttribute("aria-valuetext", text);
    time.textContent = text;
  });
  speed.addEventListener("change", () => clock.setSpeed(speed.value === "fit" ? "fit" : Number(speed.value)));

  bindLegend(document.getElementById("legend"), data, charts);
  bindZoom(document.getElementById("zoom"), clock);
  document.addEventListener("keydown", (event) => pressed(event, clock));
}

/** A time in the digits that the span in view needs. */
function timeText(time, span) {
  return span < 0.2 ? `${format(1000 * time, span < 0.02 ? 3 : 2)} ms` : `${format(time, span < 2 ? 4 : 3)} s`;
}

function bindLegend(legend, data, charts) {
  data.runs.forEach((run, index) => {
    const button = document.createElement("button");
    button.type = "button";
    button.setAttribute("aria-pressed", "true");
    const swatch = document.createElement("i");
    swatch.className = `swatch run-${index}`;
    button.append(swatch, run.title);
    button.addEventListener("click", () => button.setAttribute("aria-pressed", String(charts.toggle(index))));
    legend.append(button);
  });
}

function bindZoom(group, clock) {
  const spanOf = (button) => (button.dataset.span === "all" ? clock.stop - clock.start : Number(button.dataset.span));
  const presets = [...group.querySelectorAll("[data-span]")];
  for (const button of presets) {
    button.addEventListener("click", () => clock.look(clock.start, clock.start + spanOf(button)));
  }
  for (const button of group.querySelectorAll("[data-zoom]")) {
    button.addEventListener("click", () => clock.zoom(Number(button.dataset.zoom), clock.time));
  }
  clock.on("view", () => {
    const { from, to } = clock.view;
    const isShown = (button) => from === clock.start && Math.abs(to - from - spanOf(button)) < 1e-9;
    presets.forEach((button) => button.setAttribute("aria-current", String(isShown(button))));
  });
}

function pressed(event, clock) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const target = event.target instanceof Element ? event.target : document.body;
  // What has the focus keeps the keys it understands itself.
  const isSlider = target.matches("input[type=range]");
  if (target.closest("select, textarea, [contenteditable]")) return;
  if (event.key === " " && target.closest("button, summary, a")) return;
  if (event.key.startsWith("Arrow") && target.closest(".wide")) return;
  const { from, to } = clock.view;
  const step = ((to - from) / 200) * (event.shiftKey ? 10 : 1);
  const actions = {
    " ": () => clock.toggle(),
    ArrowLeft: () => clock.set(clock.time - step),
    ArrowRight: () => clock.set(clock.time + step),
    Home: () => clock.set(from),
    End: () => clock.set(to),
    "+": () => clock.zoom(0.5, clock.time),
    "-": () => clock.zoom(2, clock.time),
    0: () => clock.look(clock.start, clock.stop),
  };
  // Home and End scroll the page unless the slider has the focus.
  if (["Home", "End"].includes(event.key) && !isSlider && !target.closest("#transport")) return;
  const action = actions[event.key];
  if (!action) return;
  event.preventDefault();
  action();
}
