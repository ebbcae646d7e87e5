"""Plant and controllers wired by equal names: what the paper's scenarios must show, and what the physics demands."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from .conftest import ClosedLoop
from .oracle.cases import TARGET_LAMBDA1, TARGET_THETA1_DEG
from .support.contract import CONTROLLERS, PAPER
from .support.harness import CoSimulation, Fmu, Result
from .support.measures import FORCE, force_overshoot, force_settling_times

both_couplings = pytest.mark.parametrize("coupling", CoSimulation.COUPLINGS)

FORCES = ("contact_force1", "contact_force2")
APPLIED = ("tau1", "tau2", "u")
RECORD = (*FORCES, *APPLIED, "tau1_cmd", "tau2_cmd", "u_cmd", "in_contact")

# How NabfcController's second set of gains is chosen.
FAST: dict[str, float | str] = {"preset": "fast"}
PAPER_FAST = {**PAPER, **FAST}

# (19), (20) with the paper's numbers: k_r (k_M - m_r).
TORQUE_LIMIT, FORCE_LIMIT = 2.0, 0.3


def assert_within_limits(result: Result) -> None:
    """What the actuators deliver; the limits themselves are 2.1 - 0.1 and 0.31 - 0.01, up to rounding."""
    for name in ("tau1", "tau2"):
        assert np.max(np.abs(result[name])) <= TORQUE_LIMIT + 1e-15
    assert np.max(np.abs(result["u"])) <= FORCE_LIMIT + 1e-15


def assert_at_target(result: Result, bound: float) -> None:
    """Both forces at the end within a fraction of the target."""
    for name in FORCES:
        assert result[name][-1] == pytest.approx(FORCE, rel=bound)


# --- The paper's scenarios, bounds from the issue --------------------------------------------------------------------


@both_couplings
def test_nabfc_defaults(coupling: str, closed_loop: ClosedLoop) -> None:
    """Default law; the requirement for it is 0.2 s."""
    result = closed_loop("NabfcController", 2.0, coupling=coupling, record=RECORD)
    assert max(force_settling_times(result)) < 0.20
    assert force_overshoot(result) < 0.02
    assert_within_limits(result)
    assert_at_target(result, 0.001)


@both_couplings
def test_nabfc_papers_law(coupling: str, closed_loop: ClosedLoop) -> None:
    result = closed_loop("NabfcController", 2.0, coupling=coupling, record=RECORD, **PAPER)
    assert max(force_settling_times(result)) < 0.40
    assert force_overshoot(result) < 0.005
    assert_within_limits(result)
    assert_at_target(result, 0.01)


@both_couplings
def test_nabfc_fast_preset(coupling: str, closed_loop: ClosedLoop) -> None:
    result = closed_loop("NabfcController", 2.0, coupling=coupling, record=RECORD, **PAPER_FAST)
    assert max(force_settling_times(result)) <= 0.20
    assert force_overshoot(result) < 0.01
    assert_within_limits(result)
    assert_at_target(result, 0.01)


@both_couplings
@pytest.mark.parametrize("preset", [{}, FAST, PAPER, PAPER_FAST], ids=["default", "fast", "paper", "paper, fast"])
def test_nabfc_with_long_steps(coupling: str, preset: dict[str, Any], closed_loop: ClosedLoop) -> None:
    """At 1 ms with a step of delay on top: still below 0.5 s, and no limit cycle at the actuator's limit."""
    result = closed_loop("NabfcController", 3.0, step=1e-3, coupling=coupling, record=RECORD, **preset)
    assert max(force_settling_times(result)) < 0.5
    late = result.time > 1.0
    assert np.ptp(result["u"][late]) < 0.1 * FORCE_LIMIT
    assert_within_limits(result)


@pytest.mark.parametrize("settings", [{}, FAST, PAPER], ids=["default", "fast", "paper"])
def test_the_headline_does_not_depend_on_the_order(settings: dict[str, Any], closed_loop: ClosedLoop) -> None:
    """Elements of order 8, as by default, and 12: forces within 2 % at the same time, to a millisecond, as README.md says."""
    times = [
        force_settling_times(closed_loop("NabfcController", 1.0, record=RECORD, order=order, **settings)) for order in (8, 12)
    ]
    assert times[0] == pytest.approx(times[1], abs=1e-3)


def test_pd_is_the_one_that_does(closed_loop: ClosedLoop) -> None:
    """Its second force runs along the edge of the band: 3.943 s with order 8, 3.920 s from order 10 on."""
    times = [force_settling_times(closed_loop("PdController", 8.0, record=RECORD, order=order)) for order in (8, 12)]
    assert times[0] == pytest.approx([3.865, 3.943], abs=1e-3)
    assert times[1] == pytest.approx([3.865, 3.920], abs=1e-3)


