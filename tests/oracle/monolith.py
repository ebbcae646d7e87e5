"""Plant and controller as one stiff ODE: own matrices, own laws, a tight tolerance; no co-simulation.

The plant is discretised like the FMU's (mixed moment-velocity form, order k) but from other bases and without its
energy coordinates: M_i(x) = (1 - x/l) sum a_j P_j, v_i = sum b_r P_r with Legendre's P. So what differs between this
solution and a co-simulation is the coupling alone, whatever the order.

    python -m tests.oracle.monolith      writes dualarm/data/verify/closed_loop.json (needs SciPy)
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.polynomial import Polynomial, legendre

from . import DATA
from .laws import Linear, Nabfc

FILE = DATA / "closed_loop.json"
DESCRIPTIONS = Path(__file__).resolve().parents[2] / "modelDescription"
OUTPUTS = ("theta1", "theta2", "y_object", "root_moment1", "tip_shear1", "contact_force1", "contact_force2")


@dataclass(frozen=True)
class Matrices:
    """x' = A x + B g with x = (a_1, a_2, b_1, b_2, theta_dot, y_dot, theta, y - L/2); measured = C x + offset."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    offset: np.ndarray
    contact: tuple[np.ndarray, np.ndarray]  # rows of x and of g


def matrices(p: Mapping[str, float], order: int) -> Matrices:
    """(8)-(14) and the built-in uncertainties of Section IV; parameters by the plant FMU's names."""
    k, l = order, p["l"]  # noqa: E741
    EI, rho, J = (np.array([p[f"{name}1"], p[f"{name}2"]]) for name in ("EI", "rho", "J"))
    m_tip = np.array([p["m1"], p["m2"]])
    mass = m_tip.sum() + p["M"]
    # Polynomials in xi = x/l on [0, 1].
    shifted = [legendre.Legendre.basis(j).convert(kind=Polynomial)(Polynomial([-1, 2])) for j in range(k)]
    eta = [Polynomial([1, -1]) * P for P in shifted]
    nodes, weights = legendre.leggauss(k + 2)
    xi, weight = (nodes + 1) / 2, weights / 2 * l
    values = np.array([f(xi) for f in eta])
    curvature = np.array([f.deriv(2)(xi) for f in eta]) / l**2
    P = np.array([f(xi) for f in shifted[: k - 1]])
    n = 2 * k + 2 * (k - 1) + 6
    a = [slice(i * k, (i + 1) * k) for i in (0, 1)]
    b = [slice(2 * k + i * (k - 1), 2 * k + (i + 1) * (k - 1)) for i in (0, 1)]
    hub, obj, angle, place = (n - 6, n - 5), n - 4, (n - 3, n - 2), n - 1
    root, tip = np.zeros((2, n)), np.zeros((2, n))
    A, B = np.zeros((n, n)), np.zeros((n, 3))
    for i in (0, 1):
        root[i, a[i]] = [f(0.0) for f in eta]
        tip[i, a[i]] = [f.deriv()(1.0) / l for f in eta]
        compliance = (values * weight) @ values.T / EI[i]
        G = (P * weight) @ curvature.T
        rates = np.zeros((k, n))
        rates[:, hub[i]], rates[:, obj], rates[:, b[i]] = root[i, a[i]], tip[i, a[i]], -G.T
        A[a[i]] = np.linalg.solve(compliance, rates)
    viscous = np.eye(n) + p["kelvin_voigt"] * A  # its rows of a: the transmitted moment
    for i in (0, 1):
        G = (P * weight) @ curvature.T
        moments = G @ viscous[a[i]]
        A[b[i]] = np.linalg.solve((P * weight) @ P.T * rho[i], moments)
    root_rate, tip_rate = root @ A, tip @ A
    transmitted_root = root + p["kelvin_voigt"] * root_rate
    transmitted_tip = tip + p["kelvin_voigt"] * tip_rate
    delta_F = -p["tip_uncertainty"] * EI.sum() * (tip_rate / EI[:, None]).sum(axis=0)
    for i in (0, 1):
        A[hub[i]] = (-transmitted_root[i] - p["root_uncertainty"] * root_rate[i]) / J[i]
        B[hub[i], i] = 1 / J[i]
        A[angle[i], hub[i]] = 1
    A[obj] = (-transmitted_tip.sum(axis=0) + delta_F) / mass
    B[obj, 2] = 1 / mass
    A[place, obj] = 1
    C = np.zeros((12, n))
    C[[0, 1, 2, 3, 4, 5], [*angle, *hub, place, obj]] = 1
    C[6:8], C[8:10], C[10:12] = root, tip, tip_rate
    offset = np.zeros(12)
    offset[4] = p["L"] / 2
    sign = np.array([-1.0, 1.0])[:, None]
    # (13)(14): lambda_i = Q_i + m_i y''
    contact = (sign * (transmitted_tip + np.outer(m_tip, A[obj])), sign * np.outer(m_tip, B[obj]))
    return Matrices(A, B, C, offset, contact)


@dataclass(frozen=True)
class Case:
    """A closed loop from the plant's start at rest."""

    controller: str
    stop: float
    settings: Mapping[str, float]  # by the FMUs' names
    lambda1: float = -0.5
    theta1: float = math.radians(3.0)
    times: int = 5
    order: int = 6


