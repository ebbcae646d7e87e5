"""Derivatives that the FMUs provide, against differences of what they compute.

No tolerance here is chosen: every difference quotient is taken with several widths, and how much it changes from one to
the next, together with the round-off of the values it is made of, bounds its error.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from .support.capabilities import directional_derivative, input_slopes, output_slopes, restore, saved_state
from .support.contract import ACTUATORS, INSTRUMENTS, PAPER, PLANT
from .support.harness import Fmu, Slave
from .support.operating_points import INPUT_SIZES, NETWORKS_OFF, NETWORKS_ON
from .test_alone import direct_dependencies

EPS = np.finfo(float).eps

SIZES = {**INPUT_SIZES, "root_moment1_dot": 5.0, "root_moment2_dot": 5.0}


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
