//! The quadratic forms −Ḣ − φH and H − θW, reduced to fifteen scalars.
//!
//! W = E + V with E = ½Σ(EI∫q''² + ρ∫ẏ²) and, over the three ends (hub 1, hub 2, object),
//!
//! ```text
//! V = Σ ½A p² + ½B(ζ + w p + x a + y δ)² + ½R(a'² + 2g a'δ' + h δ'²),    a' = a + u p, δ' = δ + v p.
//! ```
//!
//! ζ = ṗ + χS, a = ṗ − v̂ + νS and δ = (Δ̂ − Δ)/(m̂ω) are the combinations whose rates contain no Ṡ: with the force
//! F = −m̂(k s + f G v̂) − v̂/c − m̂ωδ, v̂ = ṗ − (a − νS), S = (ζ − ṗ)/χ,
//!
//! ```text
//! ζ̇ = F/m,    ȧ = (1/m − 1/m̂) F − 2ω(a − νS) − ωδ,    δ̇ = ω(a − νS) − Δ̇/(m̂ω).
//! ```
//!
//! Then
//!
//! ```text
//! H = W + ε_1 Σρ∫(x−l) ẏ q' + ε_2 Σρ∫ẏ y,    Ė = ṗ S_object + Σ ė_i M̃_i,
//! d/dt Σρ∫(x−l)ẏq' = Σ [−3/2 EI∫q''² + (l/2EI) M̃² − ½ρ∫ẏ² + ρ ė∫(x−l)ẏ],
//! d/dt Σρ∫ẏy      = Σ [ρ∫ẏ² − EI∫q''² + e M̃] + p S_object.
//! ```
//!
//! The fields enter as √EI q_i'' and √ρ ẏ_i, elements of L²(0, l). The first occurs only with its norm (by the sharp
//! inequalities of [`beam`](super::beam), and (l e − p)² = q(l)² ≤ (l³/3EI) EI∫q''² with weight τ_i). The second occurs
//! with its norm and its inner products with the fixed functions x−l and x. Completing both squares leaves a form in the
//! scalars of the ends that keeps all signs: no term is replaced by its worst case.

use super::beam::{deflection_constant, slope_constant};
use super::{Constants, Port, Storage};
use crate::Grasp;
use crate::interval::Number;

/// Scalars of one end: position, rate, ζ, a, δ.
const PER_END: usize = 5;
/// Scalars of the form.
pub(super) const SIZE: usize = 3 * PER_END;
const POSITION: usize = 0;
const RATE: usize = 1;
const ZETA: usize = 2;
const ERROR: usize = 3;
const LEARNT: usize = 4;
/// The object's end.
const OBJECT: usize = 2;

type Row<N> = [N; SIZE];
type Matrix<N> = [Row<N>; SIZE];

fn zero<N: Number>() -> Row<N> {
    [N::exact(0.0); SIZE]
}

fn unit<N: Number>(end: usize, which: usize) -> Row<N> {
    let mut row = zero();
    row[PER_END * end + which] = N::exact(1.0);
    row
}

/// Σ factor · row.
fn combine<N: Number>(parts: &[(N, Row<N>)]) -> Row<N> {
    let mut sum = zero::<N>();
    for (factor, row) in parts {
        for (sum, entry) in sum.iter_mut().zip(row) {
            *sum = *sum + *factor * *entry;
        }
    }
    sum
}

/// Adds factor · a · b as a symmetric matrix. The rows of one end are zero elsewhere, which a search need not visit.
fn add<N: Number>(matrix: &mut Matrix<N>, factor: N, a: &Row<N>, b: &Row<N>) {
    let half = factor * N::exact(0.5);
    let (mut used, mut count) = ([0; SIZE], 0);
    for i in 0..SIZE {
        used[count] = i;
        count += usize::from(!(a[i].vanishes() && b[i].vanishes()));
    }
    for (row, &i) in used[..count].iter().enumerate() {
        for &j in &used[..=row] {
            matrix[i][j] = matrix[i][j] + half * (a[i] * b[j] + a[j] * b[i]);
        }
    }
}

