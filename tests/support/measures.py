"""What is read off a response: settling time, overshoot."""

from __future__ import annotations

import numpy as np

from .harness import Result

# The static target of the paper: both contact forces at -lambda_1^d = 0.5 N.
FORCE = 0.5


def settling_time(time: np.ndarray, signal: np.ndarray, goal: float, band: float = 0.02) -> float:
    """First recorded time after which the signal stays in the band (a fraction of the goal); inf if it never does."""
    outside = np.flatnonzero(np.abs(signal - goal) > band * abs(goal))
    if outside.size == 0:
        return float(time[0])
    return float(time[outside[-1] + 1]) if outside[-1] + 1 < len(time) else float("inf")


def overshoot(signal: np.ndarray, goal: float) -> float:
    """How far the signal goes beyond the goal, as a fraction of it."""
    return max(0.0, float(np.max(signal * np.sign(goal))) / abs(goal) - 1.0)


def force_settling_times(result: Result) -> list[float]:
    """Settling times (2 %) of both contact forces."""
    return [settling_time(result.time, result[f"contact_force{arm}"], FORCE) for arm in (1, 2)]


def force_overshoot(result: Result) -> float:
    """The larger overshoot of the two contact forces."""
    return max(overshoot(result[f"contact_force{arm}"], FORCE) for arm in (1, 2))
