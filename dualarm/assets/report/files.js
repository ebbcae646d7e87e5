// What one can take away: data as CSV, charts and figures as SVG and PNG.

/** Pixels of a PNG per px of its SVG. */
const SHARPNESS = 2;

function save(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** A name that every system takes. */
function fileName(text, extension) {
  const plain = text.normalize("NFKD").replace(/[^\w.-]+/g, "-").replace(/^-+|-+$/g, "");
  return `${plain || "data"}.${extension}`;
}

/** What the page holds of a run: all signals, in as many digits as it has. */
function csv(run) {
  const quoted = (name) => (/[",\n]/.test(name) ? `"${name.replaceAll('"', '""')}"` : name);
  const columns = [...run.signals.values()];
  const digits = (value) => (Number.isFinite(value) ? String(Number(value.toPrecision(7))) : "");
  const lines = [["time", ...run.signals.keys()].map(quoted).join(",")];
  run.times.forEach((time, row) => {
    lines.push([String(Number(time.toPrecision(10))), ...columns.map((values) => digits(values[row]))].join(","));
  });
  return `${lines.join("\n")}\n`;
}

async function png(svg) {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`;
  await image.decode();
  const canvas = document.createElement("canvas");
  canvas.width = image.naturalWidth * SHARPNESS;
  canvas.height = image.naturalHeight * SHARPNESS;
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

/** Buttons that save what `svg()` gives, under a name. */
function addTake(parent, name, title, svg) {
  const kinds = {
    SVG: async () => save(fileName(name, "svg"), new Blob([svg()], { type: "image/svg+xml" })),
    PNG: async () => save(fileName(name, "png"), await png(svg())),
  };
  for (const [kind, action] of Object.entries(kinds)) parent.append(button(kind, `${title} as ${kind}`, action));
}

function button(text, name, action) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  made.setAttribute("aria-label", name);
  made.title = name;
  made.addEventListener("click", action);
  return made;
}

/** The buttons below the charts and those of the figures. */
function createDownloads(data) {
  const downloads = document.getElementById("downloads");
  for (const run of data.runs) {
    const action = () => save(fileName(run.key || run.title, "csv"), new Blob([csv(run)], { type: "text/csv" }));
    const made = button(`${run.title}, CSV`, `Data of ${run.title} as CSV`, action);
    const swatch = document.createElement("i");
    swatch.className = `swatch run-${run.index}`;
    made.prepend(swatch);
    downloads.append(made);
  }
}

function createFigures() {
  for (const figure of document.querySelectorAll(".drawn figure")) {
    const title = figure.querySelector("strong").textContent;
    const svg = () => new XMLSerializer().serializeToString(figure.querySelector("svg"));
    addTake(figure.querySelector(".take"), figure.dataset.name, title, svg);
  }
}
