//! Loops whose commands are held over a step: the spectral radius of one coupled step.
//!
//! The plant's step is exact: ξ⁺ = e^{Ah} ξ + ∫e^{At}dt B g in energy coordinates of the parameters' order. The command of
//! an instant uses the signals of the same instant ("at once"), or of `delay` steps before. θ_1 and θ_2 follow from (12),
//! so the state does not contain the two invariants, which would appear as eigenvalues 1.

use crate::LinearLoop;
use crate::law::SampledLaw;
use grasp_control::INPUT_NAMES;
use grasp_plant::nalgebra::{DMatrix, linalg::Schur};
use grasp_plant::{Plant, StateSpace, held_step};

/// The plant over steps of one size, for loops with laws that have states.
///
/// The law receives the signals of the instant, updates its state with them, and commands; the plant receives these
/// commands, or those of `delay` steps before. That is a Gauss–Seidel master, and with one step of delay a Jacobi master.
#[derive(Clone, Debug)]
pub struct Coupled {
    step: DMatrix<f64>,
    input: DMatrix<f64>,
    signals: DMatrix<f64>,
}

impl Coupled {
    /// The plant over steps of `h` \[s\].
    #[must_use]
    pub fn new(plant: &Plant, h: f64) -> Self {
        let reduced = Reduced::new(plant);
        let (step, input) = reduced.step(h);
        Self { step, input, signals: reduced.c }
    }

    /// One step of plant and law: the matrix of (ξ, x, u of the last `delay` instants, newest first).
    #[must_use]
    pub fn matrix(&self, law: &SampledLaw, delay: usize) -> DMatrix<f64> {
        let (n, states) = (self.step.nrows(), law.a.nrows());
        let size = n + states + 3 * delay;
        let measured = law.d.columns(0, SIGNALS.len()) * &self.signals;
        let driven = law.b.columns(0, SIGNALS.len()) * &self.signals;
        // The commands as rows on the state.
        let mut commands = DMatrix::zeros(3, size);
        commands.view_mut((0, 0), (3, n)).copy_from(&measured);
        commands.view_mut((0, n), (3, states)).copy_from(&law.c);
        let mut acting = DMatrix::zeros(3, size);
        if delay == 0 {
            acting.copy_from(&commands);
        } else {
            acting.view_mut((0, size - 3), (3, 3)).fill_with_identity();
        }
        let mut motion = &self.input * acting;
        motion.view_mut((0, 0), (n, n)).zip_apply(&self.step, |sum, step| *sum += step);
        let mut whole = DMatrix::zeros(size, size);
        whole.view_mut((0, 0), (n, size)).copy_from(&motion);
        whole.view_mut((n, 0), (states, size)).copy_from(&(driven * motion));
        whole.view_mut((n, n), (states, states)).zip_apply(&law.a, |sum, a| *sum += a);
        if delay > 0 {
            whole.view_mut((n + states, 0), (3, size)).copy_from(&commands);
            for i in 0..3 * (delay - 1) {
                whole[(n + states + 3 + i, n + states + i)] = 1.0;
            }
        }
        whole
    }

    /// Largest modulus of an eigenvalue of one step.
    #[must_use]
    pub fn spectral_radius(&self, law: &SampledLaw, delay: usize) -> f64 {
        radius(&self.matrix(law, delay))
    }
}

/// Plant and law between samples. Parameters as in the plant's FMU; actuators without limits.
#[derive(Clone, Debug)]
pub struct SampledLoop {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    /// The commands (τ_1, τ_2, u) as rows on the state, without uncertainties, which are in A.
    feedback: DMatrix<f64>,
}

/// Rows on the reduced state that give the signals: θ_i, θ̇_i, y, ẏ, M_i, Ṁ_i, Q_i, Q̇_i.
struct Signals {
    rows: DMatrix<f64>,
}

/// The plant without the two invariants of (12): ξ = (x, y_M).
#[derive(Clone, Debug)]
pub struct Reduced {
    /// A, shape (4k+2)².
    pub a: DMatrix<f64>,
    /// B, shape (4k+2) × 3: torques on hubs 1 and 2, force on the object.
    pub b: DMatrix<f64>,
    /// C, shape 14 × (4k+2), rows in the order of [`SIGNALS`].
    pub c: DMatrix<f64>,
}

/// Names of the signals in the plant's FMU: the measurements among the inputs of every controller.
pub const SIGNALS: [&str; 14] = *INPUT_NAMES.first_chunk().unwrap();

