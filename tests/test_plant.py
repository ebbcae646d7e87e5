"""The plant alone against the exact solution: statics, eigenvalues, step responses, actuators."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from .support.contract import MEASURED
from .support.harness import CoSimulation, Fmu
from .support.identify import eigenvalues, nearest, pulse_responses

IDEAL = {"actuator_model": "ideal"}
# Outputs of the oracle that the FMU has by the same name; its y is y_object - L/2.
SAME_NAMES = ("theta1", "theta2", "root_moment1", "root_moment2", "tip_shear1", "tip_shear2", "lambda1", "lambda2")

PARAMETERS = {
    "EI": ("EI1", "EI2"),
    "rho": ("rho1", "rho2"),
    "J": ("J1", "J2"),
    "m_tip": ("m1", "m2"),
    "M": "M",
    "l": "l",
    "root_uncertainty": "root_uncertainty",
    "tip_uncertainty": "tip_uncertainty",
    "kelvin_voigt": "kelvin_voigt",
}


def start_values(plant: dict[str, Any], uncertainties: bool = True) -> dict[str, float]:
    """The oracle's parameters by the FMU's names."""
    values: dict[str, float] = {}
    for key, names in PARAMETERS.items():
        if isinstance(names, tuple):
            values.update(zip(names, plant[key]))
        else:
            values[names] = plant[key]
    if not uncertainties:
        values.update(root_uncertainty=0.0, tip_uncertainty=0.0)
    return values


@pytest.mark.parametrize("order", [4, 8, 24])
def test_start_is_the_static_cubic(order: int, plant: Fmu) -> None:
    """w_i(x, 0) bridges theta_i and y_M as (16) does: w = (lambda x^2 / 2 EI)(x/3 - l), exact for every order."""
    start = {"theta1_0": 0.1, "theta2_0": -0.05, "y_object_0": 0.055}
    EI, l = (0.115, 0.3), 0.2  # noqa: E741
    with plant.instantiate() as slave:
        slave.set(order=order, EI2=EI[1], **start)
        slave.start()
        for arm, theta in ((1, 0.1), (2, -0.05)):
            tip = l * theta - (0.055 - 0.05)
            lambda_ = -3 * EI[arm - 1] * tip / l**3
            shape = [lambda_ * x**2 / (2 * EI[arm - 1]) * (x / 3 - l) for x in np.linspace(0, l, 11)]
            # Round-off of polynomials of degree 24 in a basis of Legendre's kind; values of 1e-2 to 1e2.
            assert slave.get(*(f"deflection{arm}[{i}]" for i in range(1, 12))) == pytest.approx(shape, abs=1e-15)
            assert slave.get(f"root_moment{arm}")[0] == pytest.approx(-lambda_ * l, rel=1e-12)
            assert slave.get(f"tip_shear{arm}")[0] == pytest.approx(lambda_, rel=1e-12)
            assert slave.get(f"tip_deflection{arm}")[0] == pytest.approx(tip, rel=1e-12)
            assert abs(slave.get(f"constraint{arm}")[0]) < 1e-16


Responses = Callable[..., np.ndarray]


@pytest.fixture(scope="module")
def responses(plant: Fmu, oracle: dict[str, Any]) -> Responses:
    """Pulse responses of the FMU for a plant of the oracle, computed once."""
    done: dict[tuple[Any, ...], np.ndarray] = {}

    def get(name: str, order: int, step: float, uncertainties: bool) -> np.ndarray:
        key = (name, order, step, uncertainties)
        if key not in done:
            values = start_values(oracle["plants"][name], uncertainties)
            done[key] = pulse_responses(plant, step, 60, order=order, **values)
        return done[key]

    return get


@pytest.mark.parametrize(
    ("name", "order", "bounds"),
    [
        # Bounds of the issue: at order 8 the first four elastic modes 1e-6 and the fifth 1e-4, at order 12 all 1e-9.
        ("paper", 8, [1e-6] * 4 + [1e-4]),
        ("paper", 12, [1e-9] * 5),
        # Other plants converge alike: modes are counted, not frequencies.
        ("unequal", 12, [1e-9] * 5),
        ("light_object", 12, [1e-9] * 5),
        ("heavy_object", 12, [1e-9] * 5),
        ("soft_arms", 12, [1e-9] * 5),
        ("stiff_arms", 12, [1e-9] * 5),
    ],
)
def test_natural_frequencies(
    name: str, order: int, bounds: list[float], responses: Responses, oracle: dict[str, Any]
) -> None:
    """Identified from the FMU's pulse responses, against the transcendental equation."""
    # One step is below half a period of the fifth mode; identification adds 1e-12 of round-off.
    exact = [complex(0, imaginary) for _, imaginary in oracle["eigenvalues"][f"{name}_free"]["values"]]
    step = min(1e-3, 0.5 / exact[4].imag)
    found = eigenvalues(responses(name, order, step, False))
    for expected, bound in zip(exact, bounds):
        identified = nearest(found, expected, step)
        assert identified.imag == pytest.approx(expected.imag, rel=bound)
        # Conservative: nothing grows or decays (in 1/s, against the frequency).
        assert abs(identified.real) < 1e-9 * abs(expected)


@pytest.mark.parametrize("name", ["paper", "unequal", "kelvin_voigt", "unequal_kelvin_voigt"])
def test_damped_eigenvalues(name: str, responses: Responses, oracle: dict[str, Any]) -> None:
    """With the uncertainties (and Kelvin-Voigt damping): rigid modes and first pair at order 12.

    1e-8 is what identification leaves of modes that decay by exp(-0.3) in a step; the issue asks for 1e-6.
    """
    step = 1e-3
    found = eigenvalues(responses(name, 12, step, True))
    listed = [complex(*pair) for pair in oracle["eigenvalues"][f"{name}_no_control"]["values"]]
    for expected in listed:
        if expected.real > -400 and expected.imag < 1000:  # what is left after one step is above round-off
            identified = nearest(found, expected, step)
            assert abs(identified - expected) < 1e-8 * abs(expected)
    # Rigid motion is a double eigenvalue 1: round-off of 1e-13 splits it by its square root.
    assert np.max(np.abs(found)) < 1 + 1e-6


