"""Which parameter decides? Sobol indices of a study of `dualarm sweep`, by SALib.

    python examples/sensitivity.py scenarios/studies/robustness.toml --base 128

Saltelli's points replace the study's (`dualarm sweep --points … --unit`): coordinates from 0 to 1 in its ranges, so
logarithmic and normal ranges stay what they are. For each controller and figure the first-order index says which share of the
variance a parameter explains by itself, the total-order index by itself and together with others, both with 95 %
confidence intervals. Prints a table, writes RESULT.sensitivity.csv.
"""

from __future__ import annotations

import argparse
import csv
import subprocess
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import tomllib
from SALib.analyze import sobol as analysis
from SALib.sample import sobol as sample

#: What is explained by default: whether a run is a success, and by how many powers of ten the force is off.
FIGURES = ("success", "error_rms")


def parameters(study: Path) -> list[str]:
    """The parameters that have a range; seeds are drawn anew for each draw, whatever the points are."""
    vary = tomllib.loads(study.read_text(encoding="utf-8"))["vary"]
    return sorted(name for name, range_ in vary.items() if not (isinstance(range_, dict) and range_.get("seed")))


def write_points(names: list[str], base: int, seed: int, file: Path) -> dict:
    """Saltelli's points for these parameters; returns SALib's problem."""
    problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    points = sample.sample(problem, base, calc_second_order=False, seed=seed)
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(names)
        writer.writerows(points.tolist())
    return problem


def values(table: dict, figure: str, rows: np.ndarray) -> np.ndarray:
    """A figure as numbers: truth values as 0 and 1, errors by their logarithm, which is how far they spread."""
    column = np.array([np.nan if value is None else float(value) for value in table[figure]])[rows]
    if figure == "success":
        return column
    # What does not exist, such as the settling time of what never settles, counts as the worst there is.
    column[np.isnan(column)] = np.nanmax(column)
    return np.log10(np.maximum(column, 1e-9))


def indices(problem: dict, result: Path, figures: tuple[str, ...] = FIGURES) -> list[dict]:
    """First- and total-order indices of each figure for each controller."""
    table = pq.read_table(result).to_pydict()
    controllers = np.array(table.get("controller", ["all runs"] * len(table["run"])))
    found = []
    for controller in dict.fromkeys(controllers.tolist()):
        for figure in figures:
            if figure not in table:
                continue  # the study does not say what success is
            y = values(table, figure, controllers == controller)
            if np.ptp(y) == 0:
                continue  # nothing varies: there is no variance to explain
            si = analysis.analyze(problem, y, calc_second_order=False, seed=1)
            for place, name in enumerate(problem["names"]):
                row = {"controller": controller, "figure": figure, "parameter": name}
                row |= {key: float(si[key][place]) for key in ("S1", "S1_conf", "ST", "ST_conf")}
                found.append(row)
    return found


def run(study: Path, base: int, seed: int, output: Path, tool: Path, options: list[str]) -> list[dict]:
    """Makes the points and the runs; returns the indices."""
    points = output.with_suffix(".points.csv")
    problem = write_points(parameters(study), base, seed, points)
    words = [tool, "sweep", study, "--points", points, "--unit", "-o", output, *options]
    subprocess.run(words, check=True)
    found = indices(problem, output)
    with output.with_suffix(".sensitivity.csv").open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, found[0])
        writer.writeheader()
        writer.writerows(found)
    return found


def main() -> None:
    """The command line; what it does not know goes to `dualarm sweep`."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", type=Path)
    parser.add_argument("--base", type=int, default=256, help="N, a power of two; there are N·(D + 2) draws")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("-o", "--output", type=Path, help="rows [default: results/STUDY-sensitivity.parquet]")
    parser.add_argument("--tool", type=Path, default=Path("target/release/dualarm"))
    arguments, options = parser.parse_known_args()
    output = arguments.output or Path("results") / f"{arguments.study.stem}-sensitivity.parquet"
    found = run(arguments.study, arguments.base, arguments.seed, output, arguments.tool, options)
    before = None
    for row in sorted(found, key=lambda row: (row["figure"], row["controller"], -row["ST"])):
        if before != (head := (row["figure"], row["controller"])):
            print(f"\n{row['figure']}, {row['controller']}:  first order ± 95 %   total order ± 95 %")
            before = head
        print(
            f"  {row['parameter']:<16}{row['S1']:14.3f} ± {row['S1_conf']:.3f}{row['ST']:14.3f} ± {row['ST_conf']:.3f}"
        )


if __name__ == "__main__":
    main()