SMALL = {"lambda1": -0.005, "theta1": math.radians(0.03)}
TIGHT = {"k_M1": 0.3, "k_m1": -0.3, "k_M2": 0.06, "k_m2": -0.06}
CASES = {
    "nabfc": Case("NabfcController", 0.5, {}),
    "nabfc_saturated": Case("NabfcController", 0.5, TIGHT),
    "pds": Case("PdsController", 0.5, {}, **SMALL),
    "pds_saturated": Case("PdsController", 0.5, {}),
    "pd": Case("PdController", 0.5, {}, **SMALL),
    "pd_saturated": Case("PdController", 0.5, {}),
}


def defaults(fmu: str) -> dict[str, float]:
    """Start values of an FMU's real and integer variables, from the checked-in description."""
    values = {}
    for variable in ElementTree.parse(DESCRIPTIONS / f"{fmu}.xml").getroot().iter("ScalarVariable"):
        kind = next(iter(variable))
        if kind.tag in ("Real", "Integer") and variable.get("causality") in ("parameter", "input"):
            values[variable.get("name")] = float(kind.get("start"))
    return values


@dataclass(frozen=True)
class Loop:
    """f(t, z) with z = (x, controller's state), the start, outputs(z), and how far commands are inside their limits."""

    f: Callable[[float, np.ndarray], np.ndarray]
    start: np.ndarray
    outputs: Callable[[np.ndarray], dict[str, float]]
    margins: Callable[[np.ndarray], np.ndarray]


def right_hand_side(case: Case) -> Loop:
    """The closed loop of a case."""
    plant = {**defaults("DualArmPlant"), **{k: v for k, v in case.settings.items() if k in defaults("DualArmPlant")}}
    own = defaults(case.controller)
    law_type = Nabfc if case.controller == "NabfcController" else Linear
    gains = {**own, **{k: v for k, v in case.settings.items() if k in own}}
    law = law_type(gains, case.lambda1, case.theta1)
    M = matrices(plant, case.order)
    limits = [  # (18) of both channels
        [plant[f"k_{s}{c}"] * (plant[f"k_{end}{c}"] - plant[f"m_{s}{c}"]) for s, end in (("l", "m"), ("r", "M"))]
        for c in (1, 1, 2)
    ]
    low, high = np.array(limits).T
    n = len(M.A)

    def parts(z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        measured = M.C @ z[:n] + M.offset
        command, rates = law(measured, z[n:])
        return measured, command, rates

    def f(_t: float, z: np.ndarray) -> np.ndarray:
        _, command, rates = parts(z)
        return np.concatenate([M.A @ z[:n] + M.B @ np.clip(command, low, high), rates])

    def outputs(z: np.ndarray) -> dict[str, float]:
        measured, command, _ = parts(z)
        contact = M.contact[0] @ z[:n] + M.contact[1] @ np.clip(command, low, high)
        return {
            **dict(zip(("theta1", "theta2"), measured[:2])),
            "y_object": measured[4],
            "root_moment1": measured[6],
            "tip_shear1": measured[8],
            "contact_force1": contact[0],
            "contact_force2": contact[1],
            "saturated": bool(np.any((command <= low) | (command >= high))),
        }

    def margins(z: np.ndarray) -> np.ndarray:
        command = parts(z)[1]
        return np.concatenate([command - low, high - command])

    return Loop(f, np.concatenate([np.zeros(n), law.start(M.offset)]), outputs, margins)


def solve(case: Case, tolerance: float) -> tuple[list[dict[str, float]], bool]:
    """Outputs at equidistant times, and whether any command was beyond its limits on the way."""
    from scipy.integrate import solve_ivp

    loop = right_hand_side(case)
    outputs = loop.outputs
    times = np.linspace(0, case.stop, case.times + 1)
    fine = np.union1d(np.linspace(0, case.stop, 2001), times)
    method = dict(method="DOP853", rtol=tolerance, atol=tolerance * 1e-5)
    found = solve_ivp(loop.f, (0.0, case.stop), loop.start, t_eval=fine, **method)
    if not found.success:
        raise ArithmeticError(found.message)
    at = np.searchsorted(fine, times[1:])
    rows = [{"t": float(fine[i]), **outputs(found.y[:, i])} for i in at]
    saturated = any(outputs(z)["saturated"] for z in found.y.T)
    for row in rows:
        del row["saturated"]
    return rows, saturated


def main() -> None:
    """Solves every case at two tolerances; the file keeps the finer one and how far they are apart."""
    document: dict[str, Any] = {"made_by": "python -m tests.oracle.monolith", "cases": {}}
    for name, case in CASES.items():
        (coarse, _), (rows, saturated) = solve(case, 1e-10), solve(case, 1e-12)
        error = {
            output: float(f"{max(abs(a[output] - b[output]) for a, b in zip(coarse, rows)):.1e}") for output in OUTPUTS
        }
        document["cases"][name] = {
            "controller": case.controller,
            "order": case.order,
            "lambda1_ref": case.lambda1,
            "theta1_ref": case.theta1,
            "settings": dict(case.settings),
            "saturates": saturated,
            "error": error,
            "at": rows,
        }
        print(name, saturated, error)
    # Those of the root-strain law, r_..., are none of these loops'.
    names = sorted({case.controller for case in CASES.values()})
    document["gains"] = {n: {k: v for k, v in defaults(n).items() if not k.startswith("r_")} for n in names}
    text = json.dumps(document, indent=1)
    text = re.sub(r"\{[^{}]*\}", lambda found: re.sub(r"\s+", " ", found[0]), text)
    FILE.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
