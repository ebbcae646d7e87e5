//! Exact eigenvalues of linear loops in a rectangle, with a count that shows that none is missing.
//!
//! The number of zeros inside is the winding number of the [characteristic function](Characteristic) along the border,
//! followed with steps on which it is nearly linear. Rectangles are halved until each contains one zero, which Newton's
//! method finds. The count uses floating point: it is not an interval proof, but an integer that rounding does not change.

mod characteristic;
mod complex;

pub use characteristic::Characteristic;
pub use complex::Complex;
use std::f64::consts::TAU;
use std::fmt;

/// A rectangle of the s-plane \[1/s\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Smallest real part.
    pub left: f64,
    /// Largest real part.
    pub right: f64,
    /// Smallest imaginary part.
    pub bottom: f64,
    /// Largest imaginary part.
    pub top: f64,
}

/// A zero is on a border, or too near to follow the function past it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorderError {
    /// Near here.
    pub near: Complex,
}

impl fmt::Display for BorderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "an eigenvalue is on the border of the region near {:.6} {:+.6}j; move the border",
            self.near.re, self.near.im
        )
    }
}

impl std::error::Error for BorderError {}

/// A zero and how often it counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eigenvalue {
    /// Where \[1/s\].
    pub s: Complex,
    /// Multiplicity; above 1 also for zeros closer than 1e-4 of the region, which rounding makes indistinguishable.
    pub multiplicity: u32,
}

impl Region {
    fn corners(&self) -> [Complex; 4] {
        [
            Complex::new(self.left, self.bottom),
            Complex::new(self.right, self.bottom),
            Complex::new(self.right, self.top),
            Complex::new(self.left, self.top),
        ]
    }

    fn halves(&self, fraction: f64) -> [Self; 2] {
        if self.right - self.left > self.top - self.bottom {
            let cut = self.left + fraction * (self.right - self.left);
            [Self { right: cut, ..*self }, Self { left: cut, ..*self }]
        } else {
            let cut = self.bottom + fraction * (self.top - self.bottom);
            [Self { top: cut, ..*self }, Self { bottom: cut, ..*self }]
        }
    }

    fn contains(&self, s: Complex) -> bool {
        self.left < s.re && s.re < self.right && self.bottom < s.im && s.im < self.top
    }

    fn diameter(&self) -> f64 {
        (self.right - self.left).hypot(self.top - self.bottom)
    }

    fn centre(&self) -> Complex {
        Complex::new(0.5 * (self.left + self.right), 0.5 * (self.bottom + self.top))
    }
}

/// How often the function turns around zero along the region's border: the number of zeros inside.
///
/// # Errors
/// The function can't be followed: a zero is on the border or very near.
pub fn count(function: &Characteristic, region: &Region) -> Result<u32, BorderError> {
    const PIECES: u32 = 16;
    let corners = region.corners();
    let mut turned = 0.0;
    for side in 0..4 {
        let (from, to) = (corners[side], corners[(side + 1) % 4]);
        let at = |i: u32| from + (to - from) * (f64::from(i) / f64::from(PIECES));
        for piece in 0..PIECES {
            let (a, b) = (at(piece), at(piece + 1));
            turned += turn(function, a, b, function.value(a), function.value(b), 40)?;
        }
    }
    let number = turned / TAU;
    debug_assert!((number - number.round()).abs() < 1e-6, "{number}");
    // A count: never negative, and far below the largest u32.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    Ok(number.round().max(0.0) as u32)
}

/// The angle by which the function turns from a to b.
fn turn(
    function: &Characteristic,
    a: Complex,
    b: Complex,
    at_a: Complex,
    at_b: Complex,
    depth: u32,
) -> Result<f64, BorderError> {
    let middle = (a + b) * 0.5;
    if depth == 0 || at_a.abs() == 0.0 || at_b.abs() == 0.0 {
        return Err(BorderError { near: middle });
    }
    let at_middle = function.value(middle);
    // The function has to be nearly linear on the piece. A small change of its argument at the ends is not enough: near a
    // double zero the function turns by a whole circle, which the ends do not show.
    let size = at_middle.abs();
    if (at_b - at_a).abs() < 0.5 * size && (at_middle - (at_a + at_b) * 0.5).abs() < 0.1 * size {
        return Ok(angle(at_a, at_middle) + angle(at_middle, at_b));
    }
    Ok(turn(function, a, middle, at_a, at_middle, depth - 1)? + turn(function, middle, b, at_middle, at_b, depth - 1)?)
}

/// The angle from one value to the next, in (−π, π].
fn angle(from: Complex, to: Complex) -> f64 {
    (to * Complex::new(from.re, -from.im)).arg()
}

/// All eigenvalues in the region, by falling real part. Their number is that of [`count`].
///
/// # Errors
/// A zero is on the region's border or very near.
pub fn eigenvalues(function: &Characteristic, region: &Region) -> Result<Vec<Eigenvalue>, BorderError> {
    let mut found = Vec::new();
    search(function, region, count(function, region)?, 1e-7 * region.diameter(), &mut found)?;
    found.sort_by(|a, b| b.s.re.total_cmp(&a.s.re).then(a.s.im.total_cmp(&b.s.im)));
    Ok(found)
}

fn search(
    function: &Characteristic,
    region: &Region,
    number: u32,
    smallest: f64,
    found: &mut Vec<Eigenvalue>,
) -> Result<(), BorderError> {
    if number == 0 {
        return Ok(());
    }
    if number == 1
        && let Some(s) = newton(function, region, number)
    {
        found.push(Eigenvalue { s, multiplicity: 1 });
        return Ok(());
    }
    if region.diameter() < smallest {
        found.push(multiple(function, region, number));
        return Ok(());
    }
    // A cut through a zero is moved; the golden section meets no zero by symmetry.
    let mut failure = None;
    for fraction in [0.481_966, 0.527_311, 0.436_068, 0.583_592] {
        let [first, second] = region.halves(fraction);
        match (count(function, &first), count(function, &second)) {
            (Ok(a), Ok(b)) if a + b == number => {
                search(function, &first, a, smallest, found)?;
                return search(function, &second, b, smallest, found);
            }
            (Err(error), _) | (_, Err(error)) => failure = Some(error),
            _ => {}
        }
    }
    // Near a multiple zero rounding dominates the function, so that no border through its neighbourhood can be followed.
    if number > 1 && region.diameter() < 1e3 * smallest {
        found.push(multiple(function, region, number));
        return Ok(());
    }
    Err(failure.unwrap_or(BorderError { near: region.centre() }))
}

/// Zeros that are too close to be separated.
fn multiple(function: &Characteristic, region: &Region, number: u32) -> Eigenvalue {
    Eigenvalue { s: newton(function, region, number).unwrap_or_else(|| region.centre()), multiplicity: number }
}

/// The zero of this multiplicity inside, if Newton's method gets to it from the centre without leaving.
fn newton(function: &Characteristic, region: &Region, multiplicity: u32) -> Option<Complex> {
    let mut s = region.centre();
    for _ in 0..60 {
        let step = 1e-6 * (1.0 + s.abs());
        let rise = function.value(Complex::new(s.re + step, s.im)) - function.value(Complex::new(s.re - step, s.im));
        let change = function.value(s).div(rise * (0.5 / step)) * f64::from(multiplicity);
        s = s - change;
        if !region.contains(s) {
            return None;
        }
        if change.abs() < 1e-13 * (1.0 + s.abs()) {
            break;
        }
    }
    Some(s)
}

#[cfg(test)]
mod tests;
