"""How the error of the co-simulation depends on the step, and what input and output derivatives buy.

The numbers behind `docs/figures/cosimulation-error.svg`, see `tests/studies/cosimulation_error.py`. Between
communication points the plant's step is exact, so the error is that of the coupling alone, and predictable:

* held commands act half a step late on average, and a step more in a Jacobi coupling: 1/2 h and 3/2 h of delay;
* ramped commands miss u'' t^2/2 of the curvature, h^2/6 on average, and in a Jacobi coupling they start from a value
  that was itself extrapolated over a step, h^2/2 more: 1/6 h^2 and 2/3 h^2.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from .studies.cosimulation_error import LOOPS, SIGNALS, error, errors, reference
from .studies.coupling import HOLDS, simulate
from .support.harness import CoSimulation, Fmu, Result

STEPS = (1e-4, 5e-5, 2.5e-5)
# Contact forces show the fast beam modes, for which the linear laws' steps are long.
SLOW = ("theta1", "theta2", "y_object")

Errors = dict[tuple[str, str], list[float]]


@pytest.fixture(scope="module")
def study(fmus: dict[str, Fmu]) -> Callable[[str], Errors]:
    """Errors of a loop over 0.1 s by method and step; each loop is studied once."""

    @cache
    def run(key: str) -> Errors:
        plant, controller, loop = fmus["DualArmPlant"], fmus[LOOPS[key].controller], LOOPS[key]
        exact = reference(plant, controller, loop, 0.1)
        return errors(plant, controller, loop, exact, STEPS, SIGNALS if key == "NABFC" else SLOW)

    return run


@pytest.mark.parametrize("coupling", CoSimulation.COUPLINGS)
@pytest.mark.parametrize("hold", HOLDS)
@pytest.mark.parametrize("key", LOOPS)
def test_order(key: str, hold: str, coupling: str, study: Callable[[str], Errors]) -> None:
    """One with held signals, two with ramps.

    The linear loops are close to their asymptotes at the two smallest steps. The neuro-adaptive law has kinks (sat),
    which fall on other places of each grid: its order is a mean over a factor of four.
    """
    values = study(key)[hold, coupling]
    expected = 1.0 if hold == "zoh" else 2.0
    if key == "NABFC":
        assert np.log2(values[0] / values[2]) / 2 == pytest.approx(expected, abs=0.5)
    else:
        assert np.log2(values[1] / values[2]) == pytest.approx(expected, abs=0.05 if hold == "zoh" else 0.25)


@pytest.mark.parametrize("key", ["PD", "PDS"])
def test_jacobi_costs_what_its_delay_says(key: str, study: Callable[[str], Errors]) -> None:
    """3/2 h against 1/2 h, 2/3 h^2 against 1/6 h^2."""
    found = study(key)
    for hold, ratio in (("zoh", 3.0), ("foh", 4.0)):
        assert found[hold, "jacobi"][2] / found[hold, "gauss_seidel"][2] == pytest.approx(ratio, rel=0.02)


@pytest.mark.parametrize(("key", "gain"), [("PD", 10.0), ("PDS", 40.0), ("NABFC", 30.0)])
def test_what_derivatives_buy(key: str, gain: float, study: Callable[[str], Errors]) -> None:
    """At 0.025 ms ramps are one to two orders of magnitude more exact; up to 0.1 ms they are never worse."""
    found = study(key)
    for coupling in CoSimulation.COUPLINGS:
        assert all(ramped < held for ramped, held in zip(found["foh", coupling], found["zoh", coupling]))
    assert found["zoh", "gauss_seidel"][2] / found["foh", "gauss_seidel"][2] > gain


@pytest.mark.parametrize(
    ("key", "case", "held_error"), [("PD", "paper_pd_target", 6e-6), ("PDS", "paper_pds_target", 3e-6)]
)
def test_ramped_coupling_against_the_exact_loop(
    key: str, case: str, held_error: float, fmus: dict[str, Fmu], oracle: dict[str, Any]
) -> None:
    """The limit is the monolithic loop: the exact continuous solution, without extrapolation from several steps.

    With 0.05 ms what is left is the error of the ramps, measured as 4.3e-6 for PD and 2.3e-6 for PDS (held signals:
    1.2e-4), besides what the oracle says that modes contribute which order 12 does not have.
    """
    loop, names = LOOPS[key], ("theta1", "theta2", "root_moment1", "root_moment2")
    result = simulate(
        fmus["DualArmPlant"],
        fmus[loop.controller],
        hold="foh",
        coupling="gauss_seidel",
        step=5e-5,
        stop=2.0,
        grid=0.1,
        record=names,
        settings={**loop.settings, "order": 12},
    )
    for name in names:
        size = max(abs(row["outputs"][name]["value"]) for row in oracle["steps"][case]["at"])
        for row in oracle["steps"][case]["at"]:
            exact = row["outputs"][name]
            off = abs(result[name][round(row["t"] / 0.1)] - exact["value"])
            assert off <= held_error * size + exact["error"] + exact["beyond"][3], (name, row["t"])


def test_error_measure() -> None:
    """Of itself a signal has no error; an offset of a tenth of the range is an error of 0.1."""
    time = np.linspace(0.0, 1.0, 11)
    exact = Result(time, {name: np.sin(time) for name in SIGNALS})
    shifted = Result(time, {name: np.sin(time) + 0.1 * np.sin(1.0) for name in SIGNALS})
    assert error(exact, exact) == 0.0
    assert error(shifted, exact) == pytest.approx(0.1)
