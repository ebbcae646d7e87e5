"""libcosim, the engine of the Open Simulation Platform, as an independent judge.

Its algorithm is a fixed-step Jacobi iteration, as our harness with `coupling="jacobi"`. It keeps the time in whole
nanoseconds and hands over differences of it, so a step of 0.1 ms is off by rounding, and equality is up to that. It looks
at outputs before it hands over the new inputs; outputs that follow inputs at once are therefore not compared.

What libcosimpy 0.0.6 does not do, and therefore does not judge: it leaves out Enumeration variables and
sets no input derivatives.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys

import numpy as np
import pytest

from .judges import read_table
from .support.contract import CONTROLLERS, MEASURED
from .support.harness import CoSimulation, Fmu
from .support.paths import ROOT

STEP, STEPS = 1e-4, 1000
SETTINGS = {"M": 0.4, "EI2": 0.2, "theta1_ref": 0.03, "theta2_dot_0": 0.1, "k_M2": 0.15}


@pytest.mark.skipif(
    importlib.util.find_spec("libcosimpy") is None,
    reason="libcosimpy has no wheel for this platform: not checked that libcosim gives the same trajectories",
)
@pytest.mark.parametrize("settings", [{}, SETTINGS], ids=["default", "other_values"])
@pytest.mark.parametrize("controller", CONTROLLERS)
def test_libcosim_gives_the_same_trajectories(
    controller: str, settings: dict[str, float], fmus: dict[str, Fmu]
) -> None:
    pair = (fmus["DualArmPlant"], fmus[controller])
    done = subprocess.run(
        [sys.executable, "-m", "tests.judges.libcosim", *(str(fmu.path) for fmu in pair)]
        + [repr(STEP), str(STEPS), json.dumps(settings)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    theirs = read_table(done.stdout)
    with CoSimulation(pair, "jacobi") as grasp:
        grasp.set(**settings)
        ours = grasp.run(STEPS * STEP, STEP, tuple(MEASURED))
    assert np.ptp(ours["theta1"]) > 1e-3  # something happened
    for name in MEASURED:
        # Times of 0.1 s are rounded by 1e-17 s, a step of 0.1 ms by a relative 1e-13, and there are 1000 of them.
        bound = 1e-10 * np.max(np.abs(ours[name]))
        assert np.max(np.abs(theirs[name] - ours[name][1:])) < bound, name
