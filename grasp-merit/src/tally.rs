//! Figures of one output.

/// Names of the figures.
pub const OF_OUTPUT: [&str; 5] = ["last", "min", "max", "mean", "rms"];

/// The statistics of one output so far.
#[derive(Debug, Clone, Copy)]
pub struct Tally {
    time: f64,
    last: f64,
    min: f64,
    max: f64,
    integral: f64,
    square: f64,
    begin: f64,
}

impl Tally {
    /// One that begins with this value.
    #[must_use]
    pub fn new(time: f64, value: f64) -> Self {
        Self { time, last: value, min: value, max: value, integral: 0.0, square: 0.0, begin: time }
    }

    /// A later value; between two of them lies a straight line.
    pub fn add(&mut self, time: f64, value: f64) {
        let (dt, last) = (time - self.time, self.last);
        self.integral += dt * 0.5 * (last + value);
        // ∫ of the square of a straight line from a to b: (a² + ab + b²)/3.
        self.square += dt * (last * last + last * value + value * value) / 3.0;
        // Not f64::min: a value that is no number must show.
        self.min = if value < self.min || value.is_nan() { value } else { self.min };
        self.max = if value > self.max || value.is_nan() { value } else { self.max };
        (self.time, self.last) = (time, value);
    }

    /// The figures, in the order of their names.
    #[must_use]
    pub fn figures(&self) -> [f64; OF_OUTPUT.len()] {
        let duration = self.time - self.begin;
        let (mean, rms) = if duration > 0.0 {
            (self.integral / duration, (self.square / duration).sqrt())
        } else {
            (self.last, self.last.abs())
        };
        [self.last, self.min, self.max, mean, rms]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_has_its_integrals() {
        let mut tally = Tally::new(0.0, 0.0);
        for step in 1..=100 {
            tally.add(f64::from(step) * 0.01, f64::from(step) * 0.02);
        }
        // A straight line from 0 to 2: mean 1, mean square 4/3.
        let [last, min, max, mean, rms] = tally.figures();
        assert_eq!((last, min, max), (2.0, 0.0, 2.0));
        assert!((mean - 1.0).abs() < 1e-12 && (rms - (4.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    }
}
