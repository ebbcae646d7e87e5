"""All zeros of a characteristic function in a part of the upper half plane, with proof that none is missing.

The number of zeros in a rectangle is the winding number of the function along its border (argument principle), taken in
double precision; rectangles are halved until each holds one zero, which Newton's method then finds and mpmath polishes.
The caller gets exactly as many zeros as were counted, or an error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpmath import mp, mpc

Function = Callable[[Any], Any]


@dataclass(frozen=True)
class Box:
    """A rectangle in the s-plane."""

    left: float
    right: float
    bottom: float
    top: float

    def halves(self, fraction: float) -> tuple[Box, Box]:
        """Cut across the longer side, at a fraction of it (so that a zero on the cut can be avoided)."""
        if self.right - self.left > self.top - self.bottom:
            cut = self.left + fraction * (self.right - self.left)
            return Box(self.left, cut, self.bottom, self.top), Box(cut, self.right, self.bottom, self.top)
        cut = self.bottom + fraction * (self.top - self.bottom)
        return Box(self.left, self.right, self.bottom, cut), Box(self.left, self.right, cut, self.top)

    def contains(self, s: complex) -> bool:
        """Whether s is inside."""
        return self.left < s.real < self.right and self.bottom < s.imag < self.top


class ZeroOnBorderError(Exception):
    """The function's phase can't be followed along a border: a zero is on it or very near."""


def count(f: Function, box: Box) -> int:
    """Number of zeros of the analytic `f` in the box."""
    corners = (
        complex(box.left, box.bottom),
        complex(box.right, box.bottom),
        complex(box.right, box.top),
        complex(box.left, box.top),
    )
    turns = sum(_phase_change(f, a, b) for a, b in zip(corners, (*corners[1:], corners[0]))) / (2 * np.pi)
    if abs(turns - round(turns)) > 1e-3:
        raise ZeroOnBorderError
    return round(turns)


def _phase_change(f: Function, start: complex, end: complex) -> float:
    """Change of arg f along a side, refining where it turns by more than 0.7 rad between two points.

    The first grid must be fine enough that a turn by a multiple of 2 pi can't pass for none. Sides along the real axis
    are up to 3e4 long and have zeros as near as 10 to their small |Re s| part, so points crowd there (sinh spacing).
    """
    if start.imag == end.imag:
        points = np.sinh(np.linspace(np.arcsinh(start.real), np.arcsinh(end.real), 2049)) + 1j * start.imag
    else:
        points = start + (end - start) * np.linspace(0, 1, 2049)
    values = f(points)
    for _ in range(60):
        steps = np.angle(values[1:] / values[:-1])
        coarse = np.flatnonzero(~(np.abs(steps) < 0.7))
        if coarse.size == 0:
            return float(steps.sum())
        middle = (points[coarse] + points[coarse + 1]) / 2
        points = np.insert(points, coarse + 1, middle)
        values = np.insert(values, coarse + 1, f(middle))
    raise ZeroOnBorderError


def zeros(f: Function, box: Box) -> list[complex]:
    """All zeros of `f` in the box, in double precision; two that it can't tell apart appear as two equal numbers."""
    return _zeros(f, box, count(f, box))


def _zeros(f: Function, box: Box, expected: int) -> list[complex]:
    if expected == 0:
        return []
    if expected == 1:
        zero = _newton(f, box)
        if zero is not None:
            return [zero]
    centre = complex(box.left + box.right, box.bottom + box.top) / 2
    if expected == 2 and max(box.right - box.left, box.top - box.bottom) < 1e-6 * abs(centre):
        return [centre, centre]
    for fraction in (0.4837, 0.5391, 0.4113, 0.6021):
        first, second = box.halves(fraction)
        try:
            counts = count(f, first), count(f, second)
        except ZeroOnBorderError:
            continue
        if sum(counts) == expected:
            return _zeros(f, first, counts[0]) + _zeros(f, second, counts[1])
    raise ArithmeticError(f"cannot separate the {expected} zeros in {box}")


def _newton(f: Function, box: Box) -> complex | None:
    """The zero in the box by secant steps from its centre, or None if they leave the box."""
    with mp.workdps(20):
        s0 = mpc(box.left + box.right, box.bottom + box.top) / 2
        s1 = s0 + mpc(box.right - box.left, box.top - box.bottom) / 1000
        f0, f1 = f(s0), f(s1)
        for _ in range(30):
            if f1 == f0:
                return None
            step = f1 * (s1 - s0) / (f1 - f0)
            s0, f0, s1 = s1, f1, s1 - step
            if not box.contains(complex(s1)):
                return None
            if abs(step) <= 1e-14 * abs(s1):
                return complex(s1)
            f1 = f(s1)
    return None


def polish(f: Function, guesses: list[complex]) -> list[Any]:
    """The zeros near the guesses to the working precision of mpmath; equal guesses are a close or a double pair."""
    polished = []
    for guess in dict.fromkeys(guesses):
        polished += [_secant(f, mpc(guess))] if guesses.count(guess) == 1 else _pair(f, mpc(guess))
    return [mpc(s.real, 0) if abs(s.imag) < mp.mpf(10) ** (5 - mp.dps) * abs(s) else s for s in polished]


def _secant(f: Function, start: Any) -> Any:
    zero = mp.findroot(f, (start, start * (1 + mp.mpf("1e-11"))), solver="secant", tol=0, maxsteps=40, verify=False)
    if abs(zero - start) > 1e-6 * abs(start):
        raise ArithmeticError(f"polishing {start} went to {zero}")
    return zero


def _pair(f: Function, start: Any) -> list[Any]:
    """Two zeros around the point where f' vanishes; a double zero twice."""
    with mp.extradps(mp.dps):
        middle = _secant(lambda s: mp.diff(f, s), start)
        half = mp.sqrt(-2 * f(middle) / mp.diff(f, middle, 2))
    if abs(half) < mp.mpf(10) ** (-mp.dps // 2) * abs(middle):
        return [middle, middle]
    return [
        mp.findroot(f, (middle + side, middle + side * 1.01), tol=0, maxsteps=40, verify=False)
        for side in (half, -half)
    ]
