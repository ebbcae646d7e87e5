"""Plant and controller by model exchange, against what their co-simulation tends to as its step goes to zero."""

from __future__ import annotations

import math

import numpy as np
import pytest

from .support.exchange import Grasp, Model, integrate
from .support.harness import CoSimulation, Fmu

STOP = 0.005
OUTPUTS = ("theta1", "theta2", "y_object", "root_moment1", "root_moment2", "tip_shear1", "tip_shear2")
# So short a way that no limit matters: then the error of co-simulation is a series in its step.
SMALL = {"lambda1_ref": -0.005, "theta1_ref": math.radians(0.03)}
ESTIMATED = {"rate_source": "estimated"}
INTEGRALS = {"kp": 2411.0, "kv": 42.64, "ki": 26_310.0} | {
    f"{gain}{arm}": value for arm in (1, 2) for gain, value in {"kp": 76.67, "kv": 2.86, "ki": 23.96}.items()
}
CASES: dict[str, tuple[str, dict[str, float | str]]] = {
    "root strain": ("NabfcController", {}),
    "root strain, estimated rates": ("NabfcController", ESTIMATED),
    "root strain with networks": ("NabfcController", {"r_learner": "networks"}),
    "the paper's law, estimated rates": ("NabfcController", {"law": "paper", "sat_limit": 10.0, **ESTIMATED}),
    "PDS, estimated rates": ("PdsController", {"kv1": 3.0, "kv2": 3.0, **ESTIMATED}),
    "PD with integrals": ("PdController", INTEGRALS),
}


def limit_of_co_simulation(fmus: list[Fmu], settings: dict[str, float | str]) -> tuple[np.ndarray, np.ndarray]:
    """The outputs at the end, extrapolated to a step of zero (Neville), and how far the last two of these are apart."""
    rows = []
    for level in range(6):
        steps = 100 * 2**level
        with CoSimulation(fmus, "gauss_seidel") as grasp:
            grasp.set(**settings)
            result = grasp.run(STOP, STOP / steps, OUTPUTS, steps)
        rows.append(np.array([result[name][-1] for name in OUTPUTS]))
    before = rows[-1]
    for column in range(1, len(rows)):
        before = rows[-1]
        rows = [fine + (fine - coarse) / (2**column - 1) for coarse, fine in zip(rows, rows[1:])]
    return rows[0], np.abs(rows[0] - before)


@pytest.mark.parametrize("case", CASES)
def test_the_loop_is_the_limit_of_co_simulation(case: str, fmus: dict[str, Fmu]) -> None:
    """The laws that the monolithic solution does not have: to 1e-9 of the way, which is a hundredth of the nominals."""
    name, settings = CASES[case]
    settings = {**settings, **SMALL}
    plant, law = fmus["DualArmPlant"], fmus[name]
    expected, uncertain = limit_of_co_simulation([plant, law], settings)
    with Model(plant) as arms, Model(law) as controller:
        grasp = Grasp(arms, controller)
        controller.set(**settings)
        z, outputs = grasp.start(), arms.reader(OUTPUTS)
        found: list[np.ndarray] = []

        def at(_t: float, z: np.ndarray) -> None:
            grasp.put(z)
            found.append(outputs.read())

        nominal = np.concatenate([arms.nominals, controller.nominals])
        options = {"rtol": 1e-13, "atol": 1e-15 * nominal}
        integrate(grasp.rates, z, STOP, [STOP], grasp.indicators, grasp.event, at, **options)
    tolerance = 1e-11 * np.array([float(plant.variables[output].nominal or 1.0) for output in OUTPUTS])
    assert len(found) == 1
    assert np.all(uncertain < tolerance)
    assert np.all(np.abs(found[0] - expected) < tolerance), (found[0] - expected) / tolerance
