"""The errata of docs/errata.md, each shown by numbers. Fields are polynomials, so integrals are exact."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial

L_ARM, EI, RHO = 0.2, 0.115, 0.054
RANDOM = np.random.default_rng(4)


def integral(f: Polynomial) -> float:
    """Over the arm."""
    F = f.integ()
    return float(F(L_ARM) - F(0))


def deflection() -> Polynomial:
    """A random q with q(0) = q'(0) = q''(l) = 0, (24)."""
    q = Polynomial([0, 0, *RANDOM.normal(size=4)])
    return q - Polynomial([0, 0, 1]) * (q.deriv(2)(L_ARM) / 2)


def test_lemma_1_second_inequality_fails() -> None:
    """(a^2 + b^2)/2 <= w a^2 + b^2/w is false for w < 1/2, b = 0; a b <= (w a^2 + b^2/w)/2 is what is needed."""
    a, b, w = 1.0, 0.0, 0.25
    assert (a**2 + b**2) / 2 > w * a**2 + b**2 / w
    a, b, w = RANDOM.normal(size=1000), RANDOM.normal(size=1000), RANDOM.uniform(0.01, 100, 1000)
    assert np.all(a * b <= (w * a**2 + b**2 / w) / 2 + 1e-12)


def test_72_sign() -> None:
    """dE/dt = beta_1 EI {-y'(l) q'''(l) - y_x'(0) q''(0)}: no minus in front."""
    for _ in range(20):
        q, q_dot, e_dot = deflection(), deflection(), RANDOM.normal()
        y_dot = q_dot - Polynomial([0, e_dot])
        rate = integral(q.deriv(2) * q_dot.deriv(2)) - integral(y_dot * q.deriv(4))
        right = -y_dot(L_ARM) * q.deriv(3)(L_ARM) - y_dot.deriv()(0) * q.deriv(2)(0)
        assert rate == pytest.approx(right, rel=1e-9, abs=1e-10)
        assert rate != pytest.approx(-right, rel=1e-3)


def test_73_square() -> None:
    """With s = g z + v + S, v S = (s^2 - g^2 z^2 - v^2 - S^2)/2 - g z v - g z S: g^2 where the paper prints g."""
    g, z, v, S = RANDOM.normal(size=4)
    s = g * z + v + S
    rest = s**2 / 2 - v**2 / 2 - S**2 / 2 - g * z * v - g * z * S
    assert v * S == pytest.approx(rest - g**2 * z**2 / 2)
    assert v * S != pytest.approx(rest - g * z**2 / 2, rel=1e-3)


def test_73_stiffness() -> None:
    """P' sum(EI_i q_i''') of equal arms is EI p' sum(q_i'''), not (EI_1 + EI_2) p' sum(q_i''')."""
    p_dot, q1, q2 = RANDOM.normal(size=3)
    assert p_dot * (EI * q1 + EI * q2) == pytest.approx(EI * p_dot * (q1 + q2))


def test_77_sign() -> None:
    """-EI int (x-l) q' q'''' = -3/2 EI int q''^2 + 1/2 EI l q''(0)^2."""
    for _ in range(20):
        q = deflection()
        left = -integral(Polynomial([-L_ARM, 1]) * q.deriv() * q.deriv(4))
        squares, root = integral(q.deriv(2) ** 2), L_ARM * q.deriv(2)(0) ** 2
        assert left == pytest.approx(-1.5 * squares + 0.5 * root, rel=1e-9)
        assert left != pytest.approx(-1.5 * squares - 0.5 * root, rel=1e-3)


def test_70_needs_the_larger_density_and_factor() -> None:
    """|C| <= phi_1 E fails as printed for arms of different density, only the heavy one moving; it holds with max."""
    heavy = 100 * RHO
    E_min = 0.5 * min(EI, RHO)
    y_dot, q = Polynomial([0, 1.0]), Polynomial([0, 0, 3 * L_ARM, -1.0])
    ratios = []
    for scale in np.logspace(-4, 4, 200):
        C = abs(heavy * integral(Polynomial([-L_ARM, 1]) * y_dot * q.deriv() * scale))
        E = 0.5 * (EI * scale**2 * integral(q.deriv(2) ** 2) + heavy * integral(y_dot**2))
        ratios.append(C / E)
    printed, right = L_ARM * RHO * L_ARM**2 / E_min, L_ARM * heavy / E_min
    assert max(ratios) <= right
    assert max(ratios) > printed