@pytest.mark.parametrize(
    ("controller", "stop", "coupling", "step", "earliest", "latest"),
    [
        ("PdsController", 4.0, "gauss_seidel", 1e-4, 1.0, 1.5),
        ("PdsController", 4.0, "jacobi", 1e-4, 1.0, 1.5),
        ("PdController", 8.0, "gauss_seidel", 1e-4, 3.6, 4.2),
        # With the step of delay of a Jacobi coupling the sampled PD loop has eigenvalues with real parts of +0.009,
        # +0.073 and +0.23 1/s at 0.1 ms (modes at 561, 1819 and 3799 rad/s; the exact continuous loop damps the first
        # by 0.084 1/s only): the linear loop itself is unstable. At 0.05 ms it is stable.
        ("PdController", 8.0, "jacobi", 5e-5, 3.6, 4.2),
    ],
)
def test_linear_controllers(
    controller: str, stop: float, coupling: str, step: float, earliest: float, latest: float, closed_loop: ClosedLoop
) -> None:
    result = closed_loop(controller, stop, step=step, coupling=coupling, record=RECORD, every=round(1e-3 / step))
    assert earliest <= max(force_settling_times(result)) <= latest
    assert_within_limits(result)
    assert_at_target(result, 0.02)


def test_order_of_the_controllers(closed_loop: ClosedLoop) -> None:
    """The paper's claim: NABFC before PDS before PD."""
    slowest = [
        max(force_settling_times(closed_loop(controller, stop, record=RECORD, every=every)))
        for controller, stop, every in zip(CONTROLLERS, (2.0, 4.0, 8.0), (1, 10, 10))
    ]
    assert slowest == sorted(slowest)


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_contact_flag_agrees_with_the_forces(controller: str, closed_loop: ClosedLoop) -> None:
    result = closed_loop(
        controller,
        {"PdController": 8.0, "PdsController": 4.0}.get(controller, 2.0),
        record=RECORD,
        every=1 if controller == "NabfcController" else 10,
    )
    compressive = (result["contact_force1"] >= 0) & (result["contact_force2"] >= 0)
    # At exactly zero force either answer is right.
    decided = (result["contact_force1"] != 0) & (result["contact_force2"] != 0)
    assert np.array_equal(result["in_contact"][decided] == 1, compressive[decided])


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_references_can_be_others(controller: str, closed_loop: ClosedLoop) -> None:
    """Another force and another angle are reached too, by arms that are not alike."""
    result = closed_loop(
        controller,
        {"NabfcController": 3.0, "PdsController": 6.0, "PdController": 12.0}[controller],
        record=(*FORCES, "theta1", "e1", "e2", "p"),
        every=100,
        lambda1_ref=-0.3,
        theta1_ref=math.radians(5),
        EI2=0.2,
        J2=0.005,
    )
    # Settled to a few percent: the object's actuator has a dead zone in no default model, so nothing is left in theory;
    # NABFC's leakage terms leave a little.
    assert result["contact_force1"][-1] == pytest.approx(0.3, rel=0.05)
    assert result["contact_force2"][-1] == pytest.approx(0.3, rel=0.05)
    assert result["theta1"][-1] == pytest.approx(math.radians(5), abs=math.radians(0.2))


# --- Invariants ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_constraint_is_kept_for_ten_seconds(controller: str, closed_loop: ClosedLoop) -> None:
    """Constraint (12) is an invariant; the issue's bound of 1e-12 m is for the round-off of 100 000 steps."""
    result = closed_loop(controller, 10.0, record=("constraint1", "constraint2"), every=10)
    assert np.max(np.abs(result["constraint1"])) <= 1e-12
    assert np.max(np.abs(result["constraint2"])) <= 1e-12


def multi_level(time: float) -> dict[str, float]:
    """Commands that jump between levels at incommensurable rates, with mean zero over time; some saturate."""
    return {
        "tau1_cmd": 0.06 * ((-1) ** int(time * 7.3) + 0.5 * (-1) ** int(time * 31.7)),
        "tau2_cmd": -0.08 * (-1) ** int(time * 11.9),
        "u_cmd": 0.4 * (-1) ** int(time * 5.1),  # the limit is 0.3
        "delta_f1": 0.01 * (-1) ** int(time * 3.7),
        "delta_F": 0.05 * (-1) ** int(time * 13.3),
    }


