//! How the memory of the working process comes from the system: in large pages, and once. Each first touch of a small page is a visit to the
//! kernel of 2 µs on a virtual machine, and short runs spent a tenth of their time there: for buffers of FMUs' libraries and descriptions,
//! which were given back and fetched again.

/// Memory of the heap that comes in large pages. What of it nobody touches is not taken from the system.
const HEAP: libc::c_int = 64 << 20;
/// The size of a large page.
const PAGE: usize = 2 << 20;

/// Prepares the heap. Where the system has no large pages to give, or no room, it remains as it was.
pub fn prepare() {
    /// The largest that malloc accepts.
    const FROM_HEAP: libc::c_int = 32 << 20;
    /// What malloc takes beyond its need by default.
    const USUAL_PAD: libc::c_int = 128 << 10;
    // SAFETY: sets numbers that malloc looks at, takes memory that nobody uses and gives it back, asks for the end of the heap, and gives
    // advice on memory, which does not change what is in it. There is one thread.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, FROM_HEAP);
        libc::mallopt(libc::M_TRIM_THRESHOLD, 2 * HEAP);
        libc::mallopt(libc::M_TOP_PAD, HEAP);
        let before = libc::sbrk(0);
        // More than is left of the heap, so that it grows, if it may.
        libc::free(libc::malloc(PAGE));
        libc::mallopt(libc::M_TOP_PAD, USUAL_PAD);
        let (begin, end) = (before.addr().next_multiple_of(PAGE), libc::sbrk(0).addr() / PAGE * PAGE);
        if begin < end {
            libc::madvise(before.with_addr(begin), end - begin, libc::MADV_HUGEPAGE);
        }
    }
}

/// Lets all threads share one heap from now on, which is best where they are few and hardly wait for each other.
pub fn share() {
    // SAFETY: sets a number that malloc looks at when a thread first needs memory.
    unsafe { libc::mallopt(libc::M_ARENA_MAX, 1) };
}
