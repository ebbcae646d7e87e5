"""A scenario that the tool ran, as tests look at it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import csv

from .tool import dualarm


def read_csv(file: Path, columns: Sequence[str] | None = None) -> dict[str, np.ndarray]:
    """Columns of a table of numbers, all of them as real ones.

    Of a run with every step, CSV takes the tool a quarter of the time of Parquet, which is compressed. `test_tool.py` makes sure
    that both say the same.
    """
    with file.open(encoding="utf-8") as lines:
        header = next(lines).rstrip("\n").split(",")
    options = csv.ConvertOptions(column_types=dict.fromkeys(header, pa.float64()), include_columns=list(columns or header))
    table = csv.read_csv(file, convert_options=options)
    return {name: table[name].to_numpy() for name in table.column_names}


class Run:
    """A scenario that was run: every step of its signals, and what the tool says about it."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        file = folder / "run.csv"
        done = dualarm("simulate", *arguments, "--interval", "0", "--json", "-o", str(file))
        assert done.returncode == 0, done.stderr
        self.document: dict[str, Any] = json.loads(done.stdout)
        self.signals = read_csv(file)
        self.time = self.signals["time"]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.signals[name]

    @property
    def forces(self) -> np.ndarray:
        """Both contact forces, one per row."""
        return np.array([self["contact_force1"], self["contact_force2"]])

    def between(self, begin: float, end: float) -> np.ndarray:
        """Both contact forces in a part of the run."""
        return self.forces[:, (self.time >= begin) & (self.time < end)]

    def settling(self, metric: str = "settling_2") -> float:
        """The later one of the two arms."""
        return max(self.document["metrics"][f"contact_force{arm}"][metric] for arm in (1, 2))


@pytest.fixture
def run(tmp_path: Path) -> Any:
    """Runs a scenario, with further arguments of the command line."""
    return lambda *arguments: Run(tmp_path, *arguments)
