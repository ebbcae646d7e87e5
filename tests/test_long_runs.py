"""A million steps, closed loops at their sampling limits, and other plants."""

from __future__ import annotations

import csv
import math
from typing import Any

import numpy as np
import pytest

from .support.capabilities import output_slopes
from .support.contract import PAPER
from .support.harness import CoSimulation, Fmu, FmuError
from .support.tool import dualarm
from .test_extremes import CONSERVATIVE, MASSLESS, SUBNORMAL


# --- Long runs -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("order", "steps"), [(8, 10**6), (24, 10**5)])
def test_energy_and_constraint_over_many_steps(order: int, steps: int, plant: Fmu) -> None:
    """A bent, conservative plant let go: 100 s of vibration at 0.1 ms.

    Round-off is a random walk of 1e-16 per step: 1e-13 of the energy in 10^6 steps (measured 9e-14), of the lengths of
    0.1 m 1e-14.
    """
    step, rows = 1e-4, []
    with plant.instantiate() as slave:
        slave.set(order=order, y_object_0=0.06, theta1_0=0.03, actuator_model="ideal", **CONSERVATIVE)
        slave.start()
        read, advance = slave.reader(["energy", "constraint1", "constraint2", "theta1"]).read, slave.step
        rows.append(read())
        for first in range(0, steps, 1000):
            for i in range(first, first + 1000):
                advance(i * step, step, 1)
            rows.append(read())
    energy, constraint1, constraint2, theta1 = np.array(rows).T
    assert energy[0] > 1e-4
    assert np.ptp(theta1) > 0.01
    assert np.max(np.abs(energy / energy[0] - 1)) < 1e-12
    assert np.max(np.abs([constraint1, constraint2])) < 1e-13


@pytest.fixture(scope="module", params=["nabfc", "nabfc-r", "pds"])
def long_run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, dict[str, Any]]:
    """100 s of a closed loop, 10^6 steps of the native master, one row in 0.1 s."""
    output = tmp_path_factory.mktemp("long") / "long.csv"
    arguments = ("--controller", request.param, "--stop", "100", "--step", "1e-4", "--interval", "0.1")
    done = dualarm("simulate", *arguments, "--quiet", "-o", str(output))
    assert done.returncode == 0, done.stderr
    with output.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return request.param, dict(zip(header, np.array([[float(cell) for cell in row] for row in rows]).T))


def test_grasp_over_a_million_steps(long_run: tuple[str, dict[str, Any]]) -> None:
    """It stays where it settled; estimates only leak; nothing rings."""
    _, signals = long_run
    late = signals["time"] > 50.0
    assert signals["time"][-1] == 100.0
    assert all(np.all(np.isfinite(values)) for values in signals.values())
    for name in ("contact_force1", "contact_force2"):
        assert np.max(np.abs(signals[name][late] - 0.5)) < 1e-8
    for name in ("theta1", "theta2", "y_object"):
        assert np.ptp(signals[name][late]) < 1e-10
    for name in ("m_hat", "J1_hat", "pi1_hat", "W_norm", "U1_norm"):
        if name in signals:
            # What has leaked away has nothing left to lose but rounding: moments of 0.05 N.m are read from modes, whose basis has
            # a condition of some hundred, and an estimate of what is left over follows that.
            size = np.abs(signals[name][late])
            assert np.all((np.diff(size) <= 0.0) | (size[1:] < 1e-14)), name


def test_constraint_over_a_million_steps(long_run: tuple[str, dict[str, Any]]) -> None:
    """Constraint (12) stays an invariant: 1e-13 m, ten thousand roundings of a length of 0.1 m."""
    _, signals = long_run
    assert max(np.max(np.abs(signals[f"constraint{arm}"])) for arm in (1, 2)) < 1e-13


