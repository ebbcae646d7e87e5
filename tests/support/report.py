"""`results/report.html` and the data beside it, and what a test reads from such a page in a browser."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from .once import once
from .tool import dualarm

RUNS = ("nabfc", "pds", "pd")
MINUS = "\N{MINUS SIGN}"


@dataclass
class Report:
    """The page and the CSV files written with it."""

    html: Path
    runs: dict[str, dict[str, np.ndarray]]

    def at(self, run: str, signal: str, time: float) -> float:
        """A signal's value in the CSV file, at a time that has a row there."""
        row = int(np.argmin(np.abs(self.runs[run]["time"] - time)))
        assert abs(self.runs[run]["time"][row] - time) < 1e-9
        return float(self.runs[run][signal][row])


@pytest.fixture(scope="session")
def comparison(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with all that `dualarm compare` writes, and what it prints with `--json`, in `printed.json`."""

    def compare(folder: Path) -> None:
        done = dualarm("compare", "--no-package", "--json", "--out", str(folder))
        assert done.returncode == 0, done.stderr
        (folder / "printed.json").write_text(done.stdout, encoding="utf-8")

    return once(tmp_path_factory, "comparison", compare)


@pytest.fixture(scope="session")
def report(comparison: Path) -> Report:
    runs = {}
    for run in RUNS:
        with (comparison / f"{run}.csv").open(newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file)
        runs[run] = dict(zip(header, np.array(rows, dtype=float).T))
    return Report(comparison / "report.html", runs)


def show(page: Any, time: float) -> None:
    """Moves the slider to a time in s, as a hand on it would."""
    start, stop = spans(page)[0][0]
    scrub(page, (time - start) / (stop - start))


def scrub(page: Any, share: float) -> None:
    """Moves it to a share of what is shown."""
    page.eval_on_selector(
        "#scrub", "(slider, share) => { slider.value = share; slider.dispatchEvent(new Event('input')); }", share
    )


def spans(page: Any) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Of every chart the span of time and of values that it shows, as it tells those who do not see it."""
    labels = page.eval_on_selector_all(".chart [role=img]", "all => all.map(one => one.getAttribute('aria-label'))")
    assert len(labels) == 9
    found = []
    for label in labels:
        match = re.search(r"from (\S+) to (\S+) s, between (\S+) and (\S+) ", label)
        assert match, label
        low, high, bottom, top = (float(text.replace(MINUS, "-")) for text in match.groups())
        found.append(((low, high), (bottom, top)))
    return found


def tips(page: Any) -> list[tuple[float, float]]:
    """Where the six tips are drawn, in mm, y upwards: NABFC's two, PDS's, PD's."""
    return page.eval_on_selector_all(
        "circle.tip", "all => all.map(one => [one.cx.baseVal.value, -one.cy.baseVal.value])"
    )


def arm_points(page: Any) -> list[list[tuple[float, float]]]:
    """The points that each drawn arm passes through, in mm, y upwards."""
    paths = page.eval_on_selector_all("path.arm[data-arm]", "all => all.map(one => one.getAttribute('d'))")
    curves = []
    for path in paths:
        numbers = [float(text) for text in re.findall(r"-?[0-9.]+(?:e-?\d+)?", path)]
        pairs = list(zip(numbers[::2], numbers[1::2]))
        curves.append([(x, -y) for x, y in [pairs[0], *pairs[3::3]]])
    return curves


def faces(page: Any) -> list[tuple[float, float]]:
    """The lowest and the highest point of each drawn object, in mm, y upwards."""
    return page.eval_on_selector_all(
        "path.object",
        """all => all.map(one => {
            const box = one.getBBox();
            const shift = one.parentElement.transform.baseVal.consolidate().matrix.f;
            return [-(box.y + box.height + shift), -(box.y + shift)];
        })""",
    )


def shown_time(page: Any) -> float:
    """The time that the page shows, in s."""
    number, unit = page.inner_text("#time").replace(MINUS, "-").split()
    return float(number) * {"s": 1.0, "ms": 1e-3}[unit]
