"""The controllers alone: targets and control laws by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from .support.contract import CONTROLLERS, MEASURED, PAPER
from .support.harness import Fmu


@pytest.mark.parametrize("name", CONTROLLERS)
def test_targets(name: str, fmus: dict[str, Fmu]) -> None:
    """(16) with L/2, for unequal arms, and the errors."""
    EI1, EI2, l, L, lambda1, theta1 = 0.115, 0.2, 0.25, 0.12, -0.4, 0.03  # noqa: E741
    with fmus[name].instantiate() as slave:
        slave.set(EI1=EI1, EI2=EI2, l=l, L=L)
        slave.start()
        slave.set(lambda1_ref=lambda1, theta1_ref=theta1, theta1=0.2, theta2=0.3, y_object=0.07)
        theta2_d = theta1 + lambda1 * l**2 / 3 * (EI1 + EI2) / (EI1 * EI2)
        y_d = l * theta1 + l**3 * lambda1 / (3 * EI1) + L / 2
        names = ("theta1_d", "theta2_d", "y_object_d", "lambda2_d", "e1", "e2", "p")
        expected = [theta1, theta2_d, y_d, -lambda1, 0.2 - theta1, 0.3 - theta2_d, 0.07 - y_d]
        assert slave.get(*names) == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("name", ["PdsController", "PdController"])
def test_laws(name: str, fmus: dict[str, Fmu]) -> None:
    """(95)-(98) for arbitrary measurements, gains and unequal arms."""
    measured = dict(zip(MEASURED, (0.02, -0.03, 0.4, -0.5, 0.06, 0.07, 0.08, -0.09, 0.3, -0.2, 5.0, 6.0)))
    gains = {"kp": 11.0, "kv": 7.0, "kp1": 31.0, "kp2": 33.0, "kv1": 13.0, "kv2": 17.0}
    ks = {"ks1": 2.0, "ks2": 3.0} if name == "PdsController" else {}
    with fmus[name].instantiate() as slave:
        slave.set(EI2=0.2, **gains, **ks)
        slave.start()
        slave.set(**measured)
        e, p = slave.get("e1", "e2"), slave.get("p")[0]
        lambda_d = (-0.5, 0.5)
        for arm in (1, 2):
            moment = measured[f"root_moment{arm}"]
            strain = moment + lambda_d[arm - 1] * 0.2  # EI q''(0)
            expected = (
                -gains[f"kp{arm}"] * e[arm - 1]
                - gains[f"kv{arm}"] * measured[f"theta{arm}_dot"]
                - ks.get(f"ks{arm}", 0.0) * strain
                + moment
            )
            assert slave.get(f"tau{arm}_cmd")[0] == pytest.approx(expected, rel=1e-14)
        shear = measured["tip_shear1"] + measured["tip_shear2"]
        expected = -gains["kp"] * p - gains["kv"] * measured["y_object_dot"] + shear
        assert slave.get("u_cmd")[0] == pytest.approx(expected, rel=1e-13)


def test_neuro_adaptive_law_without_networks(fmus: dict[str, Fmu]) -> None:
    """(31)-(39) and (49)-(57) written out, W = U = 0: outputs for held measurements, and estimates after steps.

    While the inputs are held the update laws are d(estimate)/dt = drive - leakage * estimate, which has an exact step.
    """
    l, EI, goal = 0.2, np.array([0.115, 0.2]), np.array([-0.5, 0.5])  # noqa: E741
    gains = {
        **{"eta": 0.9, "k": 4.0, "mu_bar": 3.0, "c1": 2.0, "epsilon1": 0.2, "gamma1": 1.5, "gamma2": 0.1},
        **{"b1": 0.7, "b2": 0.3, "m_hat_0": 0.02, "J1_hat_0": 0.001, "J2_hat_0": 0.002, "sat_limit": 0.015},
        **{"a1": 0.0, "a31": 0.0, "a32": 0.0, "shear_rate_bandwidth": 0.0},
    }
    hub = {
        **{"xi": (1.1, 1.2), "k": (0.3, 0.4), "mu": (5.0, 6.0), "c3": (4.0, 3.0), "epsilon2": (0.1, 0.2)},
        **{"zeta1": (1.3, 1.4), "zeta2": (0.2, 0.3), "g1": (0.05, 0.06), "g2": (0.5, 0.6)},
    }
    a = {key: np.array(pair) for key, pair in hub.items()}
    theta, theta_dot, y, y_dot = np.array([0.04, -0.02]), np.array([0.3, -0.4]), 0.047, 0.02
    moment, shear, shear_dot = np.array([0.05, -0.06]), np.array([-0.2, 0.3]), np.array([2.0, -1.5])

    theta_d = np.pi / 60 + np.array([0.0, goal[0] * l**2 / 3 * EI.sum() / EI.prod()])
    z1 = y - (l * theta_d[0] + l**3 * goal[0] / (3 * EI[0]) + 0.05)
    bend, bend_dot = np.sum((shear - goal) / EI), np.sum(shear_dot / EI)  # sums of q'''(l) and of its rate
    s = (gains["mu_bar"] + gains["c1"]) * z1 + y_dot + bend
    e = theta - theta_d
    s_hub = (a["mu"] + a["c3"]) * e + theta_dot
    rate = (gains["mu_bar"] + gains["c1"]) * y_dot + bend_dot

    def commands(m: float, epsilon: float, inertia: np.ndarray, pi: np.ndarray) -> list[float]:
        limit = gains["sat_limit"]
        v = -gains["eta"] * np.clip(s, -limit, limit) - gains["k"] * s - z1 - m * rate + np.sum(shear - goal)
        v -= epsilon * np.tanh(s / gains["epsilon1"])
        tau = -a["xi"] * np.clip(s_hub, -limit, limit) - a["k"] * s_hub - e
        tau += -inertia * theta_dot * (a["mu"] + a["c3"]) + moment + goal * l  # EI q''(0) = M + lambda_d l ...
        tau += -pi * np.tanh(s_hub / a["epsilon2"]) - goal * l  # ... and - lambda_d l
        return [*tau, v]

    def held(start: Any, drive: Any, leakage: Any, time: float) -> Any:
        return drive / leakage + (start - drive / leakage) * np.exp(-leakage * time)

    with fmus["NabfcController"].instantiate() as slave:
        slave.set(**PAPER, EI1=EI[0], EI2=EI[1], **gains)
        slave.set(**{f"{key}{arm}": pair[arm - 1] for key, pair in hub.items() for arm in (1, 2)})
        slave.set(**dict(zip(MEASURED, (*theta, *theta_dot, y, y_dot, *moment, *shear, *shear_dot))))
        slave.start()
        assert slave.get("s", "s1", "s2") == pytest.approx([s, *s_hub], rel=1e-12)
        estimates = (gains["m_hat_0"], 0.0, np.array([0.001, 0.002]), np.zeros(2))
        assert slave.get("tau1_cmd", "tau2_cmd", "u_cmd") == pytest.approx(commands(*estimates), rel=1e-12)

        sizes = [1e-3, 1e-3, 5e-3, 0.1]
        for start, size in zip(np.cumsum([0.0, *sizes]), sizes):
            slave.step(start, size, 1)
        time = sum(sizes)
        m = held(gains["m_hat_0"], gains["b1"] * s * rate, gains["b1"] * gains["b2"], time)
        epsilon = held(
            0.0, gains["gamma1"] * s * np.tanh(s / gains["epsilon1"]), gains["gamma1"] * gains["gamma2"], time
        )
        inertia = held(
            np.array([0.001, 0.002]), a["g1"] * s_hub * theta_dot * (a["mu"] + a["c3"]), a["g1"] * a["g2"], time
        )
        pi = held(np.zeros(2), a["zeta1"] * s_hub * np.tanh(s_hub / a["epsilon2"]), a["zeta1"] * a["zeta2"], time)
        names = ("m_hat", "epsilon_hat", "J1_hat", "J2_hat", "pi1_hat", "pi2_hat")
        assert slave.get(*names) == pytest.approx([m, epsilon, *inertia, *pi], rel=1e-12)
        assert slave.get("W_norm", "U1_norm", "U2_norm") == [0.0, 0.0, 0.0]
        # The commands follow the estimates without a new input.
        assert slave.get("tau1_cmd", "tau2_cmd", "u_cmd") == pytest.approx(commands(m, epsilon, inertia, pi), rel=1e-12)