impl Reduced {
    /// The plant's matrices.
    #[must_use]
    pub fn new(plant: &Plant) -> Self {
        let StateSpace { a, b, c, tip_deflection } = plant.state_space();
        let n = a.nrows() - 3;
        let keep: Vec<usize> = (0..n).chain([n + 2]).collect();
        let length = plant.parameters().length;
        // Rates of the root moments from the rows of the moments, which do not see the inputs at once.
        let moment_rates = c.rows(6, 2) * &a;
        let full = DMatrix::from_fn(14, a.ncols(), |row, column| match row {
            // (12) in deviations: θ_i = (w_i(l) + y_M)/l.
            0 | 1 => (tip_deflection[(row, column)] + f64::from(u8::from(column == n + 2))) / length,
            12 | 13 => moment_rates[(row - 12, column)],
            _ => c[(row, column)],
        });
        Self { a: a.select_rows(&keep).select_columns(&keep), b: b.select_rows(&keep), c: full.select_columns(&keep) }
    }

    /// e^{Ah} and ∫_0^h e^{At} dt B.
    #[must_use]
    pub fn step(&self, h: f64) -> (DMatrix<f64>, DMatrix<f64>) {
        held_step(&self.a, &self.b, h)
    }
}

impl SampledLoop {
    /// Plant and law.
    #[must_use]
    pub fn new(plant: &Plant, law: &LinearLoop) -> Self {
        let Reduced { a, b, c } = Reduced::new(plant);
        let signals = Signals { rows: c };
        let feedback = signals.feedback(law);
        Self { a, b, feedback }
    }

    /// Largest modulus of an eigenvalue of one step of `h` \[s\] with commands `delay` steps late.
    #[must_use]
    pub fn spectral_radius(&self, h: f64, delay: usize) -> f64 {
        let n = self.a.nrows();
        let plant = Reduced { a: self.a.clone(), b: self.b.clone(), c: DMatrix::zeros(0, n) };
        let (step, input) = plant.step(h);
        if delay == 0 {
            return radius(&(step + input * &self.feedback));
        }
        // State (ξ, u of the last `delay` instants, newest first).
        let size = n + 3 * delay;
        let mut whole = DMatrix::zeros(size, size);
        whole.view_mut((0, 0), (n, n)).copy_from(&step);
        whole.view_mut((0, size - 3), (n, 3)).copy_from(&input);
        whole.view_mut((n, 0), (3, n)).copy_from(&self.feedback);
        for i in 0..3 * (delay - 1) {
            whole[(n + 3 + i, n + i)] = 1.0;
        }
        radius(&whole)
    }

    /// The first unstable step size \[s\] up to `longest`, `delay` steps late, on a grid of 1 % refined to 1e-6; `None` if
    /// the loop is stable at all of them.
    #[must_use]
    pub fn first_unstable_step(&self, delay: usize, shortest: f64, longest: f64) -> Option<f64> {
        // If the plant alone is undamped, the loop's eigenvalues are on the circle up to rounding.
        let unstable = |h: f64| self.spectral_radius(h, delay) > 1.0 + 1e-10;
        let mut low = shortest;
        if unstable(low) {
            return Some(low);
        }
        while low < longest {
            let high = (1.01 * low).min(longest);
            if unstable(high) {
                let (mut low, mut high) = (low, high);
                while high - low > 1e-6 * low {
                    let middle = 0.5 * (low + high);
                    if unstable(middle) { high = middle } else { low = middle }
                }
                return Some(high);
            }
            low = high;
        }
        None
    }
}

impl Signals {
    /// Rows of the commands, without the built-in uncertainties.
    fn feedback(&self, law: &LinearLoop) -> DMatrix<f64> {
        let row = |parts: &[(usize, f64)]| {
            let mut sum = DMatrix::zeros(1, self.rows.ncols());
            for (signal, factor) in parts {
                sum -= self.rows.row(*signal) * *factor;
            }
            sum
        };
        let mut rows = DMatrix::zeros(3, self.rows.ncols());
        for (i, hub) in law.hub.iter().enumerate() {
            let command = row(&[(i, hub.angle), (2 + i, hub.rate), (6 + i, hub.moment), (12 + i, hub.moment_rate)]);
            rows.row_mut(i).copy_from(&command.row(0));
        }
        let object = &law.object;
        let command = row(&[
            (4, object.position),
            (5, object.rate),
            (8, object.shear[0]),
            (9, object.shear[1]),
            (10, object.shear_rate[0]),
            (11, object.shear_rate[1]),
        ]);
        rows.row_mut(2).copy_from(&command.row(0));
        rows
    }
}

