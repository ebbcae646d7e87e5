"""A grasp that can open, as hosts may treat it: back and forth between bounces, with parameters at their limits and beyond, with steps
of a nanosecond and of a second."""

from __future__ import annotations

import math
from typing import Any

import pytest

from .support.slave import Fmu, FmuError, Slave

BOOKS = ("energy", "supplied_energy", "impact_loss")
SHOWN = (*BOOKS, "theta1", "theta2", "y_object", "gap1", "gap2", "contact_force1", "contact_force2", "indentation1", "indentation2")
BOUNCING: dict[str, Any] = {"contact_model": "unilateral", "restitution": 0.6, "theta1_0": -0.02, "theta2_0": 0.02}
SOFT: dict[str, Any] = {"contact_model": "compliant", "contact_stiffness1": 500.0, "theta1_0": -0.02, "theta2_0": 0.02}


def advance(slave: Slave, first: int, last: int, size: float = 1e-3) -> list[list[float]]:
    rows = []
    for i in range(first, last):
        slave.set(tau1_cmd=0.1 + 0.05 * math.sin(0.3 * i), tau2_cmd=-0.12, u_cmd=0.05 * math.cos(0.2 * i))
        slave.step(i * size, size, 1)
        rows.append([*slave.get(*SHOWN), *slave.get("impacts1", "impacts2")])
    return rows


@pytest.mark.parametrize("parameters", [BOUNCING, SOFT], ids=["bouncing", "soft"])
def test_back_to_any_moment_between_bounces(parameters: dict[str, Any], plant: Fmu) -> None:
    """Saved in flight, after one impact, among many: from there on the same bits, in this instance and in another one."""
    with plant.instantiate() as slave, plant.instantiate() as other:
        for one in (slave, other):
            one.set(**parameters)
            one.start()
        impacts = set()
        for start in range(0, 300, 50):
            state = slave.fmi.getFMUstate()
            blob = slave.fmi.serializeFMUstate(state)
            expected = advance(slave, start, start + 50)
            slave.fmi.setFMUstate(state)
            assert advance(slave, start, start + 50) == expected
            slave.fmi.freeFMUstate(state)
            copy = other.fmi.deSerializeFMUstate(blob)
            other.fmi.setFMUstate(copy)
            other.fmi.freeFMUstate(copy)
            assert advance(other, start, start + 50) == expected
            impacts.add(sum(expected[-1][-2:]))
        assert len(impacts) > 1, "there were no bounces to go back to"


def test_a_step_with_too_many_bounces_is_discarded_with_the_reason(plant: Fmu) -> None:
    """A ball of 0.3 kg on a tip of 0.1 kg that hardly anything holds, pushed with 300 N, nearly elastic: bounces of microseconds. The
    plant is as before, and a shorter step is done."""
    light = {f"{name}{arm}": 1e-9 for name in ("EI", "rho", "J") for arm in (1, 2)}
    with plant.instantiate() as slave:
        slave.set(**light, order=4, contact_model="unilateral", restitution=0.9999, plastic_speed=1e-9, actuator_model="ideal")
        slave.set(root_uncertainty=0.0, tip_uncertainty=0.0, theta1_0=-1e-4, theta2_0=0.5)
        slave.start()
        slave.set(u_cmd=-300.0)
        before = slave.get(*SHOWN)
        state = slave.fmi.getFMUstate()
        with pytest.raises(FmuError, match=r"status 2.*contacts switch more than .* take a shorter one"):
            slave.step(0.0, 50.0, 0)
        assert slave.get(*SHOWN) == before
        slave.fmi.setFMUstate(state)
        slave.fmi.freeFMUstate(state)
        slave.step(0.0, 1e-3, 1)
        assert slave.get(*SHOWN) != before


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("restitution", 1.0000001),
        ("restitution", -1e-9),
        ("restitution", math.nan),
        ("contact_stiffness1", 0.0),
        ("contact_stiffness2", -1.0),
        ("contact_stiffness2", math.inf),
        ("contact_damping1", -1e-12),
        ("contact_damping2", math.nan),
        ("plastic_speed", 0.0),
    ],
)
@pytest.mark.parametrize("model", ["bilateral", "unilateral", "compliant"])
def test_parameters_that_cannot_be_are_refused_by_name(name: str, value: float, model: str, plant: Fmu) -> None:
    """Also where the contact model does not use them: a typing error is one."""
    with plant.instantiate() as slave:
        with pytest.raises(Exception, match=r"."):
            slave.set(**{name: value}, contact_model=model)
            slave.start()
        assert any(name in message.text and message.status == 3 for message in slave.log)


