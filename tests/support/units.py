"""Base units of a unit expression such as N.m2 or rad/s, to compare what a unit means instead of what it is called."""

from __future__ import annotations

import re
from collections import Counter

_DERIVED = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "kg": {"kg": 1},
    "m": {"m": 1},
    "s": {"s": 1},
    "rad": {"rad": 1},
}


def base_units(expression: str) -> dict[str, int]:
    """Exponents of kg, m, s, rad; factors joined by dots, those after a slash divide."""
    numerator, _, denominator = expression.partition("/")
    exponents: Counter[str] = Counter()
    for part, sign in ((numerator, 1), (denominator, -1)):
        for factor in filter(None, part.split(".")):
            unit, power = re.fullmatch(r"([A-Za-z]+)(\d*)", factor).groups()
            for base, exponent in _DERIVED[unit].items():
                exponents[base] += sign * exponent * int(power or 1)
    return {base: exponent for base, exponent in exponents.items() if exponent}
