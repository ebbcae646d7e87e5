//! Some kernels (seen on Linux 6.18 in a virtual machine) begin a process on the processor of its maker, where it waits until the maker
//! sleeps, and look for an idle processor only milliseconds later.

/// Leaves the processor to whoever waits for it, and goes on with another one, if there are several.
#[cfg(target_os = "linux")]
pub fn step() {
    // SAFETY: a set of no processors is all zeros.
    let mut allowed: libc::cpu_set_t = unsafe { std::mem::zeroed() };
    // SAFETY: writes to a set of the stated size; 0 is this thread.
    if unsafe { libc::sched_getaffinity(0, size_of_val(&allowed), &raw mut allowed) } != 0 {
        return;
    }
    // SAFETY: asks for a number.
    let Ok(present) = usize::try_from(unsafe { libc::sched_getcpu() }) else { return };
    let mut others = allowed;
    // SAFETY: the function checks the range of the number.
    unsafe { libc::CPU_CLR(present, &mut others) };
    for set in [others, allowed] {
        // SAFETY: reads a set of the stated size. One without processors is refused, and nothing changes.
        unsafe { libc::sched_setaffinity(0, size_of_val(&set), &raw const set) };
    }
}

/// Other systems do that themselves.
#[cfg(not(target_os = "linux"))]
pub fn step() {}
