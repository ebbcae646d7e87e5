"""The three control laws, re-derived from the paper: commands and the right-hand sides of every update law.

Nothing here comes from the controllers' code; parameters have the names of the FMUs' interface. A law maps the twelve
measured signals, the references and its own state (estimates, weights, filtered shear rates) to commands and to the
rates of that state, so the same function serves as a check of recorded trajectories and as one part of an ODE.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

MEASURED = (
    *("theta1", "theta2", "theta1_dot", "theta2_dot", "y_object", "y_object_dot", "root_moment1", "root_moment2"),
    *("tip_shear1", "tip_shear2", "tip_shear1_dot", "tip_shear2_dot"),
)
Parameters = Mapping[str, float]


@dataclass(frozen=True)
class Errors:
    """What Section III works with: deviations from the static target (16), with the L/2 it leaves out."""

    lambda_d: np.ndarray
    e: np.ndarray
    e_dot: np.ndarray
    p: float
    p_dot: float
    root: np.ndarray  # EI q''(0)
    tip: np.ndarray  # q'''(l)
    w_tip: np.ndarray  # w'''(l)


def errors(measured: np.ndarray, parameters: Parameters, lambda1: float, theta1: float) -> Errors:
    """(16) and the definitions after (22); `measured` in the order of MEASURED."""
    theta, theta_dot, y, y_dot = measured[0:2], measured[2:4], measured[4], measured[5]
    moment, shear = measured[6:8], measured[8:10]
    EI = np.array([parameters["EI1"], parameters["EI2"]])
    l, L = parameters["l"], parameters["L"]  # noqa: E741
    lambda_d = np.array([lambda1, -lambda1])
    theta_d = np.array([theta1, theta1 + lambda1 * l**2 / 3 * (1 / EI[0] + 1 / EI[1])])
    y_d = l * theta1 + l**3 * lambda1 / (3 * EI[0]) + L / 2
    # w_d = (lambda_d x^2 / 2 EI)(x/3 - l): w_d'''(l) = lambda_d / EI, EI w_d''(0) = -lambda_d l
    return Errors(
        lambda_d, theta - theta_d, theta_dot, y - y_d, y_dot, moment + lambda_d * l, (shear - lambda_d) / EI, shear / EI
    )


class Linear:
    """(95)-(98): PD, and PDS where the parameters have ks1 and ks2."""

    states = 0

    def __init__(self, parameters: Parameters, lambda1: float, theta1: float) -> None:
        self.g, self._reference = parameters, (lambda1, theta1)

    def start(self, _measured: np.ndarray) -> np.ndarray:
        """No state."""
        return np.zeros(0)

    def __call__(self, measured: np.ndarray, _state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Commands [tau1, tau2, u], and no rates."""
        g, x = self.g, errors(measured, self.g, *self._reference)
        tau = [
            -g[f"kp{i + 1}"] * x.e[i]
            - g[f"kv{i + 1}"] * x.e_dot[i]
            - g.get(f"ks{i + 1}", 0.0) * x.root[i]
            + measured[6 + i]
            for i in (0, 1)
        ]
        v = -g["kp"] * x.p - g["kv"] * x.p_dot + measured[8] + measured[9]
        return np.array([*tau, v]), np.zeros(0)


