"""The robustness study: makes its runs, and from them the figures and tables of docs/studies.md.

    target/venv/bin/python -m tests.studies.robustness [--draws 500] [--base 128]

Needs examples/requirements-cluster.txt. Interrupted, it goes on where it was.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import subprocess
import tomllib
from pathlib import Path
from types import ModuleType

import matplotlib
import numpy as np
import pyarrow.parquet as pq
from SALib.analyze import delta

matplotlib.use("svg")
import matplotlib.pyplot as plt

ROOT = Path(__file__).resolve().parents[2]
STUDY = Path("scenarios/studies/robustness.toml")
PAGE = ROOT / "docs" / "studies.md"
FIGURES = ROOT / "docs" / "figures"
#: The same file for the same numbers.
plt.rcParams.update({"svg.hashsalt": "dualarm", "font.family": "sans-serif", "font.size": 9})
COLOURS = ["#0072b2", "#4fb3f0", "#009e73", "#d55e00", "#e69f00", "#b0518c", "#7a6a00", "#56606e"]

Table = dict[str, list]


def sensitivity() -> ModuleType:
    """The example."""
    spec = importlib.util.spec_from_file_location("sensitivity", ROOT / "examples" / "sensitivity.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def column(table: Table, name: str, controller: str) -> np.ndarray:
    """A figure of one controller; what does not exist is infinite: never."""
    rows = zip(table["controller"], table[name])
    return np.array([np.inf if value is None else float(value) for key, value in rows if key == controller])


def draw_distributions(table: Table, controllers: list[str]) -> None:
    """The share of runs that stay below a value, for four figures."""
    panels = [
        ("settling_rms", "settled within [s]", 1.0, (0.05, 6)),
        ("overshoot", "overshoot of the force up to [%]", 1.0, (0.1, 1000)),
        ("steady_error", "steady force error up to [mN]", 1e3, (0.01, 1000)),
        ("contact_loss", "contact lost for up to [ms]", 1e3, (1, 6000)),
    ]
    figure, axes = plt.subplots(2, 2, figsize=(9, 6.4), layout="constrained")
    for axis, (name, title, factor, limits) in zip(axes.flat, panels):
        for controller, colour in zip(controllers, COLOURS):
            share = np.linspace(0, 100, 201)  # enough for the eye
            values = np.percentile(column(table, name, controller) * factor, share, method="inverted_cdf")
            axis.step(np.maximum(values, limits[0]), share, where="post", color=colour, label=controller, lw=1.3)
        axis.set(xscale="log", xlim=limits, ylim=(0, 100), xlabel=title, ylabel="share of the draws [%]")
        axis.grid(alpha=0.25)
    axes[0, 0].legend(fontsize=8, frameon=False)
    figure.savefig(FIGURES / "robustness.svg", metadata={"Date": None})


def first_order(table: Table, controllers: list[str]) -> list[dict]:
    """First-order indices of success from the study's own draws, whatever they are: the method of Plischke, Borgonovo and
    Smith (European Journal of Operational Research 226 (2013) 536-550), with 95 % intervals by resampling.
    """
    study = tomllib.loads((ROOT / STUDY).read_text(encoding="utf-8"))
    names = sorted(name for name, range_ in study["vary"].items() if not range_.get("seed"))
    keys = np.array(table["controller"])
    found = []
    for controller in controllers:
        rows = keys == controller
        x, y = np.array([table[name] for name in names], dtype=float).T[rows], np.array(table["success"], dtype=float)[rows]
        if min(y.sum(), len(y) - y.sum()) < 20:
            continue  # what nearly always fails or succeeds has no cause to look for
        bounds = [[x[:, place].min(), x[:, place].max()] for place in range(len(names))]
        problem = {"num_vars": len(names), "names": names, "bounds": bounds}
        si = delta.analyze(problem, x, y, num_resamples=50, seed=1)
        for place, name in enumerate(names):
            row = {"controller": controller, "parameter": name, "S1": si["S1"][place], "S1_conf": si["S1_conf"][place]}
            found.append(row | {"slope": float(np.corrcoef(x[:, place], y)[0, 1])})
    return found


def draw_sensitivity(found: list[dict], controllers: list[str]) -> None:
    """First-order indices: a row for each parameter, a panel for each controller; red where larger values do harm."""
    names = sorted({row["parameter"] for row in found}, key=str.lower)
    shown = [controller for controller in controllers if any(row["controller"] == controller for row in found)]
    figure, axes = plt.subplots(1, len(shown), figsize=(1.35 * len(shown) + 1, 4.2), sharey=True, layout="constrained")
    for axis, controller in zip(np.atleast_1d(axes), shown):
        own = {row["parameter"]: row for row in found if row["controller"] == controller}
        place = np.arange(len(names))[::-1]
        colours = ["#0072b2" if own[name]["slope"] > 0 else "#d55e00" for name in names]
        errors = [own[name]["S1_conf"] for name in names]
        axis.barh(place, [own[name]["S1"] for name in names], xerr=errors, color=colours, error_kw={"lw": 0.8})
        axis.set(title=controller, xlim=(0, 0.4), yticks=place, yticklabels=names)
        axis.title.set_fontsize(8)
        axis.grid(axis="x", alpha=0.25)
    figure.savefig(FIGURES / "sensitivity.svg", metadata={"Date": None})


def table_of(document: dict, table: Table) -> str:
    """Success and spread of the figures, in Markdown."""
    lines = [
        "| controller | success, 95 % interval | settled [s] | overshoot [%] | steady error [mN] | contact lost [ms] "
        "| mean error below 2 % |",
        "|:--|--:|--:|--:|--:|--:|--:|",
    ]
    for group in document["groups"]:
        figures = {figure["name"]: figure for figure in group["figures"]}

        def spread(name: str, factor: float, digits: int) -> str:
            own = [figures[name][key] for key in ("median", "p05", "p95")]  # noqa: B023 (called at once)
            shown = ["never" if value is None else f"{factor * value:.{digits}f}" for value in own]
            return f"{shown[0]} ({shown[1]} – {shown[2]})"

        rate = group["success_rate"]
        small = 100 * np.mean(column(table, "steady_error", group["controller"]) <= 0.01)
        lines.append(
            f"| {group['controller']} | {100 * rate['share']:.1f} % ({100 * rate['low']:.1f} – {100 * rate['high']:.1f}) "
            f"| {spread('settling_rms', 1, 2)} | {spread('overshoot', 1, 1)} | {spread('steady_error', 1e3, 1)} "
            f"| {spread('contact_loss', 1e3, 0)} | {small:.1f} % |"
        )
    return "\n".join(lines)


def table_of_indices(found: list[dict], controllers: list[str]) -> str:
    """What decides success: the parameters with the largest indices, and which way."""
    lines = ["| controller | what decides success: first-order index, and the harmful end |", "|:--|:--|"]
    for controller in controllers:
        own = sorted((row for row in found if row["controller"] == controller), key=lambda row: -row["S1"])
        largest = [
            f"{row['parameter']} {row['S1']:.2f} ± {row['S1_conf']:.2f} ({'small' if row['slope'] > 0 else 'large'})"
            for row in own[:4]
        ]
        lines.append(f"| {controller} | {', '.join(largest) or 'nothing: it hardly ever changes'} |")
    return "\n".join(lines)


def table_of_totals(found: list[dict], controllers: list[str]) -> str:
    """What takes part in the success: the parameters with the largest total-order indices, first-order ones beside them."""
    lines = ["| controller | total order (first order) of the parameters involved |", "|:--|:--|"]
    for controller in controllers:
        own = [row for row in found if (row["controller"], row["figure"]) == (controller, "success")]
        largest = [
            f"{row['parameter']} {row['ST']:.2f} ± {row['ST_conf']:.2f} ({row['S1']:.2f})"
            for row in sorted(own, key=lambda row: -row["ST"])[:5]
        ]
        if largest:
            lines.append(f"| {controller} | {', '.join(largest)} |")
    return "\n".join(lines)


def for_totals(study: Path) -> Path:
    """The study with the controllers of 1 kHz alone, since those of 5 kHz take most of the time and hardly ever succeed, and
    with the same noise in every draw: drawn anew it would be a part of every total-order index.
    """
    lines = study.read_text(encoding="utf-8").splitlines()
    dropped = ("system =", "noise_seed =")
    kept = [line for line in lines if "step = 2e-4" not in line and not line.startswith(dropped)]
    system = (study.parent / "../matrix/noise.toml").resolve()
    file = ROOT / "results" / "robustness-1khz.toml"
    file.parent.mkdir(exist_ok=True)
    file.write_text("\n".join([f'system = "{system.as_posix()}"', *kept, ""]), encoding="utf-8")
    return file


def put(name: str, text: str) -> None:
    """Replaces what stands between two marks of the page."""
    page = PAGE.read_text(encoding="utf-8")
    head, rest = page.split(f"<!-- {name} -->\n")
    _, tail = rest.split(f"<!-- end of {name} -->")
    PAGE.write_text(f"{head}<!-- {name} -->\n{text}\n<!-- end of {name} -->{tail}", encoding="utf-8")


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmus", type=Path, default=ROOT / "dist")
    parser.add_argument("--draws", type=int, default=2000, help="only the first so many")
    parser.add_argument("--base", type=int, default=0, help="N of Saltelli's points for total-order indices, a power of two; 0: none")
    arguments = parser.parse_args()
    tool = ROOT / "target" / "release" / "dualarm"
    result = Path("results/robustness.parquet")
    fmus = str(arguments.fmus.resolve())
    words = [tool, "sweep", STUDY, "--fmus", fmus, "-o", result, "--report", result.with_suffix(".html"), "--json"]
    words += ["--runs", f"0..{8 * arguments.draws}"]
    done = subprocess.run(words, cwd=ROOT, check=True, stdout=subprocess.PIPE)
    document = json.loads(done.stdout)
    table = pq.read_table(ROOT / result).to_pydict()
    controllers = [group["controller"] for group in document["groups"]]
    draw_distributions(table, controllers)
    put("success", table_of(document, table))
    found = first_order(table, controllers)
    draw_sensitivity(found, controllers)
    put("sensitivity", table_of_indices(found, controllers))
    if arguments.base:
        output = ROOT / "results" / "robustness-sensitivity.parquet"
        totals = sensitivity().run(for_totals(ROOT / STUDY), arguments.base, 1, output, tool, ["--fmus", fmus])
        print(table_of_totals(totals, controllers))


if __name__ == "__main__":
    main()
