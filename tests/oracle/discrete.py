"""Motion of the discrete plant to forty digits: what grasp-plant's steps are held to.

    python -m tests.oracle.discrete

writes `grasp-plant/tests/data/discrete.json` (some minutes). Unlike the rest of the oracle it knows the discretisation: moments
of degree k, velocities of degree k-2, both as exact polynomials with rational coefficients. From these the matrix of
moments, velocities, hubs, object, their travel, the travel's integral, forces and rates is put together in the physical
coordinates of docs/model.md (the Rust code turns them to separate the rigid motion), and its exponential is taken in sixty digits.
"""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

from mpmath import mp, mpf

DATA = Path(__file__).resolve().parents[2] / "grasp-plant" / "tests" / "data" / "discrete.json"

Polynomial = list[Fraction]

ARM = {"ei": 0.115, "rho": 0.054, "hub_inertia": 0.0073, "tip_mass": 0.1}
OTHER = {"ei": 0.4, "rho": 0.1, "hub_inertia": 0.02, "tip_mass": 0.05}
PLANT = {
    "arms": [ARM, ARM], "length": 0.2, "object_mass": 0.3, "root_uncertainty": 0.1, "tip_uncertainty": 0.05,
    "kelvin_voigt": 0.0, "order": 8,
}
CERTAIN = {"root_uncertainty": 0.0, "tip_uncertainty": 0.0}
PLANTS = [
    PLANT,
    {**PLANT, "order": 5, "arms": [ARM, OTHER]},
    {**PLANT, **CERTAIN, "arms": [OTHER, ARM]},
    {**PLANT, **CERTAIN, "kelvin_voigt": 2e-3},
    {**PLANT, "arms": [ARM, OTHER], "kelvin_voigt": 1e-4},
    {**PLANT, "order": 15},
    {**PLANT, "order": 24},
]
# Forces on hub 1, hub 2, object; their rates; duration. From rest.
MOTION = [
    ([0.1, -0.07, 0.2], [0.0, 0.0, 0.0], 0.02),
    ([0.3, 0.05, -0.1], [-4.0, 2.0, 3.0], 0.05),
    ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 1.0),
]


