"""A stranger's way: `cargo xtask new-fmu`, `cargo test`, `cargo run`, and FMPy finds a valid FMU that is right."""

from __future__ import annotations

import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu
from lxml import etree

from .conftest import ROOT

CARGO = os.environ.get("CARGO", "cargo")
NAME = "WaterHeater"


@pytest.fixture(scope="module")
def crate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A new crate outside of the repository."""
    folder = tmp_path_factory.mktemp("elsewhere") / "water-heater"
    made = subprocess.run(
        [CARGO, "xtask", "new-fmu", str(folder)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert made.returncode == 0, made.stderr
    assert f"dist/{NAME}.fmu" in made.stdout
    # The versions that the workspace has: they have been fetched, so that nothing is asked of the network.
    shutil.copy(ROOT / "Cargo.lock", folder)
    return folder


def cargo(crate: Path, *arguments: str) -> str:
    """What cargo prints; its files stay in the build directory, where the next run finds them."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve() / "template"
    # How well the compiler optimises is not what is tested: compile fast.
    fast = {"CARGO_PROFILE_RELEASE_OPT_LEVEL": "1", "CARGO_PROFILE_RELEASE_LTO": "off"}
    environment = {**os.environ, **fast, "CARGO_TARGET_DIR": str(target)}
    done = subprocess.run(
        [CARGO, arguments[0], "--offline", *arguments[1:]],
        cwd=crate,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def fmu(crate: Path) -> Path:
    """The new crate's FMU."""
    cargo(crate, "run", "--quiet", "--release", "--features", "package")
    return crate / "dist" / f"{NAME}.fmu"


def test_the_crates_own_tests_pass(crate: Path) -> None:
    assert "3 passed" in cargo(crate, "test", "--release", "--lib")


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
