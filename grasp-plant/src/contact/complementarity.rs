//! Which sides push: a linear complementarity problem for two contacts.
//!
//! Forces or impulses p_i that only push, and accelerations or velocities w_i of the gaps that only open, never both on one
//! side:
//!
//! ```text
//! w = D p + b,    p ≥ 0,    w ≥ 0,    p_i w_i = 0,    D = ⎡ 1/m_1 + 1/M    −1/M        ⎤
//!                                                         ⎣ −1/M           1/m_2 + 1/M ⎦
//! ```
//!
//! D, the inverse mass that the pairs of forces feel, is positive definite, so there is exactly one solution. Which sides are
//! pushed is found by trying.

/// D.
#[derive(Clone, Copy, Debug)]
pub(super) struct Delassus {
    /// Its diagonal.
    pub diagonal: [f64; 2],
    /// 1/M.
    coupling: f64,
}

impl Delassus {
    pub fn new(tip_masses: [f64; 2], object_mass: f64) -> Self {
        let coupling = 1.0 / object_mass;
        Self { diagonal: tip_masses.map(|mass| 1.0 / mass + coupling), coupling }
    }

    /// Those p that solve the problem among the sides that are `closed`; others have no force. Sides whose solution is zero to
    /// `noise` (in the unit of b) count as pushed.
    pub fn solve(&self, b: [f64; 2], closed: [bool; 2], noise: f64) -> ([f64; 2], [bool; 2]) {
        let [d_1, d_2] = self.diagonal;
        if closed == [true; 2] {
            let determinant = d_1 * d_2 - self.coupling * self.coupling;
            let p = [
                -(d_2 * b[0] + self.coupling * b[1]) / determinant,
                -(self.coupling * b[0] + d_1 * b[1]) / determinant,
            ];
            if p[0] * d_1 >= -noise && p[1] * d_2 >= -noise {
                return (p.map(|p| p.max(0.0)), [true; 2]);
            }
        }
        // One side pushes and the other opens: the one that pushes harder, if rounding should let both.
        let alone = [0, 1].map(|i| if closed[i] { -b[i] / self.diagonal[i] } else { f64::NEG_INFINITY });
        let mut best: Option<usize> = None;
        for i in 0..2 {
            let other = 1 - i;
            let pushes = alone[i] * self.diagonal[i] >= -noise;
            let opens = !closed[other] || b[other] - self.coupling * alone[i] >= -noise;
            if pushes && opens && best.is_none_or(|best| alone[i] > alone[best]) {
                best = Some(i);
            }
        }
        let mut p = [0.0; 2];
        let mut pushed = [false; 2];
        if let Some(i) = best {
            p[i] = alone[i].max(0.0);
            pushed[i] = true;
        }
        (p, pushed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over a grid of b the solution satisfies every line of the problem.
    #[test]
    fn forces_push_gaps_open_and_never_both() {
        for (masses, object) in [([0.1, 0.1], 0.3), ([1e-3, 2.0], 0.05), ([5.0, 0.1], 1e3)] {
            let delassus = Delassus::new(masses, object);
            for i in -10..=10 {
                for j in -10..=10 {
                    let b = [f64::from(i), f64::from(j)];
                    for closed in [[true, true], [true, false], [false, true]] {
                        let (p, pushed) = delassus.solve(b, closed, 1e-12);
                        let w = [
                            delassus.diagonal[0] * p[0] - delassus.coupling * p[1] + b[0],
                            delassus.diagonal[1] * p[1] - delassus.coupling * p[0] + b[1],
                        ];
                        for side in 0..2 {
                            assert!(p[side] >= 0.0);
                            assert!(closed[side] || !pushed[side]);
                            assert!(!closed[side] || w[side] >= -1e-9, "{b:?} {closed:?} {w:?}");
                            assert!(!pushed[side] || w[side].abs() < 1e-9, "{b:?} {closed:?} {w:?}");
                            assert!(pushed[side] || p[side] == 0.0);
                        }
                    }
                }
            }
        }
    }
}
