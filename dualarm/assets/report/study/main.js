// Puts the page of a study together.

function choose(row) {
  view.chosen = row;
  showRun(row);
  draw();
}

const drawScatter = createScatter(document.getElementById("scatter"), choose);
const drawParallel = createParallel(document.getElementById("parallel"), choose, () => draw());

function draw() {
  const rows = shownRows();
  drawScatter(rows);
  drawParallel(rows);
}

const preferred = ["settling_rms", "settling"].map((name) => axes.find((axis) => axis.name === name)).find(Boolean);
view.x = axes.find(({ role }) => role === "parameter") ?? axes[0];
view.y = preferred ?? axes.find(({ role }) => role === "figure") ?? axes[0];
for (const key of ["x", "y"]) {
  const select = document.getElementById(key);
  for (const axis of axes) select.add(new Option(axis.name, axis.name, false, axis === view[key]));
  select.addEventListener("change", () => {
    view[key] = axes.find((axis) => axis.name === select.value);
    draw();
  });
}

const legend = document.getElementById("legend");
controllers.forEach((name, index) => {
  const button = document.createElement("button");
  button.type = "button";
  button.className = `run-${index % COLOURS}`;
  button.setAttribute("aria-pressed", "true");
  const swatch = document.createElement("span");
  swatch.className = "swatch";
  button.append(swatch, name);
  button.addEventListener("click", () => {
    if (!view.hidden.delete(index)) view.hidden.add(index);
    button.setAttribute("aria-pressed", String(!view.hidden.has(index)));
    draw();
  });
  legend.append(button);
});

const failures = document.getElementById("failures");
failures.addEventListener("change", () => {
  view.onlyFailures = failures.checked;
  draw();
});
document.getElementById("all").addEventListener("click", () => {
  view.kept.clear();
  view.hidden.clear();
  view.onlyFailures = failures.checked = false;
  for (const button of legend.children) button.setAttribute("aria-pressed", "true");
  draw();
});
createTheme(document.getElementById("theme"), draw);
addEventListener("resize", draw);
// On paper the plots are light, whatever the screen is.
addEventListener("beforeprint", () => {
  const root = document.documentElement;
  const shown = root.dataset.theme;
  const use = (theme) => {
    if (theme) root.dataset.theme = theme;
    else delete root.dataset.theme;
    colours.clear();
    draw();
  };
  use("light");
  addEventListener("afterprint", () => use(shown), { once: true });
});
draw();
document.documentElement.dataset.ready = "";
