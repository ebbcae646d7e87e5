"""Derivatives that the FMUs provide, against differences of what they compute, and ramps against many small steps.

No tolerance here is chosen: every difference quotient is taken with several widths, and how much it changes from one to
the next, together with the round-off of the values it is made of, bounds its error.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from .support.capabilities import directional_derivative, input_slopes, output_slopes, restore, saved_state
from .support.contract import ACTUATORS, INSTRUMENTS, PAPER, PLANT
from .support.harness import Fmu, Slave
from .test_alone import direct_dependencies

EPS = np.finfo(float).eps

# Sizes of the signals in a grasp: random operating points are drawn from +- these.
INPUT_SIZES = {
    **{"tau1_cmd": 0.3, "tau2_cmd": 0.3, "u_cmd": 0.2, "delta_f1": 0.05, "delta_f2": 0.05, "delta_F": 0.05},
    **{"theta1": 0.05, "theta2": 0.05, "theta1_dot": 0.5, "theta2_dot": 0.5, "y_object": 0.05, "y_object_dot": 0.1},
    **{"root_moment1": 0.1, "root_moment2": 0.1, "tip_shear1": 0.5, "tip_shear2": 0.5},
    **{"tip_shear1_dot": 10.0, "tip_shear2_dot": 10.0, "lambda1_ref": 0.5, "theta1_ref": 0.05},
    **{"root_moment1_dot": 1.0, "root_moment2_dot": 1.0},
}
SIZES = {**INPUT_SIZES, "root_moment1_dot": 5.0, "root_moment2_dot": 5.0}
NETWORKS_OFF = {**PAPER, "a1": 0.0, "a31": 0.0, "a32": 0.0}
NETWORKS_ON = {
    **PAPER,
    **{"a1": 5.0, "a2": 0.1, "a31": 0.5, "a41": 0.1, "a32": 0.5, "a42": 0.1},
    **{"m_hat_0": 0.05, "J1_hat_0": 0.002, "J2_hat_0": 0.003},
}


@dataclass(frozen=True)
class Case:
    """An FMU with parameters, at operating points of a size (in units of INPUT_SIZES)."""

    name: str
    parameters: dict[str, float | str]
    size: float = 1.0

    def __str__(self) -> str:
        return "-".join([self.name, *(str(value) for value in self.parameters.values()), f"{self.size:g}"][:4])


CASES = [
    Case(PLANT, {"actuator_model": "ideal"}),
    Case(PLANT, {"actuator_model": "compensated", "k_r1": 1.3, "k_l1": 0.7}),
    Case(PLANT, {"actuator_model": "compensated", "EI2": 0.3}, size=30.0),  # most commands are beyond the limits
    Case(PLANT, {"actuator_model": "raw", "k_r1": 1.3, "k_l2": 0.7}),  # dead zone, slope
    Case(PLANT, {"actuator_model": "raw", "kelvin_voigt": 1e-3}, size=30.0),
    Case("PdController", {"EI2": 0.3}),
    Case("PdsController", {"EI2": 0.3}),
    Case("PdController", {"ki": 300.0, "ki1": 20.0, "rate_source": "estimated"}),
    Case("NabfcController", {"EI2": 0.3}),
    Case("NabfcController", {"r_strain_rate_bandwidth": 0.0}, size=0.1),
    Case("NabfcController", {"rate_source": "estimated"}),
    Case("NabfcController", {**PAPER, "rate_source": "estimated", "shear_rate_bandwidth": 0.0}),
    Case("NabfcController", PAPER),  # sat and tanh saturated
    Case("NabfcController", PAPER, size=1e-3),  # both near zero
    Case("NabfcController", {**NETWORKS_OFF, "shear_rate_bandwidth": 0.0}, size=0.1),
    Case("NabfcController", {**NETWORKS_ON, "EI2": 0.3, "shear_rate_bandwidth": 0.0}),
    Case("NabfcController", {**NETWORKS_ON, "shear_rate_bandwidth": 300.0}, size=0.1),
    Case("NabfcController", {**PAPER, "preset": "fast"}, size=0.1),
    # Without samples: at those, outputs jump.
    Case(INSTRUMENTS, {"theta1_bandwidth": 300.0, "tip_shear1_bias": 0.1}),
    Case(ACTUATORS, {"dead_zone_inverse": True, "k_r1": 1.3, "tau2_cmd_bandwidth": 300.0}),
]
each_case = pytest.mark.parametrize("case", CASES, ids=str)

POINTS = 4


@dataclass
class Point:
    """An instance somewhere in the middle of a run, with its inputs, and the slopes it might be given."""

    slave: Slave
    time: float
    inputs: dict[str, float]
    slopes: dict[str, float]


def operating_points(case: Case, fmu: Fmu) -> Iterator[Point]:
    """The instance in several states, by random inputs over steps of several sizes."""
    random = np.random.default_rng(2024)
    names = fmu.names("input", "Real")
    sizes = case.size * np.array([SIZES[name] for name in names])

    def draw() -> dict[str, float]:
        return dict(zip(names, (sizes * random.uniform(-1, 1, len(names))).tolist()))

    with fmu.instantiate() as slave:
        slave.set(**case.parameters)
        slave.start()
        time = 0.0
        for _ in range(POINTS):
            for step in (1e-4, 3e-3, 2e-2):
                slave.set(**draw())
                slave.step(time, step, 1)
                time += step
            inputs = draw()
            slave.set(**inputs)
            yield Point(slave, time, inputs, {name: 10.0 * value for name, value in draw().items()})


def input_terms(point: Point, outputs: list[str]) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Derivatives of the outputs by each input, and the sizes of the terms that the inputs have in them, added up."""
    derivatives = {n: np.array(directional_derivative(point.slave, outputs, {n: 1.0})) for n in point.inputs}
    return derivatives, sum(np.abs(derivatives[name] * value) for name, value in point.inputs.items())