def test_decay_ends_at_zero(plant: Fmu) -> None:
    """Vibrations die out to zeros instead of subnormal numbers, on which processors are a hundred times slower."""
    names = plant.names("output", "Real")
    with plant.instantiate() as slave:
        slave.set(kelvin_voigt=1e-4, y_object_0=0.06)
        slave.start()
        read = slave.reader(names).read
        for i in range(10000):
            slave.step(i * 0.01, 0.01, 1)
            values = np.abs(read())
            assert not np.any((values > 0) & (values < SUBNORMAL))
        assert slave.get("root_moment1", "tip_shear1", "tip_shear1_dot") == [0.0, 0.0, 0.0]
        # The rigid motion that is left has its energy, and nothing more is lost.
        assert output_slopes(slave, ["energy"]).read() == [0.0]


# --- Closed loops ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("controller", "kv", "inertia"),
    [
        ("PdController", 55.0, 1e-3),
        ("PdController", 55.0, 0.0073),
        ("PdController", 55.0, 0.03),
        ("PdsController", 15.0, 0.0073),
    ],
)
def test_linear_loops_are_stable_up_to_their_sampling_limit(
    controller: str, kv: float, inertia: float, fmus: dict[str, Fmu]
) -> None:
    """A hub with a sampled velocity feedback, theta_dot+ = (1 - h kv/J) theta_dot, needs h < 2 J/kv.

    The beam and the other gains hardly matter to that: below the limit the hubs come to the slow approach, above it
    they oscillate from step to step with a growing amplitude. Material damping keeps the beam's own modes quiet.
    """
    limit, record = 2 * inertia / kv, ("theta1_dot", "theta2_dot")
    late = {}
    for factor in (0.9, 1.15):
        steps = round(0.2 / (factor * limit))
        with CoSimulation([fmus["DualArmPlant"], fmus[controller]]) as grasp:
            grasp.set(J1=inertia, J2=inertia, lambda1_ref=-0.005, theta1_ref=5e-4)
            grasp.set(actuator_model="ideal", kelvin_voigt=1e-4)
            try:
                result = grasp.run(steps * factor * limit, factor * limit, record)
                late[factor] = max(np.max(np.abs(result[name][-steps // 4 :])) for name in record)
            except FmuError:
                late[factor] = math.inf  # refused: the state would overflow
    assert late[0.9] < 2e-3
    assert late[1.15] > 1e3


@pytest.mark.parametrize(
    "parameters",
    [
        # The default law takes no mass for less than r_mass_min = 0.15 kg, nor a hub for more than some times observer_inertia.
        {**PAPER, **MASSLESS, "M": 0.01},
        {"M": 1.0},
        {"M": 3.0},
        {"EI1": 0.05, "EI2": 0.05},
        {"EI1": 0.5, "EI2": 0.5},
        {"EI1": 0.05, "EI2": 0.2},
        {**PAPER, "J1": 0.1, "J2": 0.1},
        {"J1": 0.0146, "J2": 0.0146},
        {"J1": 0.001, "J2": 0.03},
        {"rho1": 1e-6, "rho2": 1e-6},
        {"order": 24, "kelvin_voigt": 1e-2},
    ],
    ids=str,
)
def test_adaptive_loop_of_other_plants(parameters: dict[str, float], fmus: dict[str, Fmu]) -> None:
    """Default gains, of the paper's law where it says so; neither is told: both forces within 2 % after 2 s, within all limits."""
    record = ("contact_force1", "contact_force2", "tau1", "tau2", "u")
    with CoSimulation([fmus["DualArmPlant"], fmus["NabfcController"]]) as grasp:
        grasp.set(**parameters)
        result = grasp.run(2.0, 1e-4, record, every=10)
    for name in ("contact_force1", "contact_force2"):
        assert np.all(np.abs(result[name][-100:] / 0.5 - 1) < 0.02)
    # Not through chattering: the last tenth of a second is smooth.
    assert np.max(np.abs(np.diff(result["tau1"][-100:]))) < 0.02
    assert np.max(np.abs(np.diff(result["u"][-100:]))) < 0.02
