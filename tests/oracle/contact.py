"""A grasp that can open, computed another way.

The arms are the same mixed elements, written down again from `docs/model.md` (Gauss quadrature of scipy's polynomials, tips with velocities of
their own). Rigid contacts: between two switches the motion is a sum of eigenvectors, sampled finely, and a switch is a root
found by bisection. Compliant ones: an ordinary initial value problem for scipy, with its event location. No code, no exponential and no root
finder is shared with the FMU.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import eval_jacobi, eval_legendre

SIGN = (-1.0, 1.0)


@dataclass(frozen=True)
class Grasp:
    """A plant; the paper's by default, without its uncertainties."""

    order: int = 8
    EI: tuple[float, float] = (0.115, 0.115)
    rho: float = 0.054
    l: float = 0.2  # noqa: E741
    m: tuple[float, float] = (0.1, 0.1)
    M: float = 0.3
    J: float = 0.0073
    root_uncertainty: float = 0.0
    restitution: float = 0.0
    stiffness: float = 1000.0
    damping: float = 10.0
    matrices: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    def __post_init__(self) -> None:
        k, l = self.order, self.l  # noqa: E741
        nodes, weights = np.polynomial.legendre.leggauss(k + 2)
        xi, weights = (nodes + 1) / 2, weights / 2
        moments, velocities = 2 * k, 2 * (k - 1) + 5
        rates = np.zeros((moments, velocities))
        tip_rows, root_rows = np.zeros((2, moments)), np.zeros((2, moments))
        for i, EI in enumerate(self.EI):
            scale = np.sqrt(EI * (2 * np.arange(k) + 3) / l)
            for j in range(k):
                # (1 - xi) P_j^(2,0): its coefficients from values at Chebyshev points.
                points = (1 + np.cos(np.linspace(0, np.pi, j + 4))) / 2
                shape = np.polynomial.Polynomial.fit(points, (1 - points) * eval_jacobi(j, 2, 0, 2 * points - 1), j + 1)
                curvature = shape.deriv(2)(xi)
                for r in range(k - 1):
                    unit = np.sqrt((2 * r + 1) / (self.rho * l)) * eval_legendre(r, 2 * xi - 1)
                    rates[i * k + j, i * (k - 1) + r] = -scale[j] / l * np.sum(weights * unit * curvature)
            root = scale * (-1.0) ** np.arange(k)
            tip = -scale / l * (np.arange(k) + 1) * (np.arange(k) + 2) / 2
            root_rows[i, i * k : (i + 1) * k], tip_rows[i, i * k : (i + 1) * k] = root, tip
            rates[i * k : (i + 1) * k, 2 * (k - 1) + i] = root / np.sqrt(self.J)
            rates[i * k : (i + 1) * k, 2 * k + i] = tip / np.sqrt(self.m[i])
        size = moments + velocities
        free = np.zeros((size, size))
        free[:moments, moments:], free[moments:, :moments] = rates, -rates.T
        for i in range(2):
            free[moments + 2 * (k - 1) + i, moments:] -= self.root_uncertainty / np.sqrt(self.J) * (root_rows[i] @ rates)
        inputs = np.zeros((size, 3))
        inputs[size - 5, 0] = inputs[size - 4, 1] = 1 / np.sqrt(self.J)
        inputs[size - 1, 2] = 1 / np.sqrt(self.M)
        opening = np.zeros((2, size))
        for i in range(2):
            opening[i, size - 3 + i] = SIGN[i] / np.sqrt(self.m[i])
            opening[i, size - 1] = -SIGN[i] / np.sqrt(self.M)
        angles = np.zeros((2, size))
        angles[0, size - 5] = angles[1, size - 4] = 1 / np.sqrt(self.J)
        self.matrices.update(free=free, inputs=inputs, opening=opening, angles=angles, size=size)

    def start(self, gaps: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
        """Straight arms at rest, this far from the object's faces: x and gaps."""
        return np.zeros(self.matrices["size"]), np.array(gaps)

    # ---- rigid faces

    def rigid(
        self, x: np.ndarray, gap: np.ndarray, g: np.ndarray, stop: float, spacing: float
    ) -> tuple[np.ndarray, np.ndarray, list[tuple[float, int, str]]]:
        """x, gaps at `stop` and every switch on the way (time, side, what), from open gaps, with held forces."""
        touching, now, switches = [False, False], 0.0, []
        while now < stop:
            flow, signal = self._mode(tuple(touching), x, gap, g)
            times = np.arange(0.0, stop - now + spacing, spacing)
            first: tuple[float, int] | None = None
            for side in range(2):
                values = signal(side, times)
                # Just after a switch signals begin with zero.
                below = np.flatnonzero((values[1:] < -1e-15) & (times[1:] <= stop - now))
                if len(below):
                    index = below[0]
                    root = brentq(lambda t, side=side: float(signal(side, np.array([t]))[0]), times[index], times[index + 1], xtol=1e-17, rtol=1e-15) if values[index] > 0 else times[index]
                    if first is None or root < first[0]:
                        first = (root, side)
            time = stop - now if first is None else first[0]
            gap = np.array([0.0 if touching[s] else float(signal(s, np.array([time]))[0]) for s in range(2)])
            x = flow(time)
            now += time
            if first is None:
                break
            side = first[1]
            if touching[side]:
                touching[side] = False
                switches.append((now, side, "opens"))
            else:
                gap[side] = 0.0
                touching[side] = True
                x = self._projection(tuple(touching)) @ x
                switches.append((now, side, "closes"))
        return x, gap, switches

    def _projection(self, touching: tuple[bool, ...]) -> np.ndarray:
        rows = self.matrices["opening"][[i for i in range(2) if touching[i]]]
        identity = np.eye(self.matrices["size"])
        return identity if len(rows) == 0 else identity - rows.T @ np.linalg.solve(rows @ rows.T, rows)

    def _mode(self, touching: tuple[bool, ...], x: np.ndarray, gap: np.ndarray, g: np.ndarray) -> tuple[Callable, Callable]:
        """x after a time, and the signals of both sides, by eigenvectors of the mode extended by its constant forces and gaps."""
        size, opening = self.matrices["size"], self.matrices["opening"]
        project = self._projection(touching)
        free, push = self.matrices["free"], self.matrices["inputs"] @ g
        system = project @ free @ project
        # (x, gaps, t): x' = A x + B g, gaps' = N x.
        values, vectors = np.linalg.eig(system)
        back = np.linalg.inv(vectors)
        start, drive = back @ x, back @ (project @ push)
        def phi(t: float) -> np.ndarray:
            z = values * t
            small = np.abs(z) < 1e-8
            safe = np.where(small, 1.0, z)
            return np.where(small, t * (1 + z / 2), t * np.expm1(safe) / safe)
        def phi_2(t: float) -> np.ndarray:
            z = values * t
            small = np.abs(z) < 1e-3
            safe = np.where(small, 1.0, z)
            series = t**2 * (0.5 + z / 6 + z**2 / 24 + z**3 / 120 + z**4 / 720)
            return np.where(small, series, t**2 * (np.expm1(safe) - safe) / safe**2)
        def flow(t: float) -> np.ndarray:
            return np.real(vectors @ (np.exp(values * t) * start + phi(t) * drive))
        rows = [i for i in range(2) if touching[i]]
        force = -np.linalg.solve(opening[rows] @ opening[rows].T, opening[rows]) if rows else None
        def signal(side: int, times: np.ndarray) -> np.ndarray:
            if touching[side]:
                row = force[rows.index(side)]
                return np.array([row @ (free @ flow(t) + push) for t in times])
            row = opening[side] @ vectors
            return np.array([gap[side] + np.real(row @ (phi(t) * start + phi_2(t) * drive)) for t in times])
        return flow, signal

    # ---- compliant faces

    def compliant(
        self, gap: tuple[float, float], g: np.ndarray, stop: float, tolerance: float = 1e-11
    ) -> tuple[np.ndarray, list[tuple[float, int]], float]:
        """State (x, distances from the undeformed faces, deformations), switches and the energy that faces took, by scipy."""
        size, opening = self.matrices["size"], self.matrices["opening"]
        free, push, k, c = self.matrices["free"], self.matrices["inputs"] @ g, self.stiffness, self.damping
        y = np.concatenate([np.zeros(size), gap, [0.0, 0.0, 0.0]])
        touching, now, switches = [False, False], 0.0, []
        while now < stop:
            mode = tuple(touching)

            def rate(_t: float, y: np.ndarray, mode: tuple[bool, ...] = mode) -> np.ndarray:
                x, pressed = y[:size], y[size + 2 : size + 4]
                v = opening @ x
                change, faces, loss = free @ x + push, np.zeros(2), 0.0
                for i in range(2):
                    if mode[i]:
                        change = change + opening[i] * (k * pressed[i] - c * v[i])
                        faces[i] = -v[i]
                    else:
                        faces[i] = -k / c * pressed[i]
                    loss += c * faces[i] ** 2
                return np.concatenate([change, v, faces, [loss]])

            def event(side: int, mode: tuple[bool, ...] = mode) -> Callable:
                def crossing(_t: float, y: np.ndarray) -> float:
                    pressed = y[size + 2 + side]
                    if mode[side]:
                        return float(k * pressed - c * (opening[side] @ y[:size]))
                    return float(y[size + side] + pressed)
                crossing.terminal, crossing.direction = True, -1
                return crossing

            found = solve_ivp(rate, (now, stop), y, method="DOP853", rtol=tolerance, atol=tolerance * 1e-2, events=[event(0), event(1)], max_step=1e-3)
            y, now = found.y[:, -1], float(found.t[-1])
            for side in range(2):
                if len(found.t_events[side]):
                    touching[side] = not touching[side]
                    switches.append((now, side))
        return y, switches, float(y[-1])


def exact_free_arm(torque: float, gap: float, modes: int = 40) -> tuple[float, float]:
    """When the tip of a straight arm at rest, turned by a constant torque, has gone as far as `gap`, and how fast it is then: the
    continuous beam's own modes, hub and tip mass included, of the paper's arm."""
    EI, rho, l, m, J = 0.115, 0.054, 0.2, 0.1, 0.0073  # noqa: E741

    def rows(b: float) -> np.ndarray:
        """Conditions on A sin + B sinh + C (cos - cosh), the general shape with Y(0) = 0, at wave number b (columns A, B, C)."""
        omega2, s, c = EI * b**4 / rho, np.sin(b * l), np.cos(b * l)
        sh, ch = np.sinh(b * l), np.cosh(b * l)
        hub = [-J * omega2 * b, -J * omega2 * b, 2 * EI * b**2]
        free = [-s, sh, -c - ch]
        tip = [
            EI * b**3 * -c + m * omega2 * s,
            EI * b**3 * ch + m * omega2 * sh,
            EI * b**3 * (s - sh) + m * omega2 * (c - ch),
        ]
        return np.array([hub, free, tip]) / np.array([[b**3], [ch], [b**4 * ch]])

    grid = np.linspace(0.5, (modes + 2) * np.pi / l, 400 * modes)
    values = [np.linalg.det(rows(b)) for b in grid]
    roots = [
        brentq(lambda b: np.linalg.det(rows(b)), grid[i], grid[i + 1], xtol=1e-14)
        for i in range(len(grid) - 1)
        if values[i] * values[i + 1] < 0
    ][:modes]
    nodes, weights = np.polynomial.legendre.leggauss(400)
    x, weights = (nodes + 1) * l / 2, weights * l / 2
    terms = []
    for b in roots:
        shape = np.linalg.svd(rows(b))[2][-1]
        # exp(b l) is at most e^{130}.
        def at(z: np.ndarray | float, shape: np.ndarray = shape, b: float = b) -> Any:
            return shape[0] * np.sin(b * z) + shape[1] * np.sinh(b * z) + shape[2] * (np.cos(b * z) - np.cosh(b * z))

        slope = b * (shape[0] + shape[1])
        mass = rho * np.sum(weights * at(x) ** 2) + J * slope**2 + m * at(l) ** 2
        terms.append((np.sqrt(EI / rho) * b**2, at(l) * slope / mass))
    inertia = J + rho * l**3 / 3 + m * l**2

    def tip(t: float) -> float:
        return torque * (l * t**2 / 2 / inertia + sum(a * (1 - np.cos(w * t)) / w**2 for w, a in terms))

    def speed(t: float) -> float:
        return torque * (l * t / inertia + sum(a * np.sin(w * t) / w for w, a in terms))

    rough = np.sqrt(2 * gap * inertia / torque / l)
    time = brentq(lambda t: tip(t) - gap, 0.3 * rough, 3 * rough, xtol=1e-16)
    return time, speed(time)