def times(p: Polynomial, q: Polynomial) -> Polynomial:
    product = [Fraction(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            product[i + j] += a * b
    return product


def derivative(p: Polynomial) -> Polynomial:
    return [i * a for i, a in enumerate(p)][1:] or [Fraction(0)]


def at(p: Polynomial, x: int) -> Fraction:
    return sum((a * x**i for i, a in enumerate(p)), Fraction(0))


def integral(p: Polynomial) -> Fraction:
    return sum((a / (i + 1) for i, a in enumerate(p)), Fraction(0))


def orthogonal(weight: Polynomial, count: int) -> list[Polynomial]:
    """Polynomials of degree 0 ... count-1, orthogonal on [0, 1] with this weight (Gram and Schmidt)."""
    found: list[Polynomial] = []
    for degree in range(count):
        p = [Fraction(0)] * degree + [Fraction(1)]
        for q in found:
            share = integral(times(weight, times(p, q))) / integral(times(weight, times(q, q)))
            p = [a - share * (q[i] if i < len(q) else 0) for i, a in enumerate(p)]
        found.append(p)
    return found


def exact(value: Fraction) -> Any:
    return mpf(value.numerator) / value.denominator


def system(plant: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
    """The matrix, and rows that read the outputs."""
    k, l = plant["order"], mpf(plant["length"])
    one_less = [Fraction(1), Fraction(-1)]
    # M = (1-xi) p(xi), orthogonal in the product without weight: p is orthogonal with weight (1-xi)^2.
    moments = [times(one_less, p) for p in orthogonal(times(one_less, one_less), k)]
    velocities = orthogonal([Fraction(1)], k - 1)
    size = 2 * k + 2 * (k - 1) + 15
    vel = [[2 * k + arm * (k - 1) + r for r in range(k - 1)] for arm in range(2)]
    hub = [4 * k - 2, 4 * k - 1]
    body = 4 * k
    travel, lag, force, rate = (list(range(4 * k + 1 + 3 * i, 4 * k + 4 + 3 * i)) for i in range(4))
    a = mp.zeros(size)
    kappa = mpf(plant["kelvin_voigt"])
    mass = sum(mpf(arm["tip_mass"]) for arm in plant["arms"]) + mpf(plant["object_mass"])
    root, tip, deflection = ([mp.zeros(1, size) for _ in range(2)] for _ in range(3))
    for i, arm in enumerate(plant["arms"]):
        ei, rho = mpf(arm["ei"]), mpf(arm["rho"])
        norm_m = [mp.sqrt(l / ei * exact(integral(times(m, m)))) for m in moments]
        norm_v = [mp.sqrt(rho * l * exact(integral(times(v, v)))) for v in velocities]
        for j, m in enumerate(moments):
            row = i * k + j
            root[i][row] = exact(at(m, 0)) / norm_m[j]
            tip[i][row] = exact(at(derivative(m), 1)) / (l * norm_m[j])
            # w(l) = int (l-x) M/EI dx
            deflection[i][row] = l * l / ei * exact(integral(times(one_less, m))) / norm_m[j]
            # eta(0) theta' + eta'(l) y' - int eta'' v
            a[row, hub[i]] = root[i][row]
            a[row, body] = tip[i][row]
            bend = derivative(derivative(m))
            for r, v in enumerate(velocities):
                a[row, vel[i][r]] = -exact(integral(times(bend, v))) / (l * norm_m[j] * norm_v[r])
    # Rates of the moments are now the rows; forces on the velocities are their transposes.
    rates = [a[row, :] for row in range(2 * k)]
    for i in range(2):
        for r in range(k - 1):
            for j in range(k):
                row = i * k + j
                gain = -rates[row][vel[i][r]]
                a[vel[i][r], row] += gain
                a[vel[i][r], :] += kappa * gain * rates[row]
    root_rate = [sum((root[i][row] * rates[row] for row in range(2 * k)), mp.zeros(1, size)) for i in range(2)]
    tip_rate = [sum((tip[i][row] * rates[row] for row in range(2 * k)), mp.zeros(1, size)) for i in range(2)]
    ei = [mpf(arm["ei"]) for arm in plant["arms"]]
    for i in range(2):
        inertia = mpf(plant["arms"][i]["hub_inertia"])
        a[hub[i], :] = -(root[i] + kappa * root_rate[i] + mpf(plant["root_uncertainty"]) * root_rate[i]) / inertia
        a[hub[i], force[i]] += 1 / inertia
        a[body, :] -= (tip[i] + kappa * tip_rate[i]) / mass
        a[body, :] -= mpf(plant["tip_uncertainty"]) * sum(ei) / ei[i] * tip_rate[i] / mass
    a[body, force[2]] += 1 / mass
    for i, velocity in enumerate([*hub, body]):
        a[travel[i], velocity] = 1
        a[lag[i], travel[i]] = 1
        a[force[i], rate[i]] = 1
    places = {"travel": travel, "lag": lag, "force": force, "rate": rate, "hub": hub, "body": body}
    rows = {"root": root, "tip": tip, "tip_rate": tip_rate, "deflection": deflection, "mass": mass}
    return a, {**places, **rows}


def exponential_less_one(matrix: Any) -> Any:
    """exp(X) - 1 by series and doubling."""
    norm = mp.mnorm(matrix, 1)
    doublings = max(0, int(mp.ceil(mp.log(norm, 2))) + 3)
    x = matrix / mpf(2) ** doublings
    total, term, m = x.copy(), x.copy(), 1
    while mp.mnorm(term, 1) > mpf(10) ** -(mp.dps + 5):
        m += 1
        term = term * x / m
        total += term
    for _ in range(doublings):
        total = total * total + 2 * total
    return total


def reference(plant: dict[str, Any]) -> dict[str, Any]:
    a, part = system(plant)
    n = 4 * plant["order"] + 1
    state = mp.zeros(a.rows, 1)
    position, supplied = [mpf(0)] * 3, mpf(0)
    ends = []
    for forces, slopes, duration in MOTION:
        for i in range(3):
            state[part["travel"][i]] = state[part["lag"][i]] = mpf(0)
            state[part["force"][i]], state[part["rate"][i]] = mpf(forces[i]), mpf(slopes[i])
        state += exponential_less_one(a * mpf(duration)) * state
        for i in range(3):
            moved, lag = state[part["travel"][i]], state[part["lag"][i]]
            position[i] += moved
            supplied += mpf(forces[i]) * moved + mpf(slopes[i]) * (mpf(duration) * moved - lag)
        read = {name: [(row * state)[0] for row in part[name]] for name in ("root", "tip", "tip_rate", "deflection")}
        energy = sum((state[i] ** 2 for i in range(n - 3)), mpf(0))
        for i, arm in enumerate(plant["arms"]):
            energy += mpf(arm["hub_inertia"]) * state[part["hub"][i]] ** 2
        energy += part["mass"] * state[part["body"]] ** 2
        values = {
            "theta": position[:2], "theta_dot": [state[i] for i in part["hub"]],
            "y_object": position[2:], "y_object_dot": [state[part["body"]]],
            "root_moment": read["root"], "tip_shear": read["tip"], "tip_shear_dot": read["tip_rate"],
            "tip_deflection": read["deflection"], "energy": [energy / 2], "supplied_energy": [supplied],
        }
        ends.append({name: [float(value) for value in both] for name, both in values.items()})
    return {"plant": plant, "ends": ends}


def main() -> None:
    mp.dps = 60
    results = []
    for plant in PLANTS:
        results.append(reference(plant))
        print(f"order {plant['order']} done", flush=True)
    motion = [{"forces": f, "rates": r, "duration": d} for f, r, d in MOTION]
    DATA.parent.mkdir(exist_ok=True)
    DATA.write_text(json.dumps({"motion": motion, "plants": results}, indent=1) + "\n")


if __name__ == "__main__":
    main()