@pytest.mark.parametrize("order", range(4, 25))
@pytest.mark.parametrize("uncertainties", [True, False])
def test_no_order_has_a_growing_mode(order: int, uncertainties: bool, plant: Fmu) -> None:
    """A kick of 0.1 ms excites every mode; in 1000 s a real part of 0.01 1/s would multiply the energy by e^20.

    Without uncertainties energy is kept: 1e-11 is the round-off of 1000 exact steps.
    """
    values = {} if uncertainties else {"root_uncertainty": 0.0, "tip_uncertainty": 0.0}
    with plant.instantiate() as slave:
        slave.set(order=order, **IDEAL, **values)
        slave.start()
        slave.set(tau1_cmd=2.0, tau2_cmd=-1.0, u_cmd=0.3)
        slave.step(0.0, 1e-4, 1)
        slave.set(tau1_cmd=0.0, tau2_cmd=0.0, u_cmd=0.0)
        (kick,) = slave.get("energy")
        for second in range(1000):
            slave.step(1e-4 + second, 1.0, 1)
        (energy,) = slave.get("energy")
    assert kick > 1e-8
    if uncertainties:
        assert energy < kick
    else:
        assert energy == pytest.approx(kick, rel=1e-11)


STEPS = [
    ("paper_tau1", 8),
    ("paper_tau1", 12),
    ("unequal_tau1", 12),
    ("unequal_tau2", 12),
    ("unequal_u", 12),
    ("kelvin_voigt_tau1", 12),
    ("unequal_kelvin_voigt_u", 12),
]


@pytest.mark.parametrize(("name", "order"), STEPS)
def test_step_response(name: str, order: int, plant: Fmu, oracle: dict[str, Any]) -> None:
    """Against the exact solution, from 0.01 to 1 s.

    A polynomial of order k has about k/4 pairs of beam modes right; what the oracle says that all later pairs
    contribute is the bound, together with a tenth of the last right pair's part (its phase is off by up to 0.1 rad
    after 1 s). With Kelvin-Voigt damping late modes are gone. Round-off of a thousand steps: 2e-11 of an output's
    size.
    """
    case = oracle["steps"][name]
    values = start_values(oracle["plants"][case["loop"].replace("_no_control", "")])
    command = {"tau1": "tau1_cmd", "tau2": "tau2_cmd", "u": "u_cmd"}[case["input"]]
    step = 1e-3  # the plant's step is exact for a held command
    with CoSimulation([plant]) as alone:
        alone.set(order=order, **IDEAL, **values, **{command: case["amplitude"]})
        result = alone.run(1.0, step, record=("y_object", *SAME_NAMES))
    signals = {"y": result["y_object"] - 0.05, **{n: result[n] for n in SAME_NAMES}}
    for output, signal in signals.items():
        size = max(abs(row["outputs"][output]["value"]) for row in case["at"])
        for row in case["at"]:
            exact = row["outputs"][output]
            bound = exact["error"] + 2e-11 * size
            if "beyond" in exact:
                beyond = exact["beyond"]
                bound += beyond[order // 4] + 0.1 * beyond[order // 4 - 1]
            assert abs(signal[round(row["t"] / step)] - exact["value"]) <= bound, (output, row["t"])


def test_exact_step_does_not_depend_on_its_size(plant: Fmu) -> None:
    """A held command: 1000 steps of 1 ms and 37 of other sizes end in the same state."""
    sizes = {"fine": [1e-3] * 1000, "coarse": [0.025] * 36 + [0.1]}
    ends = {}
    for kind, steps in sizes.items():
        with plant.instantiate() as slave:
            slave.set(**IDEAL, tau1_cmd=0.05)
            slave.start()
            time = 0.0
            for size in steps:
                slave.step(time, size, 1)
                time += size
            ends[kind] = np.array(slave.get(*MEASURED))
    assert sum(sizes["fine"]) == pytest.approx(1.0)
    assert sum(sizes["coarse"]) == pytest.approx(1.0)
    # 1000 matrix products of 1e-16 each, modes of up to 1e5 rad/s: 1e-10 of each signal's size.
    assert ends["coarse"] == pytest.approx(ends["fine"], rel=1e-9, abs=1e-10)


@pytest.mark.parametrize(
    ("model", "command", "delivered"),
    [
        ("ideal", 5.0, 5.0),
        # (18): unity between the limits k_l (k_m - m_l) = -2.0 and k_r (k_M - m_r) = 2.0
        ("compensated", 1.3, 1.3),
        ("compensated", 0.05, 0.05),
        ("compensated", 5.0, 2.0),
        ("compensated", -5.0, -2.0),
        # saturation to +-2.1, then the dead zone of +-0.1
        ("raw", 1.3, 1.2),
        ("raw", 0.05, 0.0),
        ("raw", 5.0, 2.0),
        ("raw", -0.6, -0.5),
    ],
)
def test_actuator_models(model: str, command: float, delivered: float, plant: Fmu) -> None:
    with plant.instantiate() as slave:
        slave.set(actuator_model=model)
        slave.start()
        slave.set(tau1_cmd=command, tau2_cmd=-command)
        assert slave.get("tau1")[0] == pytest.approx(delivered, abs=1e-15)
        assert slave.get("tau2")[0] == pytest.approx(-delivered, abs=1e-15)
