//! Random numbers, and those that calls get as arguments.

/// A generator of random numbers: `SplitMix64`.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: usize) -> usize {
        usize::try_from(self.next() % n as u64).unwrap()
    }

    /// True once in n times.
    pub fn rarely(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    pub fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }

    pub fn number(&mut self) -> f64 {
        let unit = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        match self.below(40) {
            0 => f64::NAN,
            1 => self.pick(&[f64::INFINITY, f64::NEG_INFINITY]),
            2 => self.pick(&[f64::MAX, f64::MIN, 1e300, -1e200]),
            3 => self.pick(&[5e-324, -5e-324, f64::MIN_POSITIVE, -0.0]),
            4 => f64::from_bits(self.next()),
            5..8 => self.pick(&[0.0, 1.0, -1.0]),
            _ => 2.0 * unit - 1.0,
        }
    }

    pub fn size(&mut self) -> f64 {
        match self.below(20) {
            0 => self.pick(&[0.0, -0.1, f64::NAN, f64::INFINITY, -0.0]),
            1 => self.pick(&[5e-324, 1e-300, 1e-18]),
            2 => self.pick(&[1e3, 1e9, 1e300, f64::MAX]),
            3 => self.number(),
            _ => self.pick(&[1e-4, 1e-4, 1e-3, 0.01, 0.1]),
        }
    }
}
