"""Dynamic stiffness of one arm: moment and shear at its ends for given end motions, exactly.

In absolute coordinates Y = x theta - w the arm obeys rho s^2 Y + E Y'''' = 0 with Y(0) = 0, Y'(0) = theta, Y(l) = y,
Y''(l) = 0, where y = l theta - w(l) = y_M - L/2 by the constraint (12) and E = EI (1 + kappa s) with Kelvin-Voigt
damping. With beta^4 = -rho s^2 / E and a = beta l the solution is a combination of cos, sin, cosh, sinh of beta x.
Eliminating its coefficients leaves

    E w''(0)   = (2 E / l^2) (-p l theta + r y) / d
    E w'''(l)  = (E / l^3) (2 r l theta - q y) / d

with p, q, r, d below. All four are entire functions of a^4, so no branch of the fourth root matters, and they satisfy
p q - 2 r^2 = -a^4 d^2 / 2: the determinant of the stiffness is E rho s^2, free of cancellation. As s -> 0 the static
beam appears: E w''(0) = 3 EI (l theta - y) / l^2 and E w'''(l) = -3 EI (l theta - y) / l^3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from mpmath import mp


@dataclass(frozen=True)
class BeamFunctions:
    """The four functions of a = beta l in the stiffness; `scaled` ones share one positive factor."""

    p: Any  # sin a sinh a / a^2                        -> 1
    q: Any  # 1 + cos a cosh a                          -> 2
    r: Any  # (sin a + sinh a) / (2 a)                  -> 1
    d: Any  # (cos a sinh a - cosh a sin a) / a^3       -> -2/3


def beam_functions(a: Any) -> BeamFunctions:
    """The functions at the working precision of mpmath."""
    c, s, ch, sh = mp.cos(a), mp.sin(a), mp.cosh(a), mp.sinh(a)
    return BeamFunctions(s * sh / a**2, 1 + c * ch, (s + sh) / (2 * a), (c * sh - ch * s) / a**3)


def scaled_beam_functions(a: np.ndarray) -> BeamFunctions:
    """The functions in double precision times exp(-|Re a| - |Im a|), for a of any size (arrays).

    The factor is positive, so phases, which is all that counting zeros needs, are unchanged.
    """
    up, along = np.abs(a.imag), np.abs(a.real)
    c = (np.exp(1j * a - up) + np.exp(-1j * a - up)) / 2
    s = (np.exp(1j * a - up) - np.exp(-1j * a - up)) / 2j
    ch = (np.exp(a - along) + np.exp(-a - along)) / 2
    sh = (np.exp(a - along) - np.exp(-a - along)) / 2
    r = (s * np.exp(-along) + sh * np.exp(-up)) / (2 * a)
    return BeamFunctions(s * sh / a**2, np.exp(-up - along) + c * ch, r, (c * sh - ch * s) / a**3)