# --- Directional derivatives -----------------------------------------------------------------------------------------


@each_case
def test_directional_derivatives(case: Case, fmus: dict[str, Fmu]) -> None:
    """Every output by every input: declared pairs against central differences, all others exactly zero.

    Widths are a ten-thousandth of the inputs' sizes and half of it: a kink (of sat, saturation or a dead zone) lies
    between them with a chance of 1e-4; none does for these random numbers.

    Rounding: an output is a sum of terms that may cancel, so it is rounded like the largest of them and not like itself. The terms
    of the inputs are derivative times input; what the state adds is what is left of the output, no more than both together.
    """
    fmu = fmus[case.name]
    outputs, declared = fmu.names("output", "Real"), direct_dependencies(fmus[case.name])
    reachable = 0
    for point in operating_points(case, fmu):
        read = point.slave.reader(outputs).read
        derivatives, terms = input_terms(point, outputs)
        for name, value in point.inputs.items():
            width = 1e-4 * case.size * SIZES[name]
            values = {}
            for factor in (-1.0, -0.5, 0.5, 1.0):
                point.slave.set(**{name: value + factor * width})
                values[factor] = np.array(read())
            point.slave.set(**{name: value})
            wide, narrow = (values[1.0] - values[-1.0]) / (2 * width), (values[0.5] - values[-0.5]) / width
            expected = (4 * narrow - wide) / 3
            noise = 8 * EPS * (np.abs(values[1.0]) + terms) / width
            bound = np.abs(narrow - wide) + noise
            found = derivatives[name]
            for i, output in enumerate(outputs):
                if name in declared[output]:
                    assert abs(found[i] - expected[i]) <= bound[i], (output, name)
                    # The bound says something.
                    assert bound[i] <= 1e-5 * abs(found[i]) + noise[i], (output, name)
                    reachable += found[i] != 0.0
                else:
                    assert found[i] == 0.0, (output, name)
                    assert np.all([v[i] == values[1.0][i] for v in values.values()]), (output, name)
    assert reachable > 0


@each_case
def test_directional_derivatives_are_linear(case: Case, fmus: dict[str, Fmu]) -> None:
    """Along any direction, and for any subset of the outputs, they add up; asking changes nothing."""
    fmu = fmus[case.name]
    outputs = fmu.names("output", "Real")
    for point in operating_points(case, fmu):
        before = point.slave.reader(outputs).read()
        units = [np.array(directional_derivative(point.slave, outputs, {name: 1.0})) for name in point.slopes]
        columns = [unit * slope for unit, slope in zip(units, point.slopes.values())]
        together = np.array(directional_derivative(point.slave, outputs, point.slopes))
        assert together == pytest.approx(sum(columns), rel=1e-12, abs=1e-13 * np.max(np.abs(columns)))
        some = directional_derivative(point.slave, outputs[::-3], point.slopes)
        assert some == list(together[::-3])
        assert point.slave.reader(outputs).read() == before