def feasible(g: float, B: float, a: float, squared: bool) -> bool:
    """(82), (86), (88) with theta_3 = a g and the best theta_1, theta_2."""
    theta2, theta3 = 0.5 / g, a * g
    room = B * (0.5 - g / theta3)
    if room <= 0:
        return False
    theta1 = 1 / room  # (86): any larger
    return 1 - theta1 / g + B * ((g if squared else 1.0) / 2 - theta3 - 1 / theta2) > 0  # (82)


def test_conditions_82_to_88() -> None:
    """As printed only for mu + c1 < 1/8; with (73) put right for no gains at all."""
    g, B = 10 ** RANDOM.uniform(-5, 3, 200_000), 10 ** RANDOM.uniform(-6, 8, 200_000)
    a = 2 + 10 ** RANDOM.uniform(-3, 4, 200_000)
    printed = np.array([feasible(*row, squared=False) for row in zip(g, B, a)])
    assert np.any(printed)
    assert np.max(g[printed]) < 1 / 8
    assert not any(feasible(*row, squared=True) for row in zip(g, B, a))
    # Where the search could miss something: the maximum over B in closed form.
    a = np.linspace(2.001, 1000, 100_000)
    assert np.max((0.5 - 1 / a) / (4 * (a + 1.5))) < 1


def test_70_holds_for_the_papers_arms() -> None:
    """The smallest c with |C| <= c E: for a given q the worst y_dot is a multiple of (l-x) q', which leaves the largest
    ratio of int (l-x)^2 q'^2 to int q''^2, an eigenvalue. Polynomials of degree 12 give it to five digits."""
    basis = [Polynomial([0] * n + [L_ARM**-n]) for n in range(2, 13)]
    weight = Polynomial([L_ARM, -1.0]) ** 2
    top = np.array([[integral(weight * a.deriv() * b.deriv()) for a in basis] for b in basis])
    bottom = np.array([[integral(a.deriv(2) * b.deriv(2)) for a in basis] for b in basis])
    smallest = np.sqrt(RHO / EI * np.max(np.linalg.eigvals(np.linalg.solve(bottom, top)).real))
    assert smallest == pytest.approx(0.0068, rel=0.01)
    printed = L_ARM * RHO * min(1, L_ARM**2) / (0.5 * min(EI, RHO))
    assert printed == pytest.approx(0.016)
    assert smallest < printed


def test_92_holds_though_91_does_not_give_it() -> None:
    """z^2/2 is a part of V_o with the coefficient 1, so z^2/2 <= H/phi_2; (91) has phi_4 <= 1 and a factor 2 more."""
    for H, phi2, phi4 in RANDOM.uniform(0.01, 1, size=(1000, 3)):
        printed = np.sqrt(2 * H / (phi2 * phi4))
        assert np.sqrt(2 * H / phi2) <= printed < np.sqrt(4 * H / (phi2 * phi4))


def test_ultimate_bounds_are_vacuous() -> None:
    """h/(phi phi_2) >= b_3^2/(b_3-1) m^2 >= 4 m^2, at b_3 = 2: no gain makes (92) or (94) say anything."""
    m, J = 0.5, 0.0073
    b3 = np.linspace(1.0001, 100, 1_000_000)
    least = np.min(b3**2 / (b3 - 1))
    assert least == pytest.approx(4)
    assert np.sqrt(2 * least * m**2 / (m / 2)) == pytest.approx(2.83, abs=0.01)  # m
    assert np.sqrt(2 * least * (m**2 + 2 * J**2) / (J / 2)) == pytest.approx(23.4, abs=0.1)  # rad


def test_object_form_is_never_definite() -> None:
    """With s = 0, p' = -g z - S: dV_1/dt + b p' S = -g z^2 - (1 + b g) z S - b S^2, not negative at z = -S/g, -b S."""
    for g, b, S in 10 ** RANDOM.uniform(-3, 3, size=(1000, 3)):
        for z in (-S / g, -b * S):
            p_dot = -g * z - S
            terms = np.array([-g * z**2, -(1 + b * g) * z * S, -b * S**2])
            size = np.sum(np.abs(terms))
            assert z * p_dot + b * p_dot * S == pytest.approx(np.sum(terms), abs=1e-12 * size)
            assert np.sum(terms) >= -1e-12 * size
