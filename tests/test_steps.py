"""The longest steps between plant and controller that README.md names, and docs/importing.md repeats."""

from __future__ import annotations

import re

import numpy as np
import pytest

from .conftest import ClosedLoop
from .support.harness import FmuError
from .support.measures import force_settling_times
from .support.paths import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
COUPLINGS = ("gauss_seidel", "jacobi")


def limits() -> dict[tuple[str, str], float]:
    """The steps in s by controller and coupling."""
    table = README.split("<!-- steps")[1].split("<!-- end")[0]
    found = re.findall(r"\| (PDS?|NABFC) \| [^\d|]*([\d.]+) ms \| [^\d|]*([\d.]+) ms \|", table)
    assert len(found) == 3
    return {
        (f"{name.capitalize()}Controller", coupling): 1e-3 * float(value)
        for name, *values in found
        for coupling, value in zip(COUPLINGS, values)
    }


def vibration_dies_out(closed_loop: ClosedLoop, controller: str, coupling: str, step: float) -> bool:
    """Whether the hub torque quietens down; without saturation, so that the loop is linear."""
    stop = round(3.0 / step) * step
    try:
        run = closed_loop(controller, stop, step=step, coupling=coupling, record=("tau1",), actuator_model="ideal")
    except FmuError:  # beyond what a step accepts
        return False
    middle, end = (run["tau1"][(a * stop < run.time) & (run.time < b * stop)] for a, b in ((0.5, 0.6), (0.9, 1.0)))
    return bool(np.ptp(end) < np.ptp(middle))


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("controller", ["PdController", "PdsController"])
def test_limits_of_the_stiff_loops(controller: str, coupling: str, closed_loop: ClosedLoop) -> None:
    """Stable just below, unstable well above. Near the limit a mode grows so slowly that 3 s do not show it; the sharp
    limits are those of spectral radii in grasp-control/tests/sampling.rs."""
    limit = limits()[controller, coupling]
    assert vibration_dies_out(closed_loop, controller, coupling, 0.98 * limit)
    assert not vibration_dies_out(closed_loop, controller, coupling, 1.15 * limit)


@pytest.mark.parametrize("coupling", COUPLINGS)
def test_nabfc_grasps_with_more_than_its_step(coupling: str, closed_loop: ClosedLoop) -> None:
    step = 1.25 * limits()["NabfcController", coupling]
    forces = ("contact_force1", "contact_force2")
    run = closed_loop("NabfcController", 1.0, step=step, coupling=coupling, record=forces)
    assert max(force_settling_times(run)) < 0.5


def test_the_guide_to_importing_says_the_same() -> None:
    guide = (ROOT / "docs" / "importing.md").read_text(encoding="utf-8")
    for (controller, coupling), step in limits().items():
        (row,) = re.findall(rf"\| `{controller}` \| [^\d|]*([\d.]+) ms \| [^\d|]*([\d.]+) ms \|", guide)
        assert float(row[COUPLINGS.index(coupling)]) == pytest.approx(1e3 * step)