# --- Output derivatives ----------------------------------------------------------------------------------------------


@each_case
@pytest.mark.parametrize("ramped", [False, True], ids=["held", "ramped"])
def test_output_derivatives(case: Case, ramped: bool, fmus: dict[str, Fmu]) -> None:
    """First derivatives of all outputs against forward differences over steps of 80, 40 and 20 ns.

    Extrapolated twice, so what is left is the third power of (step x fastest mode, some 1e5 rad/s).
    """
    fmu = fmus[case.name]
    outputs = fmu.names("output", "Real")
    relative = []
    for point in operating_points(case, fmu):
        slave, read = point.slave, point.slave.reader(outputs).read
        ramp = input_slopes(slave, list(point.slopes))
        ramp.values[:] = [slope * ramped for slope in point.slopes.values()]
        ramp.write()
        found = np.array(output_slopes(slave, outputs).read())
        start = np.array(read())
        quotients = {}
        for step in (8e-8, 4e-8, 2e-8):
            with saved_state(slave) as state:
                slave.step(point.time, step, 0)
                quotients[step] = (np.array(read()) - start) / step
                restore(slave, state)
        coarse, middle, fine = quotients.values()
        first, second = 2 * middle - coarse, 2 * fine - middle
        expected = (4 * second - first) / 3
        # An output may be a sum of terms larger than itself: those of the inputs, and a tenth of the unit at the size of these
        # signals for what the state adds.
        noise = 16 * EPS * (np.abs(start) + input_terms(point, outputs)[1] + 0.1 * case.size) / 2e-8
        bound = np.abs(second - first) + noise
        for i, output in enumerate(outputs):
            assert abs(found[i] - expected[i]) <= bound[i], output
        relative += [b / abs(value) for b, value in zip(bound, found) if value != 0.0]
    if relative:
        assert np.median(relative) < 1e-4  # the bounds say something
    else:
        assert case.name in ("PdController", "PdsController")  # no state: outputs stand still with the inputs
        assert not ramped


# --- Input derivatives -----------------------------------------------------------------------------------------------

DURATION = 0.02

# Value at the start and slope. Commands of the plant: within all limits; and from one limit of an actuator through its
# dead zone to the other limit.
Ramp = dict[str, tuple[float, float]]
RAMPS: dict[str, Ramp] = {
    "linear": {"tau1_cmd": (0.1, 5.0), "tau2_cmd": (-0.2, 3.0), "u_cmd": (0.05, -4.0), "delta_F": (0.0, 2.0)},
    "kinks": {"tau1_cmd": (-3.0, 300.0), "tau2_cmd": (2.5, -110.0), "u_cmd": (0.5, -50.0), "delta_f1": (0.0, 1.0)},
}
# All inputs of a controller cross zero; the sliding variables pass the limits of sat.
CONTROLLER_RAMP = {
    name: (size * (0.3 - 0.05 * i), size * (4.0 * i - 30.0))
    for i, (name, size) in enumerate(list(INPUT_SIZES.items())[6:])
}


def end_of_ramp(fmu: Fmu, parameters: dict[str, Any], ramp: Ramp, panels: int, hold: str) -> np.ndarray:
    """All outputs after the ramps; over each panel the inputs are ramps themselves, or held at its `middle`."""
    start, slope = np.array(list(ramp.values())).T
    step = DURATION / panels
    with fmu.instantiate() as slave:
        slave.set(**parameters)
        slave.start()
        values, slopes = slave.writer(list(ramp)), input_slopes(slave, list(ramp))
        slopes.values[:] = slope
        for i in range(panels):
            values.values[:] = start + slope * (i + 0.5 * (hold == "middle")) * step
            values.write()
            if hold == "ramp":
                slopes.write()
            slave.step(i * step, step, 1)
        values.values[:] = start + slope * DURATION
        values.write()
        return np.array(slave.reader(fmu.names("output", "Real")).read())


