"""Grasps that can open, for model exchange: the cases, and the plant alone as a system that keeps what it sees at its events."""

from __future__ import annotations

from typing import Any

import numpy as np

from .exchange import Grasp, Model

UNILATERAL, COMPLIANT = 2, 3
FREE: dict[str, Any] = {"root_uncertainty": 0.0, "tip_uncertainty": 0.0}
# 0.8 and 1.2 mm away, both coming.
AWAY: dict[str, Any] = {"theta1_0": -0.004, "theta2_0": 0.006, "theta1_dot_0": 0.5, "theta2_dot_0": -0.6}
# What 0.1 N.m on both hubs hold.
HELD: dict[str, Any] = {"theta1_0": 0.1 * 0.2 / (3 * 0.115), "theta2_0": -0.1 * 0.2 / (3 * 0.115)}
SQUEEZE: dict[str, Any] = {"tau1_cmd": 0.1, "tau2_cmd": -0.12}
CASES: dict[str, dict[str, Any]] = {
    "plastic": {"contact_model": UNILATERAL, **AWAY, **SQUEEZE},
    "bouncing": {"contact_model": UNILATERAL, "restitution": 0.5, **AWAY, **SQUEEZE},
    "soft": {"contact_model": COMPLIANT, "contact_stiffness1": 5000.0, "contact_damping2": 2.0, **AWAY, **SQUEEZE},
    "undamped": {"contact_model": COMPLIANT, "contact_damping1": 0.0, "contact_damping2": 0.0, **AWAY, **SQUEEZE},
    "pulled off": {"contact_model": UNILATERAL, **HELD, "tau1_cmd": -1.5, "tau2_cmd": 1.2},
    "pulled off soft faces": {"contact_model": COMPLIANT, **HELD, "tau1_cmd": -1.5, "tau2_cmd": 1.2},
    "jerked out": {"contact_model": UNILATERAL, **HELD, "tau1_cmd": 0.1, "tau2_cmd": -0.1, "delta_F": 3.0},
}
SHOWN = (
    *("theta1", "theta2", "y_object", "theta1_dot", "y_object_dot", "root_moment1", "contact_force1", "contact_force2"),
    *("gap1", "gap2", "indentation1", "indentation2", "impact_loss", "energy"),
)
COUNTS = ("impacts1", "impacts2")


class Nothing:
    """No controller."""

    size, nominals, states, derivatives = 0, np.zeros(0), (), ()

    def set_time(self, _t: float) -> None:
        """Nothing."""

    def step_completed(self) -> tuple[bool, bool]:
        """No wish."""
        return False, False


class Alone(Grasp):
    """The plant with inputs that stand still, as one system; keeps what was seen at its events."""

    def __init__(self, plant: Model) -> None:  # pylint: disable=super-init-not-called
        self.plant, self.controller, self.split = plant, Nothing(), plant.size
        self.shown, self.seen = plant.reader(SHOWN), []

    def start(self) -> np.ndarray:
        """From instantiated to continuous-time mode."""
        self.plant.start()
        return self.plant.x

    def put(self, z: np.ndarray) -> None:
        """Sets the states."""
        self.plant.x = z

    def rates(self, _t: float, z: np.ndarray) -> np.ndarray:
        """The derivatives."""
        self.put(z)
        return self.plant.rates()

    def jacobian(self, _t: float, z: np.ndarray) -> np.ndarray:
        """Their derivatives by the states."""
        self.put(z)
        return self.plant.jacobian(self.plant.derivatives, self.plant.states)

    def indicators(self, z: np.ndarray) -> np.ndarray:
        """The event indicators."""
        self.put(z)
        return self.plant.indicators()

    def event(self) -> np.ndarray:
        """Updates the discrete states; what was there before and after."""
        before, counts = dict(zip(SHOWN, self.shown.read())), self.plant.get(*COUNTS)
        x = self.plant.x
        info = self.plant.update()
        after = dict(zip(SHOWN, self.shown.read()))
        self.seen.append((before, after, counts, self.plant.get(*COUNTS)))
        assert bool(info.nominals) is False and bool(info.has_next_time) is False
        changed = [name for name, old, new in zip(self.plant.states, x, self.plant.x) if abs(old - new) > 1e-12]
        assert all(name.startswith(("clearance", "impact_loss")) for name in changed), changed
        return self.plant.x


def touches(z: np.ndarray) -> np.ndarray:
    """The indicators of both contacts."""
    return z[12:]


def in_a_mode(model: Model, touching: tuple[bool, bool], kind: int) -> None:
    """Starts the plant with these tips on the object, and moves it away from rest."""
    angles = [(0.01 if touches else -0.02) for touches in touching]
    model.set(contact_model=kind, theta1_0=angles[0], theta2_0=-angles[1], theta1_dot_0=0.1, **SQUEEZE)
    model.start()
    x = model.x + 1e-3 * model.nominals * np.sin(np.arange(model.size))
    model.x = x
