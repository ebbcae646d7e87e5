"""Ecos, a native co-simulation engine, as an independent judge: it wires plant and controller from the .fmu files.

Its only algorithm is a fixed-step Jacobi iteration: every instance gets its inputs, steps and publishes its outputs,
then all connections are transferred. Our harness with `coupling="jacobi"` makes the same calls on the same binaries, so
the trajectories are equal to the bit, without tolerance.

What Ecos 0.7.2 does not do, and therefore does not judge: it leaves out Enumeration variables, sets no input
derivatives, and goes on when an FMU reports an error.
"""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from .judges import different, read_table
from .support.contract import CONTROLLERS
from .support.harness import CoSimulation, Fmu, Result
from .support.paths import ROOT


@pytest.fixture(scope="module", autouse=True)
def _ecos() -> None:
    """Skips where Ecos cannot be loaded: its wheel holds x86-64 libraries for Linux and Windows, for Python >= 3.10."""
    loading = [sys.executable, "-c", "from tests.judges.ecos import load; load()"]
    done = subprocess.run(loading, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        why = done.stderr.strip().splitlines()[-1]
        pytest.skip(f"Ecos cannot be loaded ({why}): not checked that a third-party master gives the same trajectories")


STEP, STEPS = 1e-4, 1000
SETTINGS = {"M": 0.4, "EI2": 0.2, "order": 10, "theta1_ref": 0.03, "theta2_dot_0": 0.1, "k_M2": 0.15}


def run_ecos(plant: Fmu, controller: Fmu, parameters: dict[str, Any]) -> Result:
    arguments = [str(plant.path), str(controller.path), repr(STEP), str(STEPS), json.dumps(parameters)]
    done = subprocess.run(
        [sys.executable, "-m", "tests.judges.ecos", *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return read_table(done.stdout)


def run_harness(plant: Fmu, controller: Fmu, settings: dict[str, Any]) -> Result:
    outputs = [name for fmu in (plant, controller) for name in fmu.names("output", "Real")]
    with CoSimulation([plant, controller], "jacobi") as grasp:
        grasp.set(**settings)
        return grasp.run(STEPS * STEP, STEP, outputs)


@pytest.mark.parametrize("settings", [{}, SETTINGS], ids=["default", "other_values"])
@pytest.mark.parametrize("controller", CONTROLLERS)
def test_ecos_gives_the_same_bits(controller: str, settings: dict[str, float], fmus: dict[str, Fmu]) -> None:
    """Parameters of both FMUs, real and integer; one actuator saturates in the second case."""
    pair = (fmus["DualArmPlant"], fmus[controller])
    parameters = {
        f"{instance}::{name}": value
        for instance, fmu in zip(("plant", "controller"), pair)
        for name, value in settings.items()
        if name in fmu.variables
    }
    theirs, ours = run_ecos(*pair, parameters), run_harness(*pair, settings)
    assert set(theirs.signals) == set(ours.signals)
    # Ecos adds up the time: 1000 roundings of 1e-16 s.
    assert np.max(np.abs(theirs.time - ours.time)) < 1e-13
    assert np.ptp(ours["theta1"]) > 1e-3  # something happened
    assert different(theirs, ours) == []


@pytest.mark.xfail(reason="Ecos 0.7.2 drops variables of type Enumeration when it reads a description", strict=True)
def test_ecos_sets_enumerations(fmus: dict[str, Fmu]) -> None:
    pair = (fmus["DualArmPlant"], fmus["PdsController"])
    ours = run_harness(*pair, {"actuator_model": "ideal", "y_object_0": 0.06})
    assert np.max(np.abs(ours["u"])) > 0.31  # beyond the limit of the default actuator
    assert different(run_ecos(*pair, {"plant::actuator_model": 1, "plant::y_object_0": 0.06}), ours) == []
