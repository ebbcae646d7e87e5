//! Memory for a program whose large blocks come and go: tables of results, pictures, archives.
//!
//! The first touch of a small page (4 KiB) is a visit to the system, on a virtual machine of some 2.5 µs. The C library gives large blocks
//! back when they are free, and fetches others, so short programs spend a tenth of their time there. [`LargeBlocks`] keeps one region of
//! large pages (2 MiB) for them, of which a page is touched once. What it has no room for, and everything small, comes from the system's
//! allocator, and so does all memory of loaded libraries.
//!
//! For Linux: other systems have no such pages without special rights. The crate is empty there.

#[cfg(target_os = "linux")]
mod region;
#[cfg(target_os = "linux")]
mod units;

#[cfg(target_os = "linux")]
pub use linux::LargeBlocks;

#[cfg(target_os = "linux")]
mod linux {
    use std::alloc::{GlobalAlloc, Layout, System};

    use crate::region::Region;
    use crate::units::UNIT;

    /// Blocks of this size in bytes are large.
    const LARGE: usize = 32 << 10;

    /// The allocator: `#[global_allocator] static HEAP: LargeBlocks = LargeBlocks::new();`.
    #[derive(Debug)]
    pub struct LargeBlocks(Region);

    impl LargeBlocks {
        /// Takes no memory yet.
        #[must_use]
        pub const fn new() -> Self {
            Self(Region::new())
        }
    }

    impl Default for LargeBlocks {
        fn default() -> Self {
            Self::new()
        }
    }

    // SAFETY: a block belongs to the region or to the system's allocator, which its address tells; both keep what the trait promises, and
    // nothing panics: numbers are within the region.
    unsafe impl GlobalAlloc for LargeBlocks {
        #[inline]
        unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
            if layout.size() >= LARGE
                && layout.align() <= UNIT
                && let Some(block) = self.0.take(layout.size())
            {
                return block;
            }
            // SAFETY: as the caller promises.
            unsafe { System.alloc(layout) }
        }

        #[inline]
        unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
            if layout.size() >= LARGE
                && layout.align() <= UNIT
                && let Some(block) = self.0.take(layout.size())
            {
                // It may have been used before.
                // SAFETY: a block of this size.
                unsafe { block.write_bytes(0, layout.size()) };
                return block;
            }
            // SAFETY: as the caller promises.
            unsafe { System.alloc_zeroed(layout) }
        }

        #[inline]
        unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
            if self.0.has(block) {
                self.0.give_back(block, layout.size());
            } else {
                // SAFETY: it comes from there.
                unsafe { System.dealloc(block, layout) };
            }
        }

        unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
            let is_inside = self.0.has(block);
            if !is_inside && size < LARGE {
                // SAFETY: it comes from there.
                return unsafe { System.realloc(block, layout, size) };
            }
            if is_inside && size >= LARGE && self.0.resize(block, layout.size(), size) {
                return block;
            }
            // SAFETY: the caller promises a size that is one with this alignment; both blocks have the bytes that are copied.
            unsafe {
                let moved = self.alloc(Layout::from_size_align_unchecked(size, layout.align()));
                if !moved.is_null() {
                    moved.copy_from_nonoverlapping(block, layout.size().min(size));
                    self.dealloc(block, layout);
                }
                moved
            }
        }
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        /// The bytes that a block of this number and size is filled with.
        fn fill(number: usize, size: usize) -> Vec<u8> {
            (0..size).map(|place| (place / 7 + number).to_le_bytes()[0]).collect()
        }

        #[test]
        fn blocks_of_all_sizes_keep_their_bytes_until_they_are_given_back() {
            let heap = LargeBlocks::new();
            let layout = |size| Layout::from_size_align(size, 8).unwrap();
            let mut blocks: Vec<(*mut u8, usize, usize)> = Vec::new();
            let mut state = 1_usize;
            for number in 0..400 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let chance = state >> 33;
                let size = 1 + chance % [64, LARGE + 1, 2 * LARGE, 3 << 20][chance / 8 % 4];
                // SAFETY: sizes above zero; each block is used within its size and given back once, with its size.
                unsafe {
                    if blocks.len() > 12 {
                        let (block, size, number) = blocks.swap_remove(chance % 12);
                        assert_eq!(std::slice::from_raw_parts(block, size), fill(number, size));
                        heap.dealloc(block, layout(size));
                    }
                    if chance.is_multiple_of(3) && !blocks.is_empty() {
                        let place = chance % blocks.len();
                        let (block, before, number) = blocks[place];
                        let block = heap.realloc(block, layout(before), size);
                        let common = before.min(size);
                        assert_eq!(std::slice::from_raw_parts(block, common), &fill(number, before)[..common]);
                        block.copy_from(fill(number, size).as_ptr(), size);
                        blocks[place] = (block, size, number);
                    } else {
                        let block = heap.alloc_zeroed(layout(size));
                        assert_eq!(std::slice::from_raw_parts(block, size), vec![0; size]);
                        block.copy_from(fill(number, size).as_ptr(), size);
                        blocks.push((block, size, number));
                    }
                }
            }
            for (block, size, number) in blocks {
                // SAFETY: as above.
                unsafe {
                    assert_eq!(std::slice::from_raw_parts(block, size), fill(number, size));
                    heap.dealloc(block, layout(size));
                }
            }
        }

        #[test]
        fn what_has_no_room_or_is_aligned_oddly_comes_from_elsewhere() {
            let heap = LargeBlocks::new();
            for (size, align, is_inside) in [
                (LARGE, 8, true),
                (LARGE - 1, 8, false),
                (LARGE, UNIT, true),
                (LARGE, 2 * UNIT, false),
                (crate::units::ALL * UNIT + 1, 8, false),
            ] {
                let layout = Layout::from_size_align(size, align).unwrap();
                // SAFETY: a size above zero; it is given back with its layout.
                unsafe {
                    let block = heap.alloc(layout);
                    assert_eq!((heap.0.has(block), block.addr() % align), (is_inside, 0), "{size} {align}");
                    heap.dealloc(block, layout);
                }
            }
        }
    }
}