/// Adds −dV/dt − ṗS − φV of one end; returns its S.
fn add_end<N: Number>(matrix: &mut Matrix<N>, end: usize, port: &Port, storage: &Storage, phi: N) -> Row<N> {
    let n = N::exact;
    let (m, assumed, c) = (n(port.inertia), n(port.assumed_inertia), n(port.strain));
    let (k, f, g) = (n(port.reach), n(port.feedforward), n(port.slope));
    // As `Port::crossing` and `observed_crossing`, but enclosed.
    let chi = (assumed * f * c + n(port.load_rate)) / m;
    let nu = (assumed / m - n(1.0)) * f * c + n(port.load_rate) / m;
    let (p, rate, zeta) = (unit(end, POSITION), unit(end, RATE), unit(end, ZETA));
    let load = combine(&[(n(1.0) / chi, zeta), (n(-1.0) / chi, rate)]);
    let omega = n(port.observer);
    let watched = port.observer > 0.0;
    let (crossed_error, delta) = if watched { (unit(end, ERROR), unit(end, LEARNT)) } else { (zero(), zero()) };
    // ṗ − v̂, and v̂.
    let error = if watched { combine(&[(n(1.0), crossed_error), (-nu, load)]) } else { zero() };
    let seen = combine(&[(n(1.0), rate), (n(-1.0), error)]);
    let s = combine(&[(g, p), (n(1.0), seen), (c, load)]);
    let force = combine(&[(-(assumed * k), s), (-(assumed * f * g + n(1.0) / c), seen), (-(assumed * omega), delta)]);
    let zeta_dot = combine(&[(n(1.0) / m, force)]);
    let error_dot = combine(&[(n(1.0) / m - n(1.0) / assumed, force), (n(-2.0) * omega, error), (-omega, delta)]);
    let delta_dot = combine(&[(omega, error)]);

    let [a, b, w, x, y] = [storage.position, storage.crossed, storage.slope, storage.error, storage.learnt].map(n);
    let crossed = combine(&[(w, p), (n(1.0), zeta), (x, crossed_error), (y, delta)]);
    let crossed_dot = combine(&[(w, rate), (n(1.0), zeta_dot), (x, error_dot), (y, delta_dot)]);
    add(matrix, n(-1.0), &rate, &load);
    add(matrix, -a, &p, &rate);
    add(matrix, -b, &crossed, &crossed_dot);
    let half = n(-0.5) * phi;
    add(matrix, half * a, &p, &p);
    add(matrix, half * b, &crossed, &crossed);
    if watched {
        let [r, mixed, h] = storage.observer.map(n);
        let [u, v] = storage.drift.map(n);
        let (error, error_dot) =
            (combine(&[(n(1.0), crossed_error), (u, p)]), combine(&[(n(1.0), error_dot), (u, rate)]));
        let (learnt, learnt_dot) = (combine(&[(n(1.0), delta), (v, p)]), combine(&[(n(1.0), delta_dot), (v, rate)]));
        let by_error = combine(&[(r, error), (r * mixed, learnt)]);
        let by_learnt = combine(&[(r * mixed, error), (r * h, learnt)]);
        add(matrix, n(-1.0), &by_error, &error_dot);
        add(matrix, n(-1.0), &by_learnt, &learnt_dot);
        add(matrix, half, &by_error, &error);
        add(matrix, half, &by_learnt, &learnt);
    } else {
        for which in [ERROR, LEARNT] {
            matrix[PER_END * end + which][PER_END * end + which] = n(1.0);
        }
    }
    load
}

/// A lower bound of −Ḣ − φH in the scalars, lower triangle. `None` if completing a square fails: then nothing is proved.
pub(super) fn decay<N: Number>(grasp: &Grasp, ports: &[Port; 3], constants: &Constants, phi: f64) -> Option<Matrix<N>> {
    let n = N::exact;
    let (l, phi) = (n(grasp.length), n(phi));
    let (one, half) = (n(1.0), n(0.5));
    let (e1, e2) = (n(constants.epsilon_1), n(constants.epsilon_2));
    let mut matrix = [zero::<N>(); SIZE];
    let loads: [Row<N>; 3] =
        std::array::from_fn(|end| add_end(&mut matrix, end, &ports[end], &constants.storage[end], phi));
    let position = unit(OBJECT, POSITION);
    for (i, load) in loads.iter().take(2).enumerate() {
        let (ei, rho) = (n(grasp.arms[i].ei), n(grasp.arms[i].rho));
        let (e, e_dot) = (unit(i, POSITION), unit(i, RATE));
        let cube_third = l * l * l / n(3.0);
        add(&mut matrix, -(e1 * l * half / ei), load, load);
        add(&mut matrix, -e2, &e, load);
        let tau = n(constants.tau[i]);
        let tip = combine(&[(l, e), (-one, position)]);
        add(&mut matrix, tau, &tip, &tip);

        let bending = n(1.5) * e1 + e2 - half * phi - tau * cube_third / ei;
        let crossing = phi * (e1 * slope_constant() + e2 * deflection_constant()) * l * l * (rho / ei).sqrt();
        if !bending.is_positive() {
            return None;
        }
        let motion = half * e1 - e2 - half * phi - crossing * crossing / (n(4.0) * bending);
        if !motion.is_positive() {
            return None;
        }
        // ‖√ρ(ε_1(x−l)ė − φε_2 x e)‖², with ∫x² = ∫(x−l)² = l³/3 and ∫x(x−l) = −l³/6.
        let factor = -(rho * cube_third / (n(4.0) * motion));
        add(&mut matrix, factor * e1 * e1, &e_dot, &e_dot);
        add(&mut matrix, factor * phi * e1 * e2, &e, &e_dot);
        add(&mut matrix, factor * phi * phi * e2 * e2, &e, &e);
    }
    add(&mut matrix, -e2, &position, &loads[OBJECT]);
    Some(matrix)
}

/// Whether H ≥ θW is certain. The scalars enter H only through V and −ε_2 ρ e∫ẏx; V is positive definite.
pub(super) fn dominates<N: Number>(grasp: &Grasp, constants: &Constants, theta: f64) -> bool {
    let n = N::exact;
    let l = n(grasp.length);
    let rest = n(0.5) * (n(1.0) - n(theta));
    let (e1, e2) = (n(constants.epsilon_1), n(constants.epsilon_2));
    constants.storage.iter().all(Storage::is_positive)
        && (0..2).all(|i| {
            let (ei, rho) = (n(grasp.arms[i].ei), n(grasp.arms[i].rho));
            let crossing = (e1 * slope_constant() + e2 * deflection_constant()) * l * l * (rho / ei).sqrt();
            if !rest.is_positive() {
                return false;
            }
            let motion = rest - crossing * crossing / (n(4.0) * rest);
            if !motion.is_positive() {
                return false;
            }
            // (1−θ)½A e² − ρε_2²(l³/3)e²/(4 motion) > 0; the rest of V is not needed.
            let share = rho * e2 * e2 * l * l * l / (n(12.0) * motion);
            (rest * n(constants.storage[i].position) - share).is_positive()
        })
}
