"""A scenario that the tool ran, as tests look at it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from .tool import dualarm


class Run:
    """A scenario that was run: every step of its signals, and what the tool says about it."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        file = folder / "run.parquet"
        done = dualarm("simulate", *arguments, "--interval", "0", "--json", "-o", str(file))
        assert done.returncode == 0, done.stderr
        self.document: dict[str, Any] = json.loads(done.stdout)
        table = pq.read_table(file)
        self.signals = {name: table[name].to_numpy() for name in table.column_names}
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
