//! One block of the modal plant: two coordinates whose motion no other coordinate changes, and the functions of the block
//! that an exact step needs.
//!
//! With Λ the block, a step of size h needs φ_m(Λh) for m = 0 … 3,
//!
//! ```text
//! φ_0(z) = e^z,   φ_{m+1}(z) = (φ_m(z) − 1/m!) / z,   φ_m(z) = Σ z^j / (j+m)!.
//! ```
//!
//! For |Λ|h < 1 they come from the series of φ_3, so that nothing cancels even for slow motions; otherwise from e^z.

use super::elementary::{INVERSE_FACTORIAL, exponential, sine_cosine};
use super::twofold::{Twofold, two_product, two_sum};

/// A 2 × 2 matrix, by rows.
pub(super) type Square = [[f64; 2]; 2];

/// A block Λ.
#[derive(Clone, Copy, Debug)]
pub(super) enum Block {
    /// A vibration, σ ± iω: Λ = [σ, ω·ratio; −ω/ratio, σ].
    Elliptic { sigma: Twofold, omega: Twofold, ratio: f64 },
    /// Two (nearly) equal motions without vibration, σ ± root: Λ = [σ, upper; lower, σ] with upper · lower = root² ≥ 0.
    Hyperbolic { sigma: Twofold, root: f64, upper: f64, lower: f64 },
    /// Two motions without vibration that have nothing to do with each other: Λ = [λ_1, 0; 0, λ_2].
    Diagonal { lambda: [Twofold; 2] },
}

/// The functions of Λh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Functions {
    /// φ_0 − I.
    pub increment: Square,
    /// φ_1 − I.
    pub first_less_one: Square,
    pub second: Square,
    pub third: Square,
}

/// φ_0 − 1, φ_1 − 1, φ_2, φ_3 of one number, or the two parts that a matrix function has.
type Values = [f64; 4];

/// Terms of the series of φ_3: |z|^18 · 3!/21! is below the rounding unit.
const TERMS: usize = 17;

impl Block {
    /// Λ.
    pub fn matrix(&self) -> Square {
        match self {
            Self::Elliptic { sigma, omega, ratio } => [[sigma.hi, omega.hi * ratio], [-omega.hi / ratio, sigma.hi]],
            Self::Hyperbolic { sigma, upper, lower, .. } => [[sigma.hi, *upper], [*lower, sigma.hi]],
            Self::Diagonal { lambda } => [[lambda[0].hi, 0.0], [0.0, lambda[1].hi]],
        }
    }

    /// Λ⁻¹.
    pub fn inverse(&self) -> Square {
        let [[a, b], [c, d]] = self.matrix();
        let determinant = a * d - b * c;
        [[d / determinant, -b / determinant], [-c / determinant, a / determinant]]
    }

    /// The functions of Λh.
    pub fn functions(&self, h: f64) -> Functions {
        match *self {
            Self::Elliptic { sigma, omega, ratio } => {
                let (real, imaginary) = elliptic(times(sigma, h), times(omega, h));
                Functions::new(|m| [[real[m], imaginary[m] * ratio], [-imaginary[m] / ratio, real[m]]])
            }
            Self::Hyperbolic { sigma, root, upper, lower } => {
                let (even, odd) = hyperbolic(times(sigma, h), root * h);
                Functions::new(|m| [[even[m], odd[m] * (h * upper)], [odd[m] * (h * lower), even[m]]])
            }
            Self::Diagonal { lambda } => {
                let [first, second] = lambda.map(|lambda| real(times(lambda, h)));
                Functions::new(|m| [[first[m], 0.0], [0.0, second[m]]])
            }
        }
    }
}

impl Functions {
    fn new(value: impl Fn(usize) -> Square) -> Self {
        Self { increment: value(0), first_less_one: value(1), second: value(2), third: value(3) }
    }
}

/// A number times h, in twice the precision.
fn times(number: Twofold, h: f64) -> Twofold {
    let (hi, error) = two_product(number.hi, h);
    let (hi, lo) = two_sum(hi, error + number.lo * h);
    Twofold { hi, lo }
}

/// φ's of a real number.
fn real(z: Twofold) -> Values {
    let x = z.hi;
    if x.abs() < 1.0 {
        let mut third = INVERSE_FACTORIAL[TERMS + 3];
        for m in (3..TERMS + 3).rev() {
            third = third * x + INVERSE_FACTORIAL[m];
        }
        let second = 0.5 + x * third;
        let first = x * second;
        [x + (z.lo + x * first), first, second, third]
    } else {
        let (value, increment) = exponential(x);
        let increment = increment + value * z.lo;
        let first = increment / x;
        let second = (first - 1.0) / x;
        [increment, first - 1.0, second, (second - 0.5) / x]
    }
}

