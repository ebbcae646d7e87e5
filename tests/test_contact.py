"""A grasp that can open, against solutions that share nothing with the FMU: the continuous beam's own modes, an event-driven motion
by eigenvectors, and scipy's integration of compliant contacts."""

from __future__ import annotations

import numpy as np
import pytest

from .oracle.contact import Grasp, exact_free_arm
from .support.harness import Fmu

FREE = {"root_uncertainty": 0.0, "tip_uncertainty": 0.0, "actuator_model": "ideal"}


def away(gaps: tuple[float, float], l: float = 0.2) -> dict[str, float]:  # noqa: E741
    """Start angles of straight arms this far from the object."""
    return {"theta1_0": -gaps[0] / l, "theta2_0": gaps[1] / l}


def test_a_free_arm_arrives_when_the_continuous_beam_does(plant: Fmu) -> None:
    """Until the first impact the arm is a beam with hub and tip mass: its own modes say when it comes and how fast, and
    momentum what object and tip do afterwards."""
    time, speed = exact_free_arm(torque=0.1, gap=0.004, modes=15)
    with plant.instantiate() as slave:
        slave.set(**FREE, contact_model="unilateral", order=12, **away((0.004, 0.05)), tau1_cmd=0.1)
        slave.start()
        # The modes beyond the fifteenth and the discretisation's error are both below 1e-9 s.
        slave.fmi.doStep(0.0, time - 1e-9)
        assert slave.get("impacts1", "y_object_dot") == [0, 0.0]
        slave.fmi.doStep(time - 1e-9, 2e-9)
        assert slave.get("impacts1") == [1]
        together = speed * 0.1 / (0.1 + 0.3)
        assert slave.get("y_object_dot")[0] == pytest.approx(together, rel=1e-6)
        assert slave.get("impact_loss")[0] == pytest.approx(0.5 * 0.1 * 0.3 / 0.4 * speed**2, rel=1e-6)


def test_switches_come_when_eigenvectors_and_bisection_say(plant: Fmu) -> None:
    """Impacts and openings of both sides, one by one: times to a nanosecond."""
    grasp, g = Grasp(), np.array([0.1, -0.12, 0.0])
    x, gaps = grasp.start((0.004, 0.006))
    _, _, switches = grasp.rigid(x, gaps, g, stop=0.1016, spacing=1e-5)
    assert [what for _, _, what in switches[:3]] == ["closes", "opens", "closes"]
    assert len(switches) == 4
    with plant.instantiate() as slave:
        slave.set(**FREE, contact_model="unilateral", **away((0.004, 0.006)), tau1_cmd=0.1, tau2_cmd=-0.12)
        slave.start()
        now = 0.0
        impacts = 0
        for time, side, what in switches:
            assert side == 0
            slave.fmi.doStep(now, time - 1e-9 - now)
            before = slave.get("impacts1", "gap1")
            slave.fmi.doStep(time - 1e-9, 2e-9)
            after = slave.get("impacts1", "gap1")
            now = time + 1e-9
            assert before[0] == impacts
            if what == "closes":
                impacts += 1
                assert before[1] > 0.0
            assert after[0] == impacts
            assert (after[1] == 0.0) == (what == "closes") or after[1] < 1e-15


@pytest.mark.parametrize("damping", [2.0, 30.0])
def test_compliant_contacts_are_those_of_scipy(damping: float, plant: Fmu) -> None:
    """Approach, both impacts, faces that are pressed, left and met again: to scipy's tolerance."""
    gaps, torque, stop = (0.004, 0.006), (0.1, -0.12), 0.2
    reference, switches, loss = Grasp(damping=damping).compliant(gaps, np.array([*torque, 0.0]), stop, tolerance=1e-10)
    size = Grasp().matrices["size"]
    with plant.instantiate() as slave:
        slave.set(**FREE, contact_model="compliant", **away(gaps), tau1_cmd=torque[0], tau2_cmd=torque[1])
        slave.set(contact_damping1=damping, contact_damping2=damping)
        slave.start()
        for i in range(200):
            slave.fmi.doStep(i * 1e-3, 1e-3)
        assert sum(slave.get("impacts1", "impacts2")) == sum(1 for k, (_, side) in enumerate(switches) if sum(s == side for _, s in switches[:k]) % 2 == 0)
        assert slave.get("y_object_dot")[0] == pytest.approx(reference[size - 1] / np.sqrt(0.3), abs=1e-7)
        assert slave.get("indentation1", "indentation2") == pytest.approx(reference[size + 2 : size + 4], abs=1e-8)
        assert slave.get("impact_loss")[0] == pytest.approx(loss, rel=1e-6)
        forces = [1000.0 * reference[size + 2 + i] - damping * (Grasp().matrices["opening"][i] @ reference[:size]) for i in range(2)]
        touching = [sum(side == i for _, side in switches) % 2 == 1 for i in range(2)]
        expected = [force if touch else 0.0 for force, touch in zip(forces, touching)]
        assert slave.get("contact_force1", "contact_force2") == pytest.approx(expected, abs=1e-5)
