"""Draws docs/figures/cost.svg from docs/performance/cost.csv; needs matplotlib.

`python -m tests.studies.performance` measures, writes that file and draws.
"""

from __future__ import annotations

import csv
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("svg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, NullLocator

DOCS = Path(__file__).resolve().parents[2] / "docs"
#: Pairs of the plant and a law: the name in the file, what it is called, its marker.
PAIRS = [("pair", "the paper's law", "o"), ("pair-r", "the default law", "s")]
#: From this order on the slope is taken: below, what does not grow is most of a step.
LARGE = 10


def slope(x: list[float], y: list[float]) -> float:
    """Exponent of the power law through the points."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def label_heights(axes: Axes) -> None:
    """Numbers 1, 2 and 5 of every decade in view, more where these are fewer than four: matplotlib's own locator leaves two then."""
    low, high = axes.get_ylim()
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    for digits in ((1, 2, 5), (1, 1.5, 2, 3, 4, 5, 6, 8)):
        numbers = [digit * 10.0**decade for decade in decades for digit in digits]
        shown = [number for number in numbers if low <= number <= high]
        if len(shown) >= 4:
            break
    axes.yaxis.set_major_locator(FixedLocator(shown))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_ylim(low, high)


def draw() -> list[str]:
    """Draws, and says what the slopes are."""
    plt.rcParams["svg.hashsalt"] = "cost"
    with (DOCS / "performance/cost.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    plants = [row for row in rows if row["what"] == "plant"]
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")

    said = []
    k = [float(row["order"]) for row in plants]
    for key, label, marker in (("step_ns", "step through the C interface", "o"), ("in_c_ns", "the same in C", "s")):
        y = [float(row[key]) for row in plants]
        if not np.isfinite(y).all():
            continue
        exponent = slope(*zip(*((order, cost) for order, cost in zip(k, y, strict=True) if order >= LARGE), strict=True))
        left.loglog(k, y, marker=marker, label=f"{label}: slope {exponent:.2f} from k = {LARGE}")
        said.append(f"* Order, {label}: slope {exponent:.2f} from k = {LARGE}.")
    last = float(plants[-1]["step_ns"])
    left.loglog(k, [last * order / k[-1] for order in k], "k:", label="slope 1")
    left.set(xlabel="order k", ylabel="ns per step", title="One plant")
    left.set_xticks(k, [f"{order:.0f}" for order in k])
    left.minorticks_off()
    label_heights(left)
    left.legend(fontsize=8)

    for what, law, marker in PAIRS:
        pairs = [row for row in rows if row["what"] == what]
        n = [float(row["instances"]) for row in pairs]
        total = [float(row["instances"]) * float(row["step_ns"]) * 1e-3 for row in pairs]
        said.append(f"* Pairs, {law}: a step of all has slope {slope(n, total):.2f}.")
        right.loglog(n, total, marker=marker, label=f"a step of all, {law}: slope {slope(n, total):.2f}")
    right.loglog(n, [total[0] * count for count in n], "k:", label="slope 1")
    right.set(xlabel="pairs in one process", ylabel="µs per step of all", title="Plant of order 8 and NABFC")
    label_heights(right)
    right.legend(fontsize=8)
    figure.savefig(DOCS / "figures/cost.svg", metadata={"Date": None})
    return said


if __name__ == "__main__":
    print("\n".join(draw()))
