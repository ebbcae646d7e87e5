"""Two arms, two hubs, one object, linear feedback: characteristic function and exact transfer functions.

With M_i the transmitted root moment E_i w_i''(0) and Q_i the transmitted tip shear E_i w_i'''(l), the Laplace
transforms of (10) and (11) from rest are

    A_i theta_i + h_i M_i        = f_i,        A_i = J_i s^2 + kv_i s + kp_i
    P   y       + sum x_i Q_i    = F,          P   = m s^2  + kv s  + kp,      y = y_M - L/2

where h_i and x_i gather what acts on the moment and the shear: the uncertainties of Section IV and the feedback
(95)-(98). Both see the bending moment EI w'' and its slope EI w''' (what a strain gauge measures): with Kelvin-Voigt
damping that is the transmitted one divided by 1 + kappa s.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from mpmath import mp, mpf

from .beam import BeamFunctions, beam_functions, scaled_beam_functions


def exact(value: float | str) -> mpf:
    """A decimal number as written (0.115 is 115/1000, not the nearest double)."""
    return mpf(repr(value) if isinstance(value, float) else value)


@dataclass(frozen=True)
class Plant:
    """Parameters of the plant, by the paper's letters; pairs are (arm 1, arm 2). SI units."""

    EI: tuple[float, float] = (0.115, 0.115)
    rho: tuple[float, float] = (0.054, 0.054)
    J: tuple[float, float] = (0.0073, 0.0073)
    m_tip: tuple[float, float] = (0.1, 0.1)
    M: float = 0.3
    l: float = 0.2  # noqa: E741  (the paper's letter)
    root_uncertainty: float = 0.1
    tip_uncertainty: float = 0.05
    kelvin_voigt: float = 0.0

    def without_uncertainties(self) -> Plant:
        """The same plant with c_f = c_F = 0."""
        return replace(self, root_uncertainty=0.0, tip_uncertainty=0.0)


@dataclass(frozen=True)
class Feedback:
    """The linear laws (95)-(98); `shear` and `moment` are 1 where the law cancels the measured shear or moment."""

    kp: float = 0.0
    kv: float = 0.0
    kp_hub: tuple[float, float] = (0.0, 0.0)
    kv_hub: tuple[float, float] = (0.0, 0.0)
    ks_hub: tuple[float, float] = (0.0, 0.0)
    shear: float = 0.0
    moment: float = 0.0


NO_CONTROL = Feedback()
PD = Feedback(kp=10, kv=9, kp_hub=(60, 60), kv_hub=(55, 55), shear=1, moment=1)
PDS = Feedback(kp=40, kv=35, kp_hub=(35, 35), kv_hub=(15, 15), ks_hub=(10, 10), shear=1, moment=1)


@dataclass(frozen=True)
class Target:
    """A static target (16), relative to y_M = L/2."""

    lambda1: Any
    theta: tuple[Any, Any]
    y: Any


def target(plant: Plant, lambda1: float | str, theta1: Any) -> Target:
    """(16) with the L/2 that it leaves out taken care of by measuring y from L/2."""
    l, (EI1, EI2) = exact(plant.l), map(exact, plant.EI)  # noqa: E741
    lambda1, theta1 = exact(lambda1), mpf(theta1)
    theta2 = theta1 + lambda1 * l**2 / 3 * (EI1 + EI2) / (EI1 * EI2)
    return Target(lambda1, (theta1, theta2), l * theta1 + l**3 * lambda1 / (3 * EI1))


@dataclass(frozen=True)
class Loads:
    """Laplace transforms of the loads on the right-hand sides: two hub torques, one force on the object."""

    f: tuple[Any, Any]
    F: Any


OUTPUTS = (
    *("theta1", "theta2", "y", "root_moment1", "root_moment2", "tip_shear1", "tip_shear2"),
    *("tip_shear1_dot", "tip_shear2_dot", "lambda1", "lambda2"),
)