def observed_order(panels: tuple[int, ...], errors: list[np.ndarray]) -> np.ndarray:
    """Slope of log error over log panel size, by least squares."""
    return -np.polyfit(np.log(panels), np.log(np.array(errors)), 1)[0]


@pytest.mark.parametrize("ramp", RAMPS)
@pytest.mark.parametrize("actuator", ["ideal", "compensated", "raw"])
def test_plant_follows_ramps_exactly(actuator: str, ramp: str, plant: Fmu) -> None:
    """One step along a ramp is any number of steps along it, to round-off, also through the kinks of the actuators."""
    one, some, many = (
        end_of_ramp(plant, {"actuator_model": actuator}, RAMPS[ramp], panels, "ramp") for panels in (1, 7, 1000)
    )
    # Constraints are zero up to round-off of lengths of 0.1 m.
    size = np.array([0.1 if "constraint" in n else v for n, v in zip(plant.names("output", "Real"), np.abs(many))])
    # Round-off of 1e-16 of the forces, as the fast modes (up to 1e5 rad/s) show it in the shear rates: 2e-10 measured.
    assert np.all(np.abs(some - one) <= 1e-9 * size)
    assert np.all(np.abs(many - one) <= 1e-9 * size)


@pytest.mark.parametrize("ramp", RAMPS)
def test_plant_ramp_is_the_limit_of_held_inputs(ramp: str, plant: Fmu) -> None:
    """Held at each panel's middle, the inputs lead to the same end with an error of second order.

    Where a kink lies in its panel is up to chance, and makes the single error: so the order is a mean over a factor 32.
    """
    names, parameters = plant.names("output", "Real"), {"actuator_model": "raw"}
    exact = end_of_ramp(plant, parameters, RAMPS[ramp], 1, "ramp")
    panels = (200, 400, 800, 1600, 3200, 6400)
    errors = [np.abs(end_of_ramp(plant, parameters, RAMPS[ramp], n, "middle") - exact) for n in panels]
    # Shears and moments follow modes that the coarsest panels of 0.1 ms do not resolve: their order shows later.
    slow = [names.index(n) for n in ("theta1", "theta2", "theta1_dot", "theta2_dot", "y_object", "energy")]
    order = observed_order(panels, [error[slow] for error in errors])
    assert order == pytest.approx(2.0, abs=0.05 if ramp == "linear" else 0.2)


@pytest.mark.parametrize("name", ["PdController", "PdsController"])
def test_ramped_inputs_end_where_the_ramp_ends(name: str, fmus: dict[str, Fmu]) -> None:
    """A law without state then answers to the end of the ramp as if it had been set; and the ramp is over."""
    ramp, outputs = CONTROLLER_RAMP, fmus[name].names("output", "Real")
    with fmus[name].instantiate() as ramped, fmus[name].instantiate() as told:
        for slave in (ramped, told):
            slave.start()
        ramped.set(**{n: start for n, (start, _) in ramp.items()})
        slopes = input_slopes(ramped, list(ramp))
        slopes.values[:] = [slope for _, slope in ramp.values()]
        slopes.write()
        ramped.step(0.0, DURATION, 1)
        told.set(**{n: start + slope * DURATION for n, (start, slope) in ramp.items()})
        assert ramped.get(*outputs) == told.get(*outputs)
        ramped.step(DURATION, DURATION, 1)
        assert ramped.get(*outputs) == told.get(*outputs)


