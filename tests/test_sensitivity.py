"""`examples/sensitivity.py`: Sobol indices of a study, at points that the study takes from a file."""

from __future__ import annotations

import csv
import importlib.util
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from .support.paths import DIST, ROOT
from .support.tool import tool

pytest.importorskip("SALib", reason="SALib is not installed (tests/requirements.txt)")
pytest.importorskip("tomllib", reason="studies are TOML, which Python reads from 3.11 on")

SCRIPT = ROOT / "examples" / "sensitivity.py"
STUDY = """
title = "Small"
system = "nabfc"
controllers = ["nabfc-r", "pid"]
method = "random"
draws = 1
[experiment]
stop = 0.3
step = 1e-3
[vary]
M = { low = 0.1, high = 2, scale = "log" }
l = { low = 0.15, high = 0.3 }
"""


@pytest.fixture
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("sensitivity", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_indices_are_those_of_a_function_that_one_knows(tmp_path: Path, script: ModuleType) -> None:
    """log₁₀ of the error is 4a + 2b + ab with a, b uniform in 0…1: first orders 0.7943 and 0.2044, by hand.

    Var over a of E_b = 4.5a + 1 is 4.5²/12, over b of 2.5b + 2 is 2.5²/12, of both together (1/12)² of ab beside them.
    """
    problem = script.write_points(["a", "b"], 1024, 1, tmp_path / "points.csv")
    with (tmp_path / "points.csv").open(encoding="utf-8") as file:
        rows = [(float(row["a"]), float(row["b"])) for row in csv.DictReader(file)]
    a, b = np.array(rows).T
    table = pa.table(
        {"run": list(range(len(a))), "error_rms": 10 ** (4 * a + 2 * b + a * b), "success": [True] * len(a)}
    )
    pq.write_table(table, tmp_path / "rows.parquet")
    found = {row["parameter"]: row for row in script.indices(problem, tmp_path / "rows.parquet")}
    parts = np.array([4.5**2 / 12, 2.5**2 / 12, 1 / 144])
    first_a, first_b, both = parts / parts.sum()
    # Quasi-random points of 1024 bases: errors of some thousandths.
    assert found["a"]["S1"] == pytest.approx(first_a, abs=0.01)
    assert found["b"]["S1"] == pytest.approx(first_b, abs=0.01)
    assert found["a"]["ST"] == pytest.approx(first_a + both, abs=0.01)
    assert len(found) == 2, "what never changes has no indices"


def test_a_study_runs_at_its_points(tmp_path: Path) -> None:
    study = tmp_path / "study.toml"
    study.write_text(STUDY, encoding="utf-8")
    output = tmp_path / "rows.parquet"
    words = [sys.executable, SCRIPT, study, "--base", "4", "-o", output, "--tool", tool(), "--fmus", DIST]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    table = pq.read_table(output).to_pydict()
    assert len(table["run"]) == 4 * (2 + 2) * 2
    with (tmp_path / "rows.points.csv").open(encoding="utf-8") as file:
        masses = [0.1 * 20 ** float(row["M"]) for row in csv.DictReader(file)]
    assert table["M"][::2] == pytest.approx(masses)
    assert "error_rms, PID:  first order" in done.stdout
