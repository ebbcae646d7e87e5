// The chosen run: its row, and the command that simulates it again.

function showRun(row) {
  document.getElementById("hint").hidden = row !== null;
  document.getElementById("run").hidden = row === null;
  if (row === null) return;
  const run = columnOf("run").values[row];
  document.getElementById("command").textContent = `${command} --run ${run} -o results/run-${run}.parquet`;
  const list = document.getElementById("row");
  list.replaceChildren(
    ...columns.map(({ name, unit, values }) => {
      const pair = document.createElement("div");
      const [term, value] = ["dt", "dd"].map((tag) => document.createElement(tag));
      term.textContent = unit ? `${name} [${unit}]` : name;
      value.textContent = format(values[row]);
      pair.append(term, value);
      return pair;
    }),
  );
}

document.getElementById("copy").addEventListener("click", async () => {
  const code = document.getElementById("command");
  // A page that was opened as a file may have no clipboard; then the text is at least marked.
  getSelection().selectAllChildren(code);
  await navigator.clipboard?.writeText(code.textContent).catch(() => {});
});
