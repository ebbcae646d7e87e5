"""Time responses of the exact model: by residues, and (independently) by Talbot's and de Hoog's inversions.

A response X(s) has a pole at every eigenvalue and at s = 0. The sum over the eigenvalues converges algebraically
(theta ~ n^-6, moments ~ n^-4 with the paper's uncertainties). With Kelvin-Voigt damping the eigenvalues accumulate at
-1/kappa; there Talbot's contour converges exponentially instead. Without it the undamped ladder of eigenvalues makes
de Hoog's acceleration slow (degree 60 leaves 1e-7 of theta_1 at 0.05 s, degree 600 leaves 1e-10) and Talbot's contour
leaves poles out: they only check the residue sum there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from mpmath import mp, mpc, mpf

from .roots import Box, polish, zeros
from .system import OUTPUTS, Loads, System

LoadsOf = Callable[[Any], Loads]


def eigenvalue_bands(system: System, pairs: int, zero_multiplicity: int) -> list[list[Any]]:
    """All eigenvalues with Im s >= 0 except s = 0, up to the given number of pairs of beam modes.

    Band 0 holds the rigid and overdamped modes, band n the n-th pair of beam modes (roughly, if the arms differ).
    `zero_multiplicity` is that of the eigenvalue 0: 2 for the free plant (its rigid motion), 0 with position feedback.
    """

    def deflated(s: Any) -> Any:
        return system.characteristic(s) / s**zero_multiplicity

    kappa = system.plant.kelvin_voigt
    left = -0.9 / kappa if kappa else -3e4  # right of the eigenvalues' accumulation point -1/kappa
    borders = [-9.31, *(_gap(system, n) for n in range(pairs + 1))]
    bands = []
    for bottom, top in zip(borders, borders[1:]):
        found = polish(system.characteristic, zeros(deflated, Box(left, 51.7, bottom, top)))
        bands.append(sorted((zero for zero in found if zero.imag >= 0), key=lambda zero: (abs(zero), zero.real)))
    return bands


def _gap(system: System, n: int) -> float:
    """A frequency between the n-th and the next clamped-pinned mode of the faster arm."""
    plant = system.plant
    speed = float(np.sqrt(max(EI / rho for EI, rho in zip(plant.EI, plant.rho)))) / plant.l**2
    return speed * ((n + 0.62) * np.pi) ** 2


class ResidueSum:
    """The response to `loads` (with a pole of any order at 0) as a sum over the poles, for a simple spectrum."""

    def __init__(self, system: System, loads: LoadsOf, bands: Sequence[Sequence[Any]]) -> None:
        self._system, self._loads = system, loads
        self._bands = [[(s, self._residues(s)) for s in band] for band in bands]
        self._radius = min(abs(s) for band in bands for s in band) / 2

    def at(self, t: Any) -> dict[str, Any]:
        """The value of every output at t > 0."""
        values = self._at_zero(t)
        for name in OUTPUTS:
            terms = (_weight(s) * (r[name] * mp.exp(s * t)).real for band in self._bands for s, r in band)
            values[name] += mp.fsum(terms)
        return values

    def band_bounds(self, name: str, t: Any) -> list[Any]:
        """What the eigenvalues of each band can contribute to an output at most, near t."""
        return [
            mp.fsum(_weight(s) * abs(residues[name]) * mp.exp(s.real * t) for s, residues in band)
            for band in self._bands
        ]

    def _residues(self, s: Any) -> dict[str, Any]:
        with mp.extradps(20):
            step = abs(s) * mpf(10) ** (-mp.dps // 4)
            f = self._system.characteristic
            slopes = [(f(s + h) - f(s - h)) / (2 * h) for h in (step, step / 2)]
            slope = (4 * slopes[1] - slopes[0]) / 3  # Richardson: error of order step^4
            return {name: value / slope for name, value in self._system.adjugate(s, self._loads(s)).items()}

    def _at_zero(self, t: Any) -> dict[str, Any]:
        """Residue at s = 0: the trapezoidal rule on a circle, which converges geometrically."""
        points = 8 * mp.dps
        total = dict.fromkeys(OUTPUTS, mpc(0))
        for k in range(points):
            s = self._radius * mp.expjpi(mpf(2 * k + 1) / points)
            for name, value in self._system.outputs(s, self._loads(s)).items():
                total[name] += value * mp.exp(s * t) * s / points
        return {name: value.real for name, value in total.items()}


def _weight(s: Any) -> int:
    """A complex eigenvalue stands for its conjugate too."""
    return 1 if s.imag == 0 else 2


def invert(system: System, loads: LoadsOf, name: str, t: Any, method: str = "talbot", degree: int = 40) -> Any:
    """One output at t > 0 by numerical inversion of its Laplace transform (mpmath's Talbot or de Hoog)."""
    return mp.invertlaplace(lambda s: system.outputs(s, loads(s))[name], t, method=method, degree=degree)