/// ‖Aᵐ‖ is a constant times the m-th power of the radius, times at most a power of m: after 40 squarings the error of its
/// logarithm is 1e-10.
const SQUARINGS: usize = 40;

fn radius(matrix: &DMatrix<f64>) -> f64 {
    // The QR iteration comes to no end for some matrices with many states that only listen.
    match Schur::try_new(matrix.clone(), f64::EPSILON, 60 * matrix.nrows()) {
        Some(schur) => schur.complex_eigenvalues().iter().map(|value| value.re.hypot(value.im)).fold(0.0, f64::max),
        None => radius_of_powers(matrix),
    }
}

/// lim ‖Aᵐ‖^{1/m} by squaring, in logarithms.
fn radius_of_powers(matrix: &DMatrix<f64>) -> f64 {
    let (mut power, mut logarithm, mut share) = (matrix.clone(), 0.0, 1.0);
    for _ in 0..SQUARINGS {
        let size = power.norm();
        if size == 0.0 || !size.is_finite() {
            return size;
        }
        logarithm += share * size.ln();
        power /= size;
        power = &power * &power;
        share *= 0.5;
    }
    (logarithm + share * power.norm().ln()).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use grasp_plant::Parameters;

    fn pd() -> SampledLoop {
        let plant = Plant::new(Parameters::default()).unwrap();
        SampledLoop::new(&plant, &LinearLoop::pds([10.0, 9.0], [60.0; 2], [55.0; 2], [0.0; 2]))
    }

    /// Powers and eigenvalues give the same radius, near and on the circle, within the rounding error that each step adds
    /// to a power.
    #[test]
    fn powers_have_the_radius_of_the_eigenvalues() {
        let pd = pd();
        let plant = Reduced { a: pd.a.clone(), b: pd.b.clone(), c: DMatrix::zeros(0, pd.a.nrows()) };
        for h in [1e-4, 2e-4, 3e-4] {
            let (step, input) = plant.step(h);
            let matrix = step + input * &pd.feedback;
            let (found, exact) = (radius_of_powers(&matrix), radius(&matrix));
            assert!((found - exact).abs() < 1e-9, "{found} {exact}");
        }
        assert_eq!(radius_of_powers(&DMatrix::zeros(3, 3)), 0.0);
    }

    /// PD one step late: stable below 0.0895 ms, where the 562 rad/s mode begins to grow with 1e-4 1/s (0.0897 ms for
    /// orders 6 and 12). At once: 0.266 ms, the limit 2J/k_v of the hubs alone.
    #[test]
    fn the_longest_steps_of_pd() {
        let late = pd().first_unstable_step(1, 5e-5, 2e-4).unwrap();
        assert!((late - 8.95e-5).abs() < 0.02e-5, "{late:e}");
        let at_once = pd().first_unstable_step(0, 5e-5, 5e-4).unwrap();
        assert!((at_once - 2.0 * 0.0073 / 55.0).abs() < 0.02e-4, "{at_once:e}");
    }

    /// PDS: 0.97 ms at once, 0.40 ms one step late, as in the importing guide.
    #[test]
    fn the_longest_steps_of_pds() {
        let plant = Plant::new(Parameters::default()).unwrap();
        let pds = SampledLoop::new(&plant, &LinearLoop::pds([40.0, 35.0], [35.0; 2], [15.0; 2], [10.0; 2]));
        let at_once = pds.first_unstable_step(0, 1e-4, 2e-3).unwrap();
        let late = pds.first_unstable_step(1, 1e-4, 2e-3).unwrap();
        assert!((at_once - 0.97e-3).abs() < 0.01e-3 && (late - 0.4e-3).abs() < 0.005e-3, "{at_once:e} {late:e}");
    }

    /// As h → 0 the step's eigenvalues are those of the exact loop: the slowest of PD, −0.0839 1/s (the 561 rad/s mode).
    #[test]
    fn short_steps_meet_the_continuous_loop() {
        let h = 1e-7;
        let rate = pd().spectral_radius(h, 0).ln() / h;
        assert!((rate + 0.083_947).abs() < 0.01, "{rate}");
    }
}
