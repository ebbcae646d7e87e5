"""Extreme but legal: parameters over many decades, steps from nanoseconds to minutes, a million steps.

A bound states what physics allows: a conservative plant keeps the energy it was given, the constraint is an invariant,
and a linear loop that is sampled fast enough settles.
"""

from __future__ import annotations

import csv
import math
from typing import Any

import numpy as np
import pytest

from .support.capabilities import output_slopes
from .support.contract import CONTROLLERS, FMUS, MEASURED, PAPER
from .support.harness import CoSimulation, Fmu, FmuError
from .support.tool import dualarm

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
