"""Ramped inputs: the plant follows them exactly, laws end where the ramp ends, and adaptation is the limit of many small steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from .support.capabilities import input_slopes
from .support.harness import Fmu
from .support.operating_points import INPUT_SIZES, NETWORKS_OFF, NETWORKS_ON

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
