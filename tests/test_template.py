"""A stranger's way: `cargo xtask new-fmu`, `cargo test`, `cargo run`, and FMPy finds a valid FMU that is right.

`cargo xtask test` has walked it as far as compilers are needed, in the build directory.
"""

from __future__ import annotations

import os
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu
from lxml import etree

from .support.paths import ROOT, TARGET, helper

CARGO = os.environ.get("CARGO", "cargo")
NAME = "WaterHeater"


@pytest.fixture(scope="module")
def crate() -> Path:
    """A crate made from the template, compiled and packaged."""
    return helper("water-heater")


@pytest.fixture(scope="module")
def fmu(crate: Path) -> Path:
    """The new crate's FMU."""
    return crate / "dist" / f"{NAME}.fmu"


def test_the_command_makes_this_crate_and_says_what_comes_next(crate: Path, tmp_path: Path) -> None:
    folder = tmp_path / crate.name
    # While other steps of `cargo xtask test` compile, cargo would wait for them.
    xtask = [os.environ["XTASK"]] if "XTASK" in os.environ else [CARGO, "xtask"]
    made = subprocess.run([*xtask, "new-fmu", str(folder)], cwd=ROOT, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    assert f"dist/{NAME}.fmu" in made.stdout
    files = [path.relative_to(folder) for path in folder.rglob("*") if path.is_file()]
    assert len(files) == 6
    assert [name for name in files if (folder / name).read_bytes() != (crate / name).read_bytes()] == []


def test_the_crates_own_tests_pass(crate: Path) -> None:
    environment = {
        **os.environ,
        # As when it was compiled before the tests: with other settings it would be compiled again.
        **{"CARGO_PROFILE_RELEASE_OPT_LEVEL": "0", "CARGO_PROFILE_RELEASE_LTO": "off"},
        "CARGO_TARGET_DIR": str(TARGET / "template"),
    }
    command = [CARGO, "test", "--offline", "--release", "--lib"]
    done = subprocess.run(command, cwd=crate, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 passed" in done.stdout


def test_fmpy_finds_no_problem(fmu: Path) -> None:
    assert validate_fmu(str(fmu)) == []
    assert read_model_description(str(fmu)).modelName == NAME


@pytest.mark.parametrize(("insulation", "factor"), [(1, 1.0), (2, 0.1)], ids=["bare", "wrapped"])
@pytest.mark.parametrize("step", [1.0, 7.0])
def test_simulation_is_the_exact_solution(fmu: Path, insulation: int, factor: float, step: float) -> None:
    """C dT/dt = P - G (T - Ta) from T = Ta: T = Ta + P/G (1 - exp(-G t/C))."""
    start = {"heating_power": 100.0, "ambient_temperature": 280.0, "temperature_0": 280.0, "insulation": insulation}
    result = simulate_fmu(str(fmu), stop_time=700.0, output_interval=step, start_values=start)
    conductance = 2.0 * factor
    rise = 100.0 / conductance * -np.expm1(-conductance * result["time"] / 500.0)
    # Rounding in a few hundred steps of temperatures of some hundred K.
    assert result["temperature"] == pytest.approx(280.0 + rise, abs=1e-9)
    assert result["heat_loss"] == pytest.approx(conductance * rise, abs=1e-9)


def test_documentation_is_inside(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        page = etree.fromstring(archive.read("documentation/index.html"))
    assert "".join(page.find(".//h1").itertext()) == NAME
    assert len(page.findall(".//div[@class='panels']/div")) == 2
