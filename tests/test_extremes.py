"""Extreme but legal: parameters over many decades, steps from nanoseconds to minutes, inputs near the end of all numbers.

A bound states what physics allows: a conservative plant keeps the energy it was given.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from .support.contract import CONTROLLERS, FMUS, MEASURED, PAPER
from .support.harness import CoSimulation, Fmu, FmuError

SUBNORMAL = np.finfo(float).tiny
LENGTHS = ("y_object", "tip_deflection1", "tip_deflection2")

CONSERVATIVE = {"root_uncertainty": 0.0, "tip_uncertainty": 0.0}
# EI over six decades (with the default in between), alike and far apart; nearly massless bodies and beams; high order.
SOFT, STIFF = {"EI1": 1e-4, "EI2": 1e-4}, {"EI1": 1e2, "EI2": 1e2}
MASSLESS = {"m1": 1e-6, "m2": 1e-6, "M": 1e-6}
PLANTS: dict[str, dict[str, float]] = {
    "default": {},
    "soft": SOFT,
    "stiff": STIFF,
    "soft_and_stiff": {"EI1": 1e-4, "EI2": 1e2},
    "massless": MASSLESS,
    "order_24": {"order": 24},
    "order_4": {"order": 4},
    "light_beams": {"rho1": 1e-6, "rho2": 1e-6},
    "light_hubs": {"J1": 1e-6, "J2": 1e-6},
    "short": {"l": 1e-2},
    "long": {"l": 10.0},
    "everything": {"EI1": 1e-4, "EI2": 1e2, **MASSLESS, "order": 24},
}
DAMPING: dict[str, dict[str, float]] = {
    "conservative": CONSERVATIVE,
    "uncertain": {},
    "kelvin_voigt": {"kelvin_voigt": 1e-3},
    "very_viscous": {"kelvin_voigt": 1.0, **CONSERVATIVE},
}
STEPS = (1e-9, 1e-7, 1e-4, 1e-2, 1.0)


@pytest.mark.parametrize("damping", DAMPING)
@pytest.mark.parametrize("case", PLANTS)
def test_plant_stays_finite_and_bounded(case: str, damping: str, plant: Fmu) -> None:
    """A pulse of torques and force, then 180 free steps of each size.

    Energy: without uncertainties never more than was supplied, and equal to it if nothing is viscous (1e-12 of it: 200
    products of matrices with errors of 1e-16, times the spread of the time constants). The uncertainties of Section IV
    are no dampers: where one arm is a million times stiffer than the other, its force answers to the other's rate, and
    the plant holds up to 18 times what was supplied.
    """
    parameters = {**PLANTS[case], **DAMPING[damping]}
    names, pulse = plant.names("output", "Real"), {"tau1_cmd": 0.05, "tau2_cmd": -0.03, "u_cmd": 0.1}
    # The stiffest plant does longer steps in thousands of parts, see `test_plant_takes_any_step`.
    limit = 1e-4 if case == "everything" else 1.0
    for step in (step for step in STEPS if step <= limit):
        with CoSimulation([plant]) as alone:
            alone.set(actuator_model="ideal", **parameters)
            result = alone.run(
                200 * step,
                step,
                names,
                drive=lambda t, step=step: {name: value * (t < 19.5 * step) for name, value in pulse.items()},
            )
        for name in names:
            assert np.all(np.isfinite(result[name])), (step, name)
        energy, supplied = result["energy"], result["supplied_energy"]
        scale = np.max(np.abs(supplied))
        if damping in ("conservative", "very_viscous"):
            assert np.max(energy - supplied) <= 1e-12 * scale, step
        if damping == "conservative":
            assert np.max(np.abs(energy - supplied)) <= 1e-12 * scale, step
        assert np.max(energy) <= 30 * scale, step
        length = max(0.1, *(np.max(np.abs(result[name])) for name in LENGTHS))
        length = max(length, *(np.max(np.abs(result[f"theta{i}"])) * parameters.get("l", 0.2) for i in (1, 2)))
        for arm in (1, 2):
            assert np.max(np.abs(result[f"constraint{arm}"])) <= 1e-14 * length, step


@pytest.mark.parametrize("size", [1e-12, 1e-3, 1.0, 1e3, 1e9])
@pytest.mark.parametrize("name", CONTROLLERS)
def test_controllers_take_any_step(name: str, size: float, fmus: dict[str, Fmu]) -> None:
    """Estimates follow their exact solution, however long: they end where the leakage holds them."""
    with fmus[name].instantiate() as slave:
        slave.set(**PAPER, a1=5.0, a31=5.0, a32=5.0) if name == "NabfcController" else None
        slave.start()
        slave.set(theta1=0.1, y_object=0.04, tip_shear1_dot=3.0, tip_shear2=-1.0)
        slave.step(0.0, size, 1)
        values = slave.get(*fmus[name].names("output", "Real"))
        assert all(map(math.isfinite, values))
        assert max(map(abs, values)) < 1e6


@pytest.mark.parametrize("size", [1.1e9, 1e153, 1e300])
@pytest.mark.parametrize("name", CONTROLLERS)
def test_controllers_refuse_longer_steps(name: str, size: float, fmus: dict[str, Fmu]) -> None:
    """A reason and no NaN, and the instance goes on as if nothing had been asked."""
    outputs = fmus[name].names("output", "Real")
    with fmus[name].instantiate(logging=True) as slave:
        slave.start()
        slave.set(theta1=0.1, tip_shear2=-1.0)
        before = slave.get(*outputs)
        with pytest.raises(FmuError):
            slave.step(0.0, size, 1)
        assert "longer than 1e9 s" in slave.log[-1].text
        assert slave.get(*outputs) == before


@pytest.mark.parametrize("case", ["default", "order_24", "stiff", "everything"])
@pytest.mark.parametrize("size", [1e-4, 0.1, 10.0])
def test_plant_takes_any_step(size: float, case: str, plant: Fmu) -> None:
    with plant.instantiate() as slave:
        slave.set(**PLANTS[case])
        slave.start()
        slave.step(0.0, size, 1)


@pytest.mark.parametrize("magnitude", [1e9, 1e100, 1e300])
@pytest.mark.parametrize("name", FMUS)
def test_huge_inputs(name: str, magnitude: float, fmus: dict[str, Fmu]) -> None:
    """Either a step with finite results, or one that is refused with a reason; never an infinity or a NaN."""
    outputs = fmus[name].names("output", "Real")
    with fmus[name].instantiate(logging=True) as slave:
        if "actuator_model" in fmus[name].variables:
            slave.set(actuator_model="ideal")
        slave.start()
        slave.log.clear()
        try:
            for i in range(5):
                slave.set(**dict.fromkeys(fmus[name].names("input"), magnitude))
                assert all(map(math.isfinite, slave.get(*outputs)))
                slave.step(i * 1e-3, 1e-3, 1)
                assert all(map(math.isfinite, slave.get(*outputs)))
        except FmuError:
            assert magnitude > 1e9
            assert slave.log[-1].text


def test_many_step_sizes(plant: Fmu) -> None:
    """Matrices of the last few sizes are kept. A thousand sizes, then an old one: the same bits as computed anew."""
    sizes = [1e-4 * (1 + i / 1000) for i in range(1000)]
    with plant.instantiate() as much_used, plant.instantiate() as fresh:
        for slave in (much_used, fresh):
            slave.set(tau1_cmd=0.05, y_object_0=0.052)
            slave.start()
        time = 0.0
        for size in sizes:
            much_used.step(time, size, 1)
            time += size
        # A restart keeps what was computed; the fresh instance computes it.
        much_used.fmi.reset()
        much_used.set(tau1_cmd=0.05, y_object_0=0.052)
        much_used.start()
        for i in range(20):
            for slave in (much_used, fresh):
                slave.step(i * sizes[0], sizes[0], 1)
        assert much_used.get(*MEASURED) == fresh.get(*MEASURED)


# --- Numbers near the end of all numbers ------------------------------------------------------------------------------

LARGEST = np.finfo(float).max
# The powers of ten in which inputs are drawn, and what stands at the ends.
EXTREMES = (0.0, SUBNORMAL, 5e-324, 1.0, 1e50, 1e100, 1e154, 1.4e154, 1e200, 1e300, LARGEST / 2, LARGEST)


@pytest.mark.parametrize("name", FMUS)
def test_every_output_is_finite_or_the_step_is_refused(name: str, fmus: dict[str, Fmu]) -> None:
    """Inputs drawn from the whole range of numbers, each for itself, and steps of many sizes.

    After a step every output is finite. Before it, one that answers an input at once may overflow: then the step is
    refused, with a reason, and a reset leads on.
    """
    random = np.random.default_rng(11)
    inputs, outputs = fmus[name].names("input", "Real"), fmus[name].names("output", "Real")
    refused = 0
    with fmus[name].instantiate(logging=True) as slave:
        for _ in range(150):
            slave.fmi.reset()
            if "actuator_model" in fmus[name].variables:
                slave.set(actuator_model=str(random.choice(["ideal", "compensated", "raw"])))
            slave.start()
            slave.log.clear()
            time = 0.0
            # Half of the runs have a few large inputs among usual ones.
            few = random.random() < 0.5
            overflows = False
            try:
                for _ in range(4):
                    values = random.choice(EXTREMES, len(inputs)) * random.choice([-1.0, 1.0], len(inputs))
                    if few:
                        values = np.where(random.random(len(inputs)) < 0.2, values, random.normal(size=len(inputs)))
                    size = float(random.choice([1e-6, 1e-4, 1e-3, 0.1]))
                    slave.set(**dict(zip(inputs, map(float, values))))
                    overflows = not all(map(math.isfinite, slave.get(*outputs)))
                    slave.step(time, size, 1)
                    time += size
                    assert not overflows, "a step from values that are no numbers"
                    assert all(map(math.isfinite, slave.get(*outputs)))
            except FmuError:
                refused += 1
                assert slave.log[-1].text
                slave.fmi.reset()
                slave.start()
                slave.step(0.0, 1e-4, 1)
                assert all(map(math.isfinite, slave.get(*outputs)))
    assert refused < 150 or name in CONTROLLERS, "controllers refuse what is beyond 1e50 in any input"