/// Real and imaginary parts of the φ's at x + iy.
fn elliptic(x: Twofold, y: Twofold) -> (Values, Values) {
    let (a, b) = (x.hi, y.hi);
    if a.abs() + b.abs() < 1.0 {
        let (mut re, mut im) = (INVERSE_FACTORIAL[TERMS + 3], 0.0);
        for m in (3..TERMS + 3).rev() {
            (re, im) = (re * a - im * b + INVERSE_FACTORIAL[m], re * b + im * a);
        }
        let second = (0.5 + (re * a - im * b), re * b + im * a);
        let first = (second.0 * a - second.1 * b, second.0 * b + second.1 * a);
        let increment = (a + (x.lo + (first.0 * a - first.1 * b)), b + (y.lo + (first.0 * b + first.1 * a)));
        ([increment.0, first.0, second.0, re], [increment.1, first.1, second.1, im])
    } else {
        let (value, less_one) = exponential(a);
        let (value, less_one) = (value + value * x.lo, less_one + value * x.lo);
        let (sine, cosine, cosine_less_one) = sine_cosine(y);
        let norm = a * a + b * b;
        let divided = |re: f64, im: f64| ((re * a + im * b) / norm, (im * a - re * b) / norm);
        let increment = (less_one * cosine + cosine_less_one, value * sine);
        let first = divided(increment.0, increment.1);
        let second = divided(first.0 - 1.0, first.1);
        let third = divided(second.0 - 0.5, second.1);
        ([increment.0, first.0 - 1.0, second.0, third.0], [increment.1, first.1, second.1, third.1])
    }
}