def smooth(time: float) -> dict[str, float]:
    """Sines near the rigid and the first elastic resonances, and a slow external torque."""
    return {
        "tau1_cmd": 0.05 * math.sin(20.0 * time),
        "tau2_cmd": 0.02 * math.sin(560.0 * time),
        "u_cmd": 0.1 * math.sin(15.0 * time) + 0.1,
        "delta_f2": 0.01 * math.sin(2.0 * time),
    }


@pytest.mark.parametrize("drive", [multi_level, smooth])
def test_energy_is_what_was_supplied(drive: Any, plant: Fmu) -> None:
    """Without uncertainties energy - supplied_energy stays 0 within 1e-12 J (the issue's bound) over 10 s at 0.1 ms."""
    with CoSimulation([plant]) as alone:
        alone.set(root_uncertainty=0.0, tip_uncertainty=0.0, kelvin_voigt=0.0)
        result = alone.run(10.0, 1e-4, ("energy", "supplied_energy", "theta1"), every=100, drive=drive)
    balance = result["energy"] - result["supplied_energy"]
    assert np.ptp(result["energy"]) > 1e-3  # something happened
    assert np.max(np.abs(balance - balance[0])) <= 1e-12


def test_uncertainties_only_dissipate(plant: Fmu) -> None:
    """With them the balance never rises: -c_f dM/dt works against the hub, in the exact model and in this one.

    Not step by step (the rate terms are not a Rayleigh damper), so: after the drive ends, energy falls from its value
    then to what the rigid motion keeps.
    """
    with CoSimulation([plant]) as alone:
        result = alone.run(
            4.0, 1e-4, ("energy", "supplied_energy"), every=100, drive=lambda t: {"tau1_cmd": 0.05 * (t < 0.2)}
        )
    late = result["energy"][result.time > 3.0]
    assert np.ptp(late) <= 1e-9 * late[0]  # only the undamped rigid motion is left
    assert late[-1] < result["supplied_energy"][-1]


# --- Against the exact closed loop -----------------------------------------------------------------------------------

ORACLE_OUTPUTS = ("theta1", "theta2", "root_moment1", "root_moment2", "tip_shear1", "lambda1", "lambda2")


@pytest.mark.parametrize(
    ("controller", "case"), [("PdController", "paper_pd_target"), ("PdsController", "paper_pds_target")]
)
def test_small_signals_against_the_exact_loop(
    controller: str, case: str, closed_loop: ClosedLoop, oracle: dict[str, Any]
) -> None:
    """A hundredth of the paper's target, so that nothing saturates, against the exact continuous loop.

    Sampling with a zero-order hold makes an error a h + b h^2 + ...: extrapolating from h and h/2, then from h/2 and
    h/4, leaves b h^2/2 and b h^2/8; extrapolating these leaves the third order, which is bounded by how far the two are
    apart.
    """
    record = ("y_object", *ORACLE_OUTPUTS, *APPLIED, "tau1_cmd", "tau2_cmd", "u_cmd")
    steps = (1e-4, 5e-5, 2.5e-5)
    runs = [
        closed_loop(
            controller,
            2.0,
            step=step,
            record=record,
            every=round(0.1 / step),
            order=12,
            lambda1_ref=float(TARGET_LAMBDA1),
            theta1_ref=math.radians(float(TARGET_THETA1_DEG)),
        )
        for step in steps
    ]
    for name in APPLIED:
        assert np.array_equal(runs[0][name], runs[0][f"{name}_cmd"])  # linear: nothing is cut off
    for name in ("y", *ORACLE_OUTPUTS):
        h, h2, h4 = (run["y_object"] - 0.05 if name == "y" else run[name] for run in runs)
        coarse, fine = 2 * h2 - h, 2 * h4 - h2
        for row in oracle["steps"][case]["at"]:
            i = round(row["t"] / 0.1)
            exact = row["outputs"][name]
            size = max(abs(other["outputs"][name]["value"]) for other in oracle["steps"][case]["at"])
            bound = abs(fine[i] - coarse[i]) + exact["error"] + exact["beyond"][3] + 1e-9 * size
            extrapolated = (4 * fine[i] - coarse[i]) / 3
            assert abs(extrapolated - exact["value"]) <= bound, (name, row["t"])
            # The bound says something: late modes of the shear make 0.2 % at 0.1 s, everything else is far less.
            assert bound <= 3e-3 * size, (name, row["t"])
            # Without extrapolation: the first-order error of one sample of delay, a few 1e-4 of the signal.
            assert abs(h[i] - exact["value"]) <= 1e-2 * size, (name, row["t"])
