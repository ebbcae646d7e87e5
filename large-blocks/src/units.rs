//! Which parts of a region are taken.

/// Bytes of a unit, in which memory is handed out: a small page.
pub const UNIT: usize = 4096;
/// How many units there are.
pub const ALL: usize = (64 << 20) / UNIT;

/// Units in one number.
const BITS: usize = u64::BITS as usize;

/// A bit for each unit, which is one where the unit is taken.
#[derive(Debug)]
pub struct Units([u64; ALL / BITS]);

impl Units {
    /// All are free.
    pub const fn new() -> Self {
        Self([0; ALL / BITS])
    }

    /// Takes the first place where so many units are free: pages that have been touched are filled before others.
    pub fn take(&mut self, count: usize) -> Option<usize> {
        let (mut at, mut free) = (0, 0);
        while at < ALL {
            let left = BITS - at % BITS;
            let taken = self.0[at / BITS] >> (at % BITS);
            // Zeros come in from above; what is beyond this number is in the next one.
            let more = (taken.trailing_zeros() as usize).min(left);
            (at, free) = (at + more, free + more);
            if free >= count {
                self.set(at - free, count, true);
                return Some(at - free);
            }
            if more < left {
                at += (taken >> more).trailing_ones() as usize;
                free = 0;
            }
        }
        None
    }

    /// Marks units as taken or free.
    pub fn set(&mut self, begin: usize, count: usize, taken: bool) {
        for (number, bits) in parts(begin, count) {
            if taken { self.0[number] |= bits } else { self.0[number] &= !bits }
        }
    }

    /// Whether there are such units, and all of them are free.
    pub fn are_free(&self, begin: usize, count: usize) -> bool {
        count <= ALL - begin && parts(begin, count).all(|(number, bits)| self.0[number] & bits == 0)
    }
}

/// The numbers in which these units are, and their bits there.
fn parts(begin: usize, count: usize) -> impl Iterator<Item = (usize, u64)> {
    let (mut at, end) = (begin, begin + count);
    std::iter::from_fn(move || {
        (at < end).then(|| {
            let some = (BITS - at % BITS).min(end - at);
            let part = (at / BITS, (u64::MAX >> (BITS - some)) << (at % BITS));
            at += some;
            part
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_place_with_room_is_taken() {
        let mut units = Units::new();
        // The same, bit by bit.
        let mut plain = vec![false; ALL];
        let mut blocks = Vec::new();
        let mut state = 1_usize;
        for _ in 0..2000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let chance = state >> 33;
            if chance % 5 < 2 && !blocks.is_empty() {
                let (begin, count) = blocks.swap_remove(chance % blocks.len());
                assert!(!units.are_free(begin, count));
                units.set(begin, count, false);
                plain[begin..begin + count].fill(false);
                assert!(units.are_free(begin, count));
            }
            let count = 1 + chance / 5 % [3, 70, 300, 2000][chance % 4];
            let wanted = (0..=ALL - count).find(|begin| !plain[*begin..begin + count].contains(&true));
            assert_eq!(units.take(count), wanted);
            if let Some(begin) = wanted {
                plain[begin..begin + count].fill(true);
                blocks.push((begin, count));
            }
        }
        assert!(plain.iter().filter(|taken| **taken).count() > ALL / 2, "there is hardly room at the end");
    }

    #[test]
    fn all_can_be_taken_and_no_more() {
        let mut units = Units::new();
        assert_eq!(units.take(ALL + 1), None);
        assert_eq!((units.take(ALL), units.take(1)), (Some(0), None));
        units.set(ALL - 1, 1, false);
        assert!(units.are_free(ALL - 1, 1) && !units.are_free(ALL - 1, 2) && units.are_free(ALL, 0));
        assert_eq!(units.take(1), Some(ALL - 1));
    }
}
