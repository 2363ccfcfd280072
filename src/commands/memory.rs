//! Runs follow each other, each with signals of its own. The C library gives the end of its heap back to the kernel as soon as 128 kB
//! are free there; the next run then meets a page fault for every 4 kB it writes. By what else lies on the heap that is nothing to
//! a fifth of a run of `spindle_only` over 0.12 s (`cargo bench --bench spindle_only`, and the same with `-- trimmed`, which leaves the C
//! library alone).

/// Free memory at the end of a heap that is kept [B]: signals of a run of a tenth of a second and what they are transformed in.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const KEPT: i32 = 4 << 20;
/// From this size on a piece comes from the kernel and goes back there [B].
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const LARGE: i32 = 1 << 20;

/// Has memory of one run serve the next. To be called before anything else; elsewhere than on Linux with glibc it does nothing.
pub fn keep_for_the_next_run() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // Sound: it sets two numbers of the allocator, under the allocator's own lock.
    #[allow(unsafe_code)]
    unsafe {
        libc::mallopt(libc::M_TRIM_THRESHOLD, KEPT);
        libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
    }
}
