"""The native tool against fmpy, and what it says to wrong input."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from .support.harness import CoSimulation, Fmu
from .support.paths import DIST
from .support.tool import dualarm


@pytest.mark.parametrize("coupling", ["gauss_seidel", "jacobi"])
@pytest.mark.parametrize("controller", ["NabfcController", "PdsController", "PdController"])
def test_native_and_fmpy_give_the_same_bits(
    controller: str, coupling: str, fmus: dict[str, Fmu], tmp_path: Path
) -> None:
    """Same binaries, same calls in the same order, exact decimals in the CSV: no tolerance."""
    output = tmp_path / "native.csv"
    done = dualarm(
        *("simulate", str(DIST / "DualArmPlant.fmu"), str(DIST / f"{controller}.fmu")),
        *("--coupling", coupling.replace("_", "-"), "--stop", "0.2", "--step", "1e-4", "--interval", "0"),
        *("--set", "M=0.4", "--set", "lambda1_ref=-0.4", "--quiet", "-o", str(output)),
    )
    assert done.returncode == 0, done.stderr
    with output.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    native = dict(zip(header, np.array(rows, dtype=float).T))
    record = [*fmus["DualArmPlant"].names("output"), *fmus[controller].names("output")]
    with CoSimulation([fmus["DualArmPlant"], fmus[controller]], coupling) as grasp:
        grasp.set(M=0.4, lambda1_ref=-0.4)
        ours = grasp.run(0.2, 1e-4, record)
    assert set(header) == {"time", *record}
    assert np.array_equal(native["time"], ours.time)
    different = [name for name in record if not np.array_equal(native[name], ours[name])]
    assert different == []


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("--set", "no_such_variable=1"), "no_such_variable"),
        (("--set", "EI1=0"), "EI1"),
        (("--set", "EI1=many"), "EI1"),
        (("--set", "order=3"), "order"),
        (("--step", "0"), "step"),
        (("--step=-1e-4",), "step"),
        (("--stop", "0"), "stop"),
        (("--fmus", "no/such/folder"), "no/such/folder"),
        (("--controller", "lqr"), "lqr"),
        (("README.md",), "README.md"),
    ],
)
def test_wrong_input_is_one_clear_error(arguments: tuple[str, ...], named: str, tmp_path: Path) -> None:
    """Non-zero exit, the culprit named, no trace of a panic, no file left behind."""
    output = tmp_path / "out.csv"
    done = dualarm("simulate", *arguments, "-o", str(output))
    assert done.returncode not in (0, 101)
    assert done.stderr.count("error:") == 1
    assert named in done.stderr
    assert "panicked" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_foreign_archive_is_refused(tmp_path: Path) -> None:
    foreign = tmp_path / "Foreign.fmu"
    foreign.write_bytes(b"not a zip archive")
    done = dualarm("simulate", str(foreign), str(DIST / "PdController.fmu"))
    assert done.returncode == 1
    assert "Foreign.fmu" in done.stderr


def test_unwritable_place_is_reported(tmp_path: Path) -> None:
    """A file where a folder should be: nobody can write below it, not even root."""
    (tmp_path / "file").write_bytes(b"")
    done = dualarm("simulate", "--stop", "0.01", "-o", str(tmp_path / "file" / "out.csv"))
    assert done.returncode == 1
    assert "out.csv" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
