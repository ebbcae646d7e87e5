// Light and dark: the system's choice until the button is used. Canvases need the colours as values.

function createTheme(button, changed) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const root = document.documentElement;
  const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : system.matches);
  const show = () => {
    colours.clear();
    button.setAttribute("aria-pressed", String(isDark()));
    changed();
  };
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    show();
  });
  system.addEventListener("change", show);
  button.setAttribute("aria-pressed", String(isDark()));
}

const colours = new Map();

/** The current value of a colour of the style sheet, such as `--ink`; of a scheme ("light"), whatever is shown. */
function colour(name, scheme = "") {
  const key = name + scheme;
  if (!colours.has(key)) colours.set(key, resolve(name, scheme));
  return colours.get(key);
}

function resolve(name, scheme) {
  const probe = document.createElement("i");
  probe.style.colorScheme = scheme;
  probe.style.color = `var(${name})`;
  document.body.append(probe);
  const value = getComputedStyle(probe).color;
  probe.remove();
  return value;
}
