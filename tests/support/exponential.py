"""A solver that lives by the FMUs' Jacobian: exponential Rosenbrock steps, exact for what is linear in the system.

The beams' fastest modes, which let an explicit solver take two thousand evaluations a millisecond, cost nothing then:
what the steps' length follows is the curvature of the laws. The method is exprb43, of order 4 with an error estimate
of order 3 (M. Hochbruck, A. Ostermann, J. Schweitzer, Exponential Rosenbrock-type methods, SIAM J. Numer. Anal. 47,
2009). With phi_1(a) = (exp(a) - 1)/a, phi_k(a) = (phi_{k-1}(a) - 1/(k-1)!)/a, with F the right-hand side, J its
Jacobian at u and D(U) = F(U) - F(u) - J (U - u):

    U_2 = u + h/2 phi_1(hJ/2) F(u)
    U_3 = u + h phi_1(hJ) (F(u) + D(U_2))
    u+  = u + h phi_1(hJ) F(u) + h phi_3(hJ) (16 D(U_2) - 2 D(U_3)) + h phi_4(hJ) (12 D(U_3) - 48 D(U_2))

The last term is the error estimate.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from .exchange import Grasp

# Events are looked for at the ends of steps: in none a beam's slow modes (562 rad/s) go there and back. After one begins a short step.
LONGEST = 5e-4
# How near to an event the host comes (s): a hundredth of what is asked for.
NEAR = 1e-12


class Step:
    """Steps of any length from one point; states are in units of their nominals. What is below `nothing` is linear."""

    def __init__(
        self,
        rates: Callable[[np.ndarray], np.ndarray],
        u: np.ndarray,
        J: np.ndarray,
        size: Callable[[np.ndarray], float],
        nothing: float,
    ) -> None:
        self.rates, self.u, self.J, self.size, self.nothing = rates, u, J, size, nothing
        self.F = rates(u)

    def to(self, h: float) -> tuple[np.ndarray, float]:
        """The state after h, and the greatest error in it by estimate."""
        from scipy.linalg import expm

        n, u, J, F = len(self.u), self.u, self.J, self.F
        half = np.zeros((n + 1, n + 1))
        half[:n, :n], half[:n, n] = h / 2 * J, h / 2 * F
        half = expm(half)
        middle = half[:n, n]
        # The square of exp of a half is exp of the whole.
        linear = half[:n, :n] @ middle + middle

        def bent(way: np.ndarray) -> np.ndarray:
            """h D(u + way)."""
            return h * (self.rates(u + way) - F - J @ way)

        def products(b: np.ndarray) -> np.ndarray:
            """phi_1(hJ) b to phi_4(hJ) b, by one exponential (Al-Mohy and Higham, SIAM J. Sci. Comput. 33, 2011)."""
            wide = np.zeros((n + 4, n + 4))
            wide[:n, :n], wide[:n, n] = h * J, b
            wide[n:, n:] = np.eye(4, k=1)
            return expm(wide)[:n, n:]

        second = bent(middle)
        if self.size(second) < self.nothing:
            return u + linear, 0.0
        second = products(second)
        third = products(bent(linear + second[:, 0]))
        error = 12 * third[:, 3] - 48 * second[:, 3]
        return u + linear + 16 * second[:, 2] - 2 * third[:, 2] + error, self.size(error)


def integrate(
    grasp: Grasp,
    stop: float,
    times: Sequence[float],
    at: Callable[[float, np.ndarray], None],
    tolerance: float,
    longest: float = LONGEST,
) -> list[float]:
    """Runs the grasp from its start to `stop`, calling `at` at the times with the states; when events came.

    Each step may err by `tolerance` times the nominal value of each state but the supplied and the lost energy: those
    are integrals which nothing else follows from, and the products in them would be the one thing that is not linear. An event is where an event indicator changes its side of zero, located by regula falsi on
    steps of other lengths from the same point.
    """
    nominal = np.concatenate([grasp.plant.nominals, grasp.controller.nominals])
    z, t, h = grasp.start(), 0.0, 1e-6
    waiting, found = [time for time in times if time <= stop], []
    states = (*grasp.plant.states, *grasp.controller.states)
    matters = np.array([name not in ("supplied_energy", "impact_loss") for name in states])

    def rates(u: np.ndarray) -> np.ndarray:
        return grasp.rates(0.0, u * nominal) / nominal

    def size(u: np.ndarray) -> float:
        return float(np.abs(u[matters]).max())

    while t < stop:
        y = grasp.indicators(z)
        step = Step(rates, z / nominal, grasp.jacobian(t, z) * nominal / nominal[:, None], size, 1e-3 * tolerance)
        target = waiting[0] if waiting else stop
        while True:
            arrives = t + h >= target * (1 - 1e-12)
            length = target - t if arrives else h
            u, error = step.to(length)
            factor = min(4.0, 0.9 * (tolerance / max(error, 1e-300)) ** 0.25)
            if error <= tolerance:
                # A step that only ends where it must says little against longer ones.
                h = min(longest, max(h, length * factor))
                break
            h = length * factor
        if np.any((grasp.indicators(u * nominal) > 0) != (y > 0)):
            length, u = first_event(grasp, step, y, length, u, nominal)
            t += length
            grasp.put(u * nominal)
            found.append(t)
            z, h = grasp.event(), min(h, 1e-3 * longest)
            continue
        z, t = u * nominal, target if arrives else t + length
        if arrives and waiting:
            at(t, z)
            waiting.pop(0)
    return found


def first_event(
    grasp: Grasp, step: Step, at_begin: np.ndarray, length: float, end: np.ndarray, nominal: np.ndarray
) -> tuple[float, np.ndarray]:
    """How far into the step the first indicator has just changed its side, and the state there: the Illinois method."""
    sides, kept = at_begin > 0, 0
    before, after, at_end = 0.0, length, grasp.indicators(end * nominal)
    while after - before > NEAR:
        changed = (at_end > 0) != sides
        begin, finish = at_begin[changed], at_end[changed]
        zero = np.min(before + (after - before) * begin / (begin - finish))
        # Never an end itself, and in the last steps from both sides.
        guess = min(max(zero, before + 0.4 * NEAR), after - 0.4 * NEAR)
        u, _ = step.to(guess)
        y = grasp.indicators(u * nominal)
        if np.array_equal(y > 0, sides):
            at_end = 0.5 * at_end if kept == 1 else at_end
            before, at_begin, kept = guess, y, 1
        else:
            at_begin = 0.5 * at_begin if kept == 2 else at_begin
            after, at_end, end, kept = guess, y, u, 2
    return after, end