class Nabfc:
    """(31)-(39) and (49)-(57); state: m, epsilon, (J, pi) of both arms, W, U1, U2, filtered shear rates."""

    def __init__(self, parameters: Parameters, lambda1: float, theta1: float) -> None:
        self.g, self._reference = parameters, (lambda1, theta1)
        g = parameters
        self._object_nodes = _star(int(g["rbf_rings_object"]), 7)
        self._hub_nodes = np.array(list(itertools.product(_axis(int(g["rbf_nodes_posture"])), repeat=3)))
        n, h = len(self._object_nodes), len(self._hub_nodes)
        self.W, self.U = slice(6, 6 + n), (slice(6 + n, 6 + n + h), slice(6 + n + h, 6 + n + 2 * h))
        self.filtered = slice(6 + n + 2 * h, 8 + n + 2 * h)
        self.states = 8 + n + 2 * h
        self._object_scale = np.array(
            [g["rbf_position_scale"], g["rbf_object_surface_scale"], g["rbf_object_alpha_scale"]]
            + [g["rbf_shear_scale"]] * 2
            + [g["rbf_shear_rate_scale"]] * 2
        )
        self._hub_scale = np.array(
            [g["rbf_angle_scale"], g["rbf_posture_surface_scale"], g["rbf_posture_alpha_scale"]]
        )

    def start(self, measured: np.ndarray) -> np.ndarray:
        """Initial estimates, zero weights, filters at rest on what is measured."""
        state = np.zeros(self.states)
        state[0], state[2], state[4] = self.g["m_hat_0"], self.g["J1_hat_0"], self.g["J2_hat_0"]
        state[self.filtered] = measured[10:12]
        return state

    def norms(self, state: np.ndarray) -> dict[str, float]:
        """The FMU's outputs of the estimates."""
        return {
            **dict(zip(("m_hat", "epsilon_hat", "J1_hat", "pi1_hat", "J2_hat", "pi2_hat"), state[:6])),
            "W_norm": float(np.linalg.norm(state[self.W])),
            "U1_norm": float(np.linalg.norm(state[self.U[0]])),
            "U2_norm": float(np.linalg.norm(state[self.U[1]])),
        }

    def __call__(self, measured: np.ndarray, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Commands [tau1, tau2, u] and the rates of the state."""
        command, drive, leak = self.parts(measured, state)
        return command, drive - leak * state

    def parts(self, measured: np.ndarray, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Commands, and drive and leakage of d(state)/dt = drive - leakage * state."""
        g, x = self.g, errors(measured, self.g, *self._reference)
        EI = np.array([g["EI1"], g["EI2"]])
        bandwidth = g["shear_rate_bandwidth"]
        drive, leak = np.zeros(self.states), np.zeros(self.states)
        rate = state[self.filtered] if bandwidth > 0 else measured[10:12]
        drive[self.filtered], leak[self.filtered] = bandwidth * measured[10:12], bandwidth
        w_tip_dot = rate / EI

        # Object loop. (34): alpha_1 = -c1 z1 - sum q''', so z2 = p_dot - alpha_1 and s = mu z1 + z2, (32)(33)
        alpha_dot = -g["c1"] * x.p_dot - w_tip_dot.sum()
        s = g["mu_bar"] * x.p + x.p_dot + g["c1"] * x.p + x.tip.sum()
        X = np.array([x.p, s, alpha_dot, *x.w_tip, *w_tip_dot])
        Y = _gauss(X / self._object_scale, self._object_nodes, g["rbf_width_object"])
        slope = g["mu_bar"] + g["c1"]
        m, epsilon, W = state[0], state[1], state[self.W]
        v = (
            -g["eta"] * self._sat(s)
            - g["k"] * s
            - x.p
            - m * x.p_dot * slope
            + (EI * x.tip).sum()
            - W @ Y
            - epsilon * np.tanh(s / g["epsilon1"])
            - m * w_tip_dot.sum()
        )
        drive[0], leak[0] = g["b1"] * s * (x.p_dot * slope + w_tip_dot.sum()), g["b1"] * g["b2"]  # (39)
        drive[1], leak[1] = g["gamma1"] * s * np.tanh(s / g["epsilon1"]), g["gamma1"] * g["gamma2"]  # (38)
        drive[self.W], leak[self.W] = g["a1"] * s * Y, g["a1"] * g["a2"]  # (37)

        tau = []
        for i in (0, 1):
            a = {key: g[f"{key}{i + 1}"] for key in ("xi", "k", "mu", "c3", "epsilon2", "a3", "a4", "zeta1", "zeta2")}
            a |= {key: g[f"{key}{i + 1}"] for key in ("g1", "g2")}
            e, e_dot, slope = x.e[i], x.e_dot[i], a["mu"] + a["c3"]
            s = a["mu"] * e + e_dot + a["c3"] * e  # (50)-(52)
            Y = _gauss(np.array([e, s, -a["c3"] * e_dot]) / self._hub_scale, self._hub_nodes, g["rbf_width_posture"])
            J, pi, U = state[2 + 2 * i], state[3 + 2 * i], state[self.U[i]]
            tanh = np.tanh(s / a["epsilon2"])
            tau.append(
                -a["xi"] * self._sat(s) - a["k"] * s - e - J * e_dot * slope + x.root[i] - U @ Y - pi * tanh
                - x.lambda_d[i] * g["l"]
            )  # fmt: skip  # (54)
            drive[2 + 2 * i], leak[2 + 2 * i] = a["g1"] * s * e_dot * slope, a["g1"] * a["g2"]  # (57)
            drive[3 + 2 * i], leak[3 + 2 * i] = a["zeta1"] * s * tanh, a["zeta1"] * a["zeta2"]  # (56)
            drive[self.U[i]], leak[self.U[i]] = a["a3"] * s * Y, a["a3"] * a["a4"]  # (55)
        return np.array([*tau, v]), drive, leak

    def _sat(self, value: float) -> float:
        return min(max(value, -self.g["sat_limit"]), self.g["sat_limit"])


def held(state: np.ndarray, drive: np.ndarray, leak: np.ndarray, h: float) -> np.ndarray:
    """The exact solution of d(state)/dt = drive - leak * state after h, for held drive and leak."""
    z = leak * h
    mean = np.where(z == 0, 1.0, -np.expm1(-z) / np.where(z == 0, 1.0, z))
    return state * np.exp(-z) + drive * h * mean


def _axis(nodes: int) -> np.ndarray:
    return np.linspace(-1.0, 1.0, nodes) if nodes > 1 else np.zeros(1)


def _star(rings: int, dimensions: int) -> np.ndarray:
    nodes: list[Any] = [np.zeros(dimensions)]
    for dimension in range(dimensions):
        for c in _axis(2 * rings + 1):
            if c != 0:
                nodes.append(np.eye(dimensions)[dimension] * c)
    return np.array(nodes)


def _gauss(x: np.ndarray, nodes: np.ndarray, width: float) -> np.ndarray:
    return np.exp(-((x - nodes) ** 2).sum(axis=1) / width**2)
