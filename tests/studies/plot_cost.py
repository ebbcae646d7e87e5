"""Draws docs/figures/cost.svg from docs/performance/cost.csv; needs matplotlib.

cargo run --release -p dualarm --example step_cost -- sizes > docs/performance/cost.csv
python tests/studies/plot_cost.py
"""

from __future__ import annotations

import csv
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("svg")
import matplotlib.pyplot as plt

DOCS = Path(__file__).resolve().parents[2] / "docs"


def slope(x: list[float], y: list[float]) -> float:
    """Exponent of the power law through the points."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def main() -> None:
    plt.rcParams["svg.hashsalt"] = "cost"
    with (DOCS / "performance/cost.csv").open(newline="") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    orders = [row for row in rows if row["instances"] == 1]
    instances = [row for row in rows if row["order"] == 8]
    instances.sort(key=lambda row: row["instances"])
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")

    k = [row["order"] for row in orders]
    for key, label, marker in (
        ("step_ns", "step", "o"), ("floor_ns", "its arithmetic alone", "s"),
    ):
        y = [row[key] for row in orders]
        large = [i for i, order in enumerate(k) if order >= 10]
        exponent = slope([k[i] for i in large], [y[i] for i in large])
        left.loglog(k, y, marker=marker, label=f"{label}: slope {exponent:.2f} from k = 10")
        print(f"order, {label}: {exponent:.2f} from k = 10")
    left.loglog(k, [orders[-1]["floor_ns"] * order / k[-1] for order in k], "k:", label="slope 1")
    left.set(xlabel="order k", ylabel="ns per step", title="One plant")
    left.set_xticks(k, [f"{order:.0f}" for order in k])
    left.minorticks_off()
    left.set_ylim(bottom=12)  # room for the legend below all lines
    left.legend(fontsize=8, loc="lower right")

    n = [row["instances"] for row in instances]
    total = [row["instances"] * row["step_ns"] * 1e-3 for row in instances]
    print(f"instances: {slope(n, total):.2f}")
    right.loglog(n, total, marker="o", label=f"a step of all: slope {slope(n, total):.2f}")
    right.loglog(n, [total[0] * count for count in n], "k:", label="slope 1")
    right.set(xlabel="instances in one process", ylabel="us per step of all", title="Order 8")
    right.legend(fontsize=8)
    figure.savefig(DOCS / "figures/cost.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