@pytest.mark.parametrize("networks", [NETWORKS_OFF, NETWORKS_ON], ids=["adaptation", "networks"])
@pytest.mark.parametrize("bandwidth", [0.0, 300.0])
def test_adaptation_follows_ramps(bandwidth: float, networks: dict[str, float], fmus: dict[str, Fmu]) -> None:
    """The update laws along a ramp: both ways converge to one end, held inputs with order 2, ramps with order 4.

    4 is the order of the two Gauss points in which a step samples the forcing. Left out is what these ramps hardly
    change, so that its errors are round-off.
    """
    controller = fmus["NabfcController"]
    parameters = {"shear_rate_bandwidth": bandwidth, **networks}
    names = controller.names("output", "Real")
    shown = ["tau1_cmd", "tau2_cmd", "pi1_hat", "pi2_hat"] + (["U1_norm"] if networks is NETWORKS_ON else [])
    chosen = [names.index(name) for name in shown]
    panels, end = (16, 32, 64, 128), end_of_ramp(controller, parameters, CONTROLLER_RAMP, 4096, "ramp")[chosen]
    for hold, order in (("middle", 2.0), ("ramp", 4.0)):
        ends = [end_of_ramp(controller, parameters, CONTROLLER_RAMP, n, hold)[chosen] for n in panels]
        assert observed_order(panels, [np.abs(e - end) for e in ends]) == pytest.approx(order, abs=0.1)


# --- Directional derivatives in initialization mode ------------------------------------------------------------------


def initial_values(fmu: Fmu, start: dict[str, float | str | bool], outputs: list[str]) -> np.ndarray:
    """The outputs in initialization mode of a new instance with these start values."""
    slave = fmu.instantiate()
    try:
        slave.fmi.setupExperiment(startTime=0.0)
        slave.fmi.enterInitializationMode()
        slave.set(**start)
        return np.array(slave.reader(outputs).read())
    finally:
        slave.fmi.freeInstance()


@pytest.mark.parametrize("name", [PLANT, "PdController", "PdsController", "NabfcController", INSTRUMENTS, ACTUATORS])
def test_every_initial_dependency_has_its_derivative(name: str, fmus: dict[str, Fmu]) -> None:
    """Each output by each real known that InitialUnknowns lists for it, against central differences of new instances.

    The point is off rest and off the kinks of sat and saturation. Where a parameter stands at the end of its range, the
    difference is one-sided. A quantiser that is off (`lsb` = 0) has no derivative: it jumps as soon as it is on.
    """
    fmu = fmus[name]
    variables = fmu.variables
    outputs = fmu.names("output", "Real")
    inputs = fmu.names("input", "Real")
    point: dict[str, float | str | bool] = {
        known: 0.011 * SIZES.get(known, 1.0) * (i + 1) for i, known in enumerate(inputs)
    }
    point |= {"sample_time": 2e-3} if "sample_time" in variables else {}  # noise and delays need samples
    listed = {
        unknown.variable.name: {known.name for known in unknown.dependencies}
        for unknown in fmu.description.initialUnknowns
        if unknown.variable.causality == "output"
    }
    knowns = [v.name for v in variables.values() if v.type == "Real" and v.causality in ("input", "parameter")]
    knowns = [known for known in knowns if not known.endswith("_lsb")]
    slave = fmu.instantiate()
    compared = 0
    try:
        slave.fmi.setupExperiment(startTime=0.0)
        slave.fmi.enterInitializationMode()
        slave.set(**point)
        for known in knowns:
            unknowns = [output for output in outputs if known in listed[output]]
            if not unknowns:
                continue
            value = point.get(known, float(variables[known].start))
            size = abs(value) or SIZES.get(known, 1.0)
            low, high = (
                float(x) if x else y for x, y in zip((variables[known].min, variables[known].max), (-np.inf, np.inf))
            )
            quotients = []
            for width in (1e-4 * size, 5e-5 * size):
                right, left = min(value + width, high), max(value - width, low)
                values = [initial_values(fmu, point | {known: x}, unknowns) for x in (right, left)]
                quotients.append((values[0] - values[1]) / (right - left))
            # How much the quotient still changes, and the round-off of what it is made of: of all outputs, since a
            # small one is the difference of large ones.
            rounding = (
                1e3 * EPS * max(np.max(np.abs(values[0])), np.max(np.abs(quotients[1])) * abs(value)) / (5e-5 * size)
            )
            tolerance = 2 * np.abs(quotients[0] - quotients[1]) + rounding
            given = np.array(directional_derivative(slave, unknowns, {known: 1.0}))
            wrong = np.flatnonzero(np.abs(given - quotients[1]) > tolerance)
            assert not wrong.size, (known, [(unknowns[i], given[i], quotients[1][i]) for i in wrong])
            compared += len(unknowns)
    finally:
        slave.fmi.freeInstance()
    assert compared > len(outputs)