class System:
    """Plant and feedback; every method works at the current mpmath precision."""

    def __init__(self, plant: Plant, feedback: Feedback = NO_CONTROL) -> None:
        self.plant = plant
        self.feedback = feedback

    def _arms(self, s: Any) -> list[_Arm]:
        return [_Arm(self, i, s) for i in (0, 1)]

    def _object(self, s: Any) -> Any:
        m = sum(map(exact, self.plant.m_tip)) + exact(self.plant.M)
        return _like(s, m) * s**2 + _like(s, self.feedback.kv) * s + _like(s, self.feedback.kp)

    def characteristic(self, s: Any) -> Any:
        """An entire function whose zeros are the eigenvalues.

        `s` is an mpmath number, or a numpy array (then scaled by a positive factor and in double precision).
        """
        one, two = self._arms(s)
        return self._object(s) * one.alpha * two.alpha + two.alpha * one.tip + one.alpha * two.tip

    def adjugate(self, s: Any, loads: Loads) -> dict[str, Any]:
        """Every output times the characteristic function: at a simple zero, the residue's numerator."""
        one, two = arms = self._arms(s)
        P, (f1, f2), F = self._object(s), loads.f, loads.F
        y = one.alpha * two.alpha * F - one.c * f1 * two.alpha - two.c * f2 * one.alpha
        schur1 = two.alpha * (P * one.d + one.xkyy) + one.d * two.tip
        schur2 = one.alpha * (P * two.d + two.xkyy) + two.d * one.tip
        theta1 = f1 * schur1 - one.b * (F * two.alpha - two.c * f2)
        theta2 = f2 * schur2 - two.b * (F * one.alpha - one.c * f1)
        values = {"theta1": theta1, "theta2": theta2, "y": y}
        for number, (arm, theta, m_tip) in enumerate(zip(arms, (theta1, theta2), self.plant.m_tip), start=1):
            moment, shear = arm.transmitted(theta, y)
            values[f"root_moment{number}"] = moment / arm.viscous
            values[f"tip_shear{number}"] = shear / arm.viscous
            values[f"tip_shear{number}_dot"] = s * shear / arm.viscous
            values[f"lambda{number}"] = shear + exact(m_tip) * s**2 * y
        return values

    def outputs(self, s: Any, loads: Loads) -> dict[str, Any]:
        """The Laplace transforms of all OUTPUTS under `loads`, from rest."""
        characteristic = self.characteristic(s)
        return {name: value / characteristic for name, value in self.adjugate(s, loads).items()}

    def reference_loads(self, s: Any, goal: Target) -> Loads:
        """What a step of the target at t = 0 feeds into the loop: kp theta_d - ks lambda_d l, and kp y_d."""
        control, l = self.feedback, exact(self.plant.l)  # noqa: E741
        f1, f2 = (
            (kp * theta - ks * sign * goal.lambda1 * l) / s
            for kp, ks, theta, sign in zip(control.kp_hub, control.ks_hub, goal.theta, (1, -1))
        )
        return Loads((f1, f2), control.kp * goal.y / s)


class _Arm:
    """What one arm contributes at one s; products are arranged so that every attribute is entire in s."""

    def __init__(self, system: System, index: int, s: Any) -> None:
        plant, control = system.plant, system.feedback
        EI, rho, J = (exact(pair[index]) for pair in (plant.EI, plant.rho, plant.J))
        l, kappa = exact(plant.l), exact(plant.kelvin_voigt)  # noqa: E741
        c_f, c_F = exact(plant.root_uncertainty), exact(plant.tip_uncertainty)
        EI_sum = sum(map(exact, plant.EI))
        EI, rho, J, l, kappa, c_f, c_F, EI_sum = (_like(s, v) for v in (EI, rho, J, l, kappa, c_f, c_F, EI_sum))  # noqa: E741
        self.l = l
        self.viscous = 1 + kappa * s
        self.E = EI * self.viscous
        self.functions = fn = _functions(s, rho * s**2 / self.E, l)
        self.d = fn.d
        # Total factors of the transmitted moment and shear in (10) and (11).
        h = 1 + (c_f * s - control.moment * (1 - control.ks_hub[index])) / self.viscous
        x = 1 + (c_F * EI_sum / EI * s - control.shear) / self.viscous
        A = J * s**2 + _like(s, control.kv_hub[index]) * s + _like(s, control.kp_hub[index])
        self.alpha = A * fn.d - 2 * self.E / l * h * fn.p  # (A + h K_theta,theta) d
        self.b = 2 * self.E / l**2 * h * fn.r  # h K_theta,y d
        self.c = 2 * self.E / l**2 * x * fn.r  # x K_y,theta d
        self.xkyy = -self.E / l**3 * x * fn.q  # x K_y,y d
        self.tip = A * self.xkyy + h * x * self.E * rho * s**2 * fn.d  # (A x K_y,y + h x det K) d

    def transmitted(self, theta: Any, y: Any) -> tuple[Any, Any]:
        """Root moment and tip shear for the end motions."""
        fn, E, l = self.functions, self.E, self.l  # noqa: E741
        moment = 2 * E / l**2 * (fn.r * y - fn.p * l * theta) / fn.d
        shear = E / l**3 * (2 * fn.r * l * theta - fn.q * y) / fn.d
        return moment, shear


def _functions(s: Any, ratio: Any, l: Any) -> BeamFunctions:  # noqa: E741
    if isinstance(s, np.ndarray):
        return scaled_beam_functions(np.sqrt(np.sqrt(-ratio + 0j)) * l)
    return beam_functions(mp.sqrt(mp.sqrt(-ratio)) * l)


def _like(s: Any, value: Any) -> Any:
    """`value` in the arithmetic of `s`."""
    return float(value) if isinstance(s, np.ndarray) else mpf(value)