@pytest.mark.parametrize(
    "parameters",
    [
        {"contact_model": "compliant", "contact_stiffness1": 1e9, "contact_damping1": 0.0},
        {"contact_model": "compliant", "contact_stiffness1": 1e-9, "contact_stiffness2": 1e-9},
        {"contact_model": "compliant", "contact_damping1": 0.0, "contact_damping2": 0.0},
        {"contact_model": "compliant", "contact_damping1": 1e4},
        {"contact_model": "unilateral", "restitution": 1.0, "plastic_speed": 1e-9},
        {"contact_model": "unilateral", "restitution": 1.0, "theta1_dot_0": 3.0, "theta2_dot_0": -3.0},
        {"contact_model": "unilateral", "theta1_0": 0.0, "theta2_0": 0.0, "y_object_dot_0": 1.0},
        {"contact_model": "unilateral", "m1": 1e-4, "M": 10.0},
    ],
    ids=str,
)
def test_limits_of_the_parameters(parameters: dict[str, Any], plant: Fmu) -> None:
    """Steps of all sizes with pushes that change sign: the books hold, nothing pulls, gaps are what (12) says; or the step is
    refused as too long, and a shorter one is done."""
    with plant.instantiate() as slave:
        slave.set(root_uncertainty=0.0, tip_uncertainty=0.0, theta1_0=-0.01, theta2_0=0.02, actuator_model="ideal")
        slave.set(**parameters)
        slave.start()
        start, now, done = slave.get("energy")[0], 0.0, 0
        for i, size in enumerate([1e-9, 1e-3, 0.1, 1.0, 1e-6, 0.02, 1e-3, 1e-4] * 3):
            sign = (-1) ** i
            slave.set(tau1_cmd=0.1 * sign, tau2_cmd=-0.1 * sign, u_cmd=0.2 * sign)
            state = slave.fmi.getFMUstate()
            try:
                slave.step(now, size, 0)
            except FmuError as error:
                assert "status 2" in str(error), error
                slave.fmi.setFMUstate(state)
                size = 1e-5
                slave.step(now, size, 0)
            slave.fmi.freeFMUstate(state)
            now, done = now + size, done + 1
            energy, supplied, lost, *_ = slave.get(*BOOKS)
            scale = energy + abs(supplied) + lost + start + 1e-6
            assert abs(energy - supplied + lost - start) < 1e-9 * scale
            values = slave.get("gap1", "gap2", "contact_force1", "contact_force2")
            assert all(math.isfinite(value) and value >= 0.0 for value in values)
            for side, sign_of_gap in ((1, -1.0), (2, 1.0)):
                phi, gap, pressed = slave.get(f"constraint{side}", f"gap{side}", f"indentation{side}")
                assert abs(sign_of_gap * phi + pressed - gap) < 1e-11 * (1.0 + abs(phi) + pressed)
        assert done == 24


@pytest.mark.parametrize("stop", [None, 0.05])
def test_what_was_lost_is_said_once_at_the_end(stop: float | None, plant: Fmu) -> None:
    with plant.instantiate(logging=True) as slave:
        slave.set(contact_model="unilateral")
        slave.fmi.setupExperiment(startTime=0.0, stopTime=stop)
        slave.fmi.enterInitializationMode()
        slave.fmi.exitInitializationMode()
        slave.set(u_cmd=0.3)

        def said() -> list[str]:
            return [message.text for message in slave.log if "contact lost" in message.text]

        for i in range(50):
            assert said() == []
            slave.step(i * 1e-3, 1e-3, 1)
        assert len(said()) == (0 if stop is None else 1)
        slave.fmi.terminate()
        assert len(said()) == 1
        assert "tip 1 once, seen from t = 0.001000 s to 0.050000 s" in said()[0]


def test_what_was_lost_within_steps_is_said_with_their_times(plant: Fmu) -> None:
    """Arms that are pressed onto the object chatter on it: at the end of the two long steps both tips touch again."""
    with plant.instantiate(logging=True) as slave:
        slave.set(contact_model="unilateral", theta1_0=-0.005, theta2_0=0.005)
        slave.start()
        slave.set(tau1_cmd=0.3, tau2_cmd=-0.3)
        slave.step(0.0, 0.02, 1)
        assert slave.get("impacts1", "impacts2") == [0, 0]
        slave.step(0.02, 0.5, 1)
        slave.step(0.52, 0.5, 1)
        assert slave.get("in_contact") == [True]
        slave.fmi.terminate()
        said = [message.text for message in slave.log if "contact lost" in message.text]
        assert len(said) == 1
        for tip in (1, 2):
            assert f"tip {tip} " in said[0]
        assert said[0].count("between communication points from t = 0.020000 s to ") == 2
