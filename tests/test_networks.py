"""The networks earn their place: with disturbances that don't vanish they take over what the rest leaves.

Without them (a1 = a31 = a32 = 0) NABFC is a sliding-mode law with sat instead of sign: a lasting disturbance leaves a
lasting error. Steady error: root mean square of the contact force error over the last quarter of 6 s, the larger one of
the two arms.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
import pytest

from .support.contract import PAPER
from .support.harness import CoSimulation, Fmu, Result
from .support.measures import FORCE

STOP, STEP = 6.0, 2e-4
OFF = {"a1": 0.0, "a31": 0.0, "a32": 0.0}
# Small leakages: where nothing is noisy, estimates come to rest within seconds, and hardly any error is left. The start values
# bear noise, and let weights creep for half a minute.
SMALL = {"a2": 1e-3, "a41": 1e-4, "a42": 1e-4, "zeta21": 2e-3, "zeta22": 2e-3}
NORMS = ("W_norm", "U1_norm", "U2_norm", "m_hat", "J1_hat", "J2_hat", "epsilon_hat", "pi1_hat", "pi2_hat")
STATE = ("theta1_dot", "theta2_dot", "y_object", "theta1", "theta2")

Disturbance = Callable[[float, Mapping[str, float]], Mapping[str, float]]


def hub_friction(_time: float, state: Mapping[str, float]) -> Mapping[str, float]:
    """A Stribeck curve in both hubs: 0.03 to 0.05 N.m of dry friction, 0.02 N.m.s of viscous friction."""

    def torque(speed: float) -> float:
        return -(0.03 + 0.02 * math.exp(-((speed / 0.1) ** 2))) * math.tanh(speed / 2e-3) - 0.02 * speed

    return {"delta_f1": torque(state["theta1_dot"]), "delta_f2": torque(state["theta2_dot"])}


def position_load(_time: float, state: Mapping[str, float]) -> Mapping[str, float]:
    """A pull that depends on the angles (half of the static torque) and a spring with an offset at the object."""
    return {
        "delta_f1": 0.05 * math.cos(10 * state["theta1"]),
        "delta_f2": -0.05 * math.cos(10 * state["theta2"]),
        "delta_F": 0.05 + 2.0 * (state["y_object"] - 0.05),
    }


def slow_force(time: float, _state: Mapping[str, float]) -> Mapping[str, float]:
    """Periods of 5 and 10 s, with an offset."""
    return {
        "delta_f1": 0.03 * math.sin(0.2 * math.pi * time),
        "delta_f2": 0.02,
        "delta_F": 0.05 * math.sin(0.4 * math.pi * time) + 0.03,
    }


Run = Callable[..., Result]


@pytest.fixture(scope="module")
def run(fmus: Mapping[str, Fmu]) -> Run:
    """The paper's task with a disturbance that sees the plant's state; equal requests are run once."""
    done: dict[tuple[str, bool], Result] = {}

    def get(disturbance: Disturbance, networks: bool = True) -> Result:
        key = (disturbance.__name__, networks)
        if key not in done:
            with CoSimulation([fmus["DualArmPlant"], fmus["NabfcController"]]) as grasp:
                grasp.set(**PAPER, **SMALL, **({} if networks else OFF))
                state = grasp.slaves[0].reader(STATE)
                names = ("contact_force1", "contact_force2", *NORMS)
                done[key] = grasp.run(
                    STOP, STEP, names, every=10, drive=lambda time: disturbance(time, dict(zip(STATE, state.read())))
                )
        return done[key]

    return get


def steady_errors(result: Result) -> list[float]:
    """Root mean square errors of both contact forces over the last quarter."""
    late = result.time >= 0.75 * STOP
    return [float(np.sqrt(np.mean((result[f"contact_force{arm}"][late] - FORCE) ** 2))) for arm in (1, 2)]


@pytest.mark.parametrize(
    ("disturbance", "fraction"),
    [
        # Measured: 0.002, 0.0001, 0.18. The issue asks for a half.
        (hub_friction, 0.05),
        (position_load, 0.05),
        (slow_force, 0.5),
    ],
)
def test_networks_halve_the_steady_error(disturbance: Disturbance, fraction: float, run: Run) -> None:
    without, with_networks = steady_errors(run(disturbance, networks=False)), steady_errors(run(disturbance))
    assert max(without) > 1e-3  # the disturbance matters
    assert max(with_networks) <= fraction * max(without)
    # Neither arm pays for the other.
    assert all(on < off for on, off in zip(with_networks, without))


@pytest.mark.parametrize("disturbance", [hub_friction, position_load])
def test_norms_settle(disturbance: Disturbance, run: Run) -> None:
    """Fig. 6: the estimates converge. Over the last quarter none moves by more than 2 % of the largest it has been."""
    result = run(disturbance)
    late = result.time >= 0.75 * STOP
    for name in NORMS:
        assert np.ptp(result[name][late]) <= 0.02 * np.max(np.abs(result[name])), name


def test_norms_stay_bounded_under_a_changing_force(run: Run) -> None:
    """A force that never rests keeps the object network moving; leakage keeps the norms where the force is."""
    result = run(slow_force)
    late = result.time >= 0.75 * STOP
    for name in ("U1_norm", "U2_norm"):
        assert np.ptp(result[name][late]) <= 0.02 * np.max(result[name])
    # W Y must make up for at most 0.08 N, with |Y| >= 1 at the target (the centre node alone gives it).
    assert np.max(result["W_norm"]) <= 0.08 * 1.05
