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
  for (const run of data.runs) {
    const button = document.createElement("button");
    button.type = "button";
    button.setAttribute("aria-pressed", "true");
    const swatch = document.createElement("i");
    swatch.className = `swatch run-${run.index}`;
    button.append(swatch, run.title);
    button.addEventListener("click", () => button.setAttribute("aria-pressed", String(charts.toggle(run))));
    legend.append(button);
  }
}

/** Spans to choose from: round ones of about these shares of the whole. */
const SHARES = [1 / 160, 1 / 16, 1 / 4];

function bindZoom(group, clock) {
  const whole = clock.stop - clock.start;
  const round = (wanted) => {
    const power = 10 ** Math.floor(Math.log10(wanted));
    const near = (factor) => Math.abs(Math.log((factor * power) / wanted));
    return [1, 2, 5, 10].reduce((best, factor) => (near(factor) < near(best) ? factor : best)) * power;
  };
  const spans = [...SHARES.map((share) => round(share * whole)), whole];
  const presets = spans.map((span, at) => {
    const preset = document.createElement("button");
    preset.type = "button";
    preset.textContent = at === SHARES.length ? "All" : spanText(span);
    preset.addEventListener("click", () => clock.look(clock.start, clock.start + span));
    return preset;
  });
  group.prepend(...presets);
  for (const button of group.querySelectorAll("[data-zoom]")) {
    button.addEventListener("click", () => clock.zoom(Number(button.dataset.zoom), clock.time));
  }
  clock.on("view", () => {
    const { from, to } = clock.view;
    const isShown = (span) => from === clock.start && Math.abs(to - from - span) < 1e-9 * whole;
    presets.forEach((preset, at) => preset.setAttribute("aria-current", String(isShown(spans[at]))));
  });
}

function spanText(span) {
  return span < 0.2 ? `${short(1000 * span)} ms` : `${short(span)} s`;
}

function pressed(event, clock) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const target = event.target instanceof Element ? event.target : document.body;
  // What has the focus keeps the keys it understands itself.
  if (target.closest("select, textarea, [contenteditable]")) return;
  if (event.key === " " && target.closest("button, summary, a")) return;
  const wide = target.closest(".wide");
  if (event.key.startsWith("Arrow") && wide && wide.scrollWidth > wide.clientWidth) return;
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
  const action = actions[event.key];
  if (!action) return;
  event.preventDefault();
  action();
}