/// Parts e, o of φ's = e + o·n at z + n with n² = y².
fn hyperbolic(x: Twofold, y: f64) -> (Values, Values) {
    let a = x.hi;
    if a.abs() + y < 1.0 {
        let square = y * y;
        let (mut even, mut odd) = (INVERSE_FACTORIAL[TERMS + 3], 0.0);
        for m in (3..TERMS + 3).rev() {
            (even, odd) = (even * a + odd * square + INVERSE_FACTORIAL[m], even + odd * a);
        }
        let second = (0.5 + (even * a + odd * square), even + odd * a);
        let first = (second.0 * a + second.1 * square, second.0 + second.1 * a);
        let increment = (a + (x.lo + (first.0 * a + first.1 * square)), 1.0 + (first.0 + first.1 * a));
        ([increment.0, first.0, second.0, even], [increment.1, first.1, second.1, odd])
    } else if y > 0.25 {
        let at = |y: f64| {
            let (hi, lo) = two_sum(a, y);
            real(Twofold { hi, lo: lo + x.lo })
        };
        let (above, below) = (at(y), at(-y));
        let mean = std::array::from_fn(|m| f64::midpoint(above[m], below[m]));
        (mean, std::array::from_fn(|m| (above[m] - below[m]) / (2.0 * y)))
    } else {
        // cosh y − 1 and sinh y / y by their series; here |z| is at least three times y.
        let square = y * y;
        let series = |first: usize| (0..6).rev().fold(0.0, |sum, m| sum * square + INVERSE_FACTORIAL[2 * m + first]);
        let (cosh_less_one, sinh) = (square * series(2), series(1));
        let (value, less_one) = exponential(a);
        let (value, less_one) = (value + value * x.lo, less_one + value * x.lo);
        let norm = a * a - square;
        let divided = |even: f64, odd: f64| ((even * a - odd * square) / norm, (odd * a - even) / norm);
        let increment = (less_one + value * cosh_less_one, value * sinh);
        let first = divided(increment.0, increment.1);
        let second = divided(first.0 - 1.0, first.1);
        let third = divided(second.0 - 0.5, second.1);
        ([increment.0, first.0 - 1.0, second.0, third.0], [increment.1, first.1, second.1, third.1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The functions φ by their series in twice the precision, with halving and doubling: φ_0(2z) = φ_0², φ_1(2z) = φ_1
    /// (φ_0 + 1)/2, φ_2(2z) = (φ_1² + 2φ_2)/4, φ_3(2z) = (φ_1 φ_2 + φ_2 + 2φ_3)/8.
    fn reference(block: &Block, h: f64) -> Functions {
        type Wide = [[Twofold; 2]; 2];
        let add = |l: Wide, r: Wide| -> Wide { std::array::from_fn(|i| std::array::from_fn(|j| l[i][j] + r[i][j])) };
        let product = |l: Wide, r: Wide| -> Wide {
            std::array::from_fn(|i| std::array::from_fn(|j| l[i][0] * r[0][j] + l[i][1] * r[1][j]))
        };
        let scaled = |l: Wide, f: f64| -> Wide { l.map(|row| row.map(|entry| entry * Twofold::from(f))) };
        let one: Wide = [[Twofold::ONE, Twofold::default()], [Twofold::default(), Twofold::ONE]];
        let matrix: Wide = match block {
            Block::Elliptic { sigma, omega, ratio } => {
                let ratio = Twofold::from(*ratio);
                [[*sigma, *omega * ratio], [-(*omega / ratio), *sigma]]
            }
            Block::Hyperbolic { sigma, upper, lower, .. } => {
                [[*sigma, Twofold::from(*upper)], [Twofold::from(*lower), *sigma]]
            }
            Block::Diagonal { lambda } => [[lambda[0], Twofold::default()], [Twofold::default(), lambda[1]]],
        };
        let size = matrix.as_flattened().iter().map(|entry| entry.hi.abs()).sum::<f64>() * h;
        let halvings = (0..30).find(|k| size < f64::from(1u32 << k) / 4.0).unwrap();
        let z = scaled(matrix, h / f64::from(1u32 << halvings));
        // z^j/(j+m)! for m = 3, then upwards.
        let mut factorial = Twofold::from(6.0);
        let mut inverse = vec![Twofold::ONE / factorial];
        for m in 4..32 {
            factorial = factorial * Twofold::from(f64::from(m));
            inverse.push(Twofold::ONE / factorial);
        }
        let weighted = |f: Twofold| one.map(|row| row.map(|entry| entry * f));
        let mut third = weighted(inverse[inverse.len() - 1]);
        for f in inverse.iter().rev().skip(1) {
            third = add(product(third, z), weighted(*f));
        }
        let mut second = add(product(third, z), scaled(one, 0.5));
        let mut first = add(product(second, z), one);
        let mut increment = product(first, z);
        for _ in 0..halvings {
            third = scaled(add(add(product(first, second), second), scaled(third, 2.0)), 0.125);
            second = scaled(add(product(first, first), scaled(second, 2.0)), 0.25);
            first = add(first, scaled(product(first, increment), 0.5));
            increment = add(scaled(increment, 2.0), product(increment, increment));
        }
        let plain = |wide: Wide| wide.map(|row| row.map(|entry| entry.hi));
        Functions {
            increment: plain(increment),
            first_less_one: plain(add(first, scaled(one, -1.0))),
            second: plain(second),
            third: plain(third),
        }
    }

    /// Every kind of block, slow to fast and across all limits between the formulas.
    #[test]
    fn the_functions_have_all_their_digits() {
        let number = |hi: f64| Twofold { hi, lo: hi * 3.1e-17 };
        let vibration =
            |sigma: f64, omega: f64, ratio: f64| Block::Elliptic { sigma: number(sigma), omega: number(omega), ratio };
        let creep = |sigma: f64, upper: f64, lower: f64| Block::Hyperbolic {
            sigma: number(sigma),
            root: (upper * lower).sqrt(),
            upper,
            lower,
        };
        let blocks = [
            vibration(0.0, 1.0, 1.0),
            vibration(-1.0, 0.3, 1.0),
            vibration(-0.1, 1.0, 20.0),
            vibration(-1.0, 1e-7, 1e6),
            vibration(0.01, 1.0, 1.0),
            creep(-1.0, 1.0, 0.0),
            creep(-1.0, 5.0, 1e-12),
            creep(-1.0, 10.0, 1e-3),
            creep(-1.0, 10.0, 0.03),
            creep(-1.0, 100.0, 0.009),
            Block::Diagonal { lambda: [number(-1.0), number(-1e-6)] },
            Block::Diagonal { lambda: [number(-3.0), number(-0.7)] },
        ];
        let mut worst = [0.0f64; 4];
        for block in blocks {
            for h in [1e-12, 1e-6, 1e-3, 0.1, 0.4, 0.49, 0.52, 0.8, 0.99, 1.01, 1.6, 2.0, 3.1, 6.3, 20.0, 300.0] {
                let (found, exact) = (block.functions(h), reference(&block, h));
                let all = |f: &Functions| [f.increment, f.first_less_one, f.second, f.third];
                for (m, (found, exact)) in all(&found).into_iter().zip(all(&exact)).enumerate() {
                    for row in 0..2 {
                        for column in 0..2 {
                            // Entries of a block with a ratio are of different sizes by nature: relative to what the block
                            // itself has in that place, or to the diagonal.
                            let ratio = match block {
                                Block::Elliptic { ratio, .. } if row != column => {
                                    if row == 0 {
                                        ratio
                                    } else {
                                        1.0 / ratio
                                    }
                                }
                                Block::Hyperbolic { upper, lower, .. } if row != column => {
                                    h * if row == 0 { upper } else { lower }
                                }
                                _ => 1.0,
                            };
                            let scale = exact[row][column].abs().max(exact[row][row].abs() * ratio);
                            let error = (found[row][column] - exact[row][column]).abs();
                            if scale > 0.0 {
                                worst[m] = worst[m].max(error / scale);
                            }
                            assert!(
                                error <= 4e-15 * scale,
                                "{block:?} h {h} m {m} {row} {column}: {found:?} {exact:?}"
                            );
                        }
                    }
                }
            }
        }
        println!("{worst:?}");
    }
}
