//! A region of large pages, of which the system gives each when it is first touched.

use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

use crate::units::{ALL, UNIT, Units};

/// Bytes of a large page.
const PAGE: usize = 2 << 20;
/// Bytes of the region.
const SIZE: usize = ALL * UNIT;

/// The region. It is asked for when there is a first block, and never given back.
#[derive(Debug)]
pub struct Region {
    asked: Once,
    /// Its first byte; null before it is asked for, and where the system has none to give.
    begin: AtomicPtr<u8>,
    units: Mutex<Units>,
}

impl Region {
    pub const fn new() -> Self {
        Self { asked: Once::new(), begin: AtomicPtr::new(ptr::null_mut()), units: Mutex::new(Units::new()) }
    }

    /// A block of this size, if there is room: it begins at a unit, and what is in it is not known.
    pub fn take(&self, size: usize) -> Option<*mut u8> {
        self.asked.call_once(|| self.begin.store(pages(), Ordering::Release));
        let begin = self.begin.load(Ordering::Acquire);
        if begin.is_null() {
            return None;
        }
        let unit = self.units().take(size.div_ceil(UNIT))?;
        Some(begin.wrapping_add(unit * UNIT))
    }

    /// Whether a block is in the region.
    #[inline]
    pub fn has(&self, block: *mut u8) -> bool {
        // A block that somebody has is younger than the region from which it comes. Nothing is at null, or within the region's size of it.
        let begin = self.begin.load(Ordering::Acquire);
        !begin.is_null() && block.addr().wrapping_sub(begin.addr()) < SIZE
    }

    /// Frees a block of this size, which is in the region.
    pub fn give_back(&self, block: *mut u8, size: usize) {
        let unit = self.unit(block);
        self.units().set(unit, size.div_ceil(UNIT), false);
    }

    /// Makes a block of the region longer or shorter where it is, if there is room after it.
    pub fn resize(&self, block: *mut u8, from: usize, to: usize) -> bool {
        let (begin, before, after) = (self.unit(block), from.div_ceil(UNIT), to.div_ceil(UNIT));
        let mut units = self.units();
        if after <= before {
            units.set(begin + after, before - after, false);
            return true;
        }
        let has_room = units.are_free(begin + before, after - before);
        if has_room {
            units.set(begin + before, after - before, true);
        }
        has_room
    }

    fn unit(&self, block: *mut u8) -> usize {
        block.addr().wrapping_sub(self.begin.load(Ordering::Acquire).addr()) / UNIT
    }

    fn units(&self) -> MutexGuard<'_, Units> {
        self.units.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Memory for the region that begins at a large page, or null. Where the system has no large pages to give, it has small ones.
fn pages() -> *mut u8 {
    // SAFETY: asks for memory that nobody uses, and gives advice on it, which does not change what is in it.
    unsafe {
        let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_NORESERVE;
        let memory = libc::mmap(ptr::null_mut(), SIZE + PAGE, libc::PROT_READ | libc::PROT_WRITE, flags, -1, 0);
        if memory == libc::MAP_FAILED {
            return ptr::null_mut();
        }
        let begin = memory.wrapping_byte_add(memory.addr().next_multiple_of(PAGE) - memory.addr());
        libc::madvise(begin, SIZE, libc::MADV_HUGEPAGE);
        begin.cast()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_from_elsewhere_are_outside_before_and_after_there_is_a_region() {
        let region = Region::new();
        // Heaps of programs may begin at low addresses.
        let elsewhere = [0, UNIT, SIZE / 2, SIZE, usize::MAX].map(ptr::without_provenance_mut);
        assert!(!elsewhere.iter().any(|block| region.has(*block)));
        let block = region.take(UNIT).unwrap();
        assert!(region.has(block) && region.has(block.wrapping_add(SIZE - 1)) && !region.has(block.wrapping_add(SIZE)));
        assert!(!region.has(block.wrapping_sub(1)) && !elsewhere.iter().any(|block| region.has(*block)));
    }

    #[test]
    fn threads_get_blocks_that_do_not_overlap() {
        let region = Region::new();
        std::thread::scope(|scope| {
            for number in 0..4_u8 {
                let region = &region;
                scope.spawn(move || {
                    for size in (1..200).map(|part| part * 1000) {
                        let block = region.take(size).unwrap();
                        // SAFETY: a block of this size, which nobody else has.
                        unsafe {
                            block.write_bytes(number, size);
                            std::thread::yield_now();
                            let bytes = std::slice::from_raw_parts(block, size);
                            assert!(bytes.iter().all(|byte| *byte == number));
                        }
                        region.give_back(block, size);
                    }
                });
            }
        });
        assert!(region.take(SIZE).is_some(), "all of it is free again");
    }
}
