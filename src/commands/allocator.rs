//! Settings of the C library's allocator for consecutive runs, each of which allocates its own signals.
//!
//! By default glibc returns the end of its heap to the kernel when 128 kB are free there. The next run then takes a page fault for every
//! 4 kB it writes. Depending on the rest of the heap this costs up to a fifth of a run of `spindle_only` over 0.12 s: compare
//! `cargo bench --bench spindle_only` with `-- trimmed`, which keeps the defaults.

/// Free memory at the end of the heap that is kept [B]: the signals of a run of 0.1 s and the buffers of their transforms.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const TRIM_THRESHOLD: i32 = 4 << 20;
/// Size from which an allocation is a mapping of its own, which is returned to the kernel [B].
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const MMAP_THRESHOLD: i32 = 1 << 20;

/// Keeps freed memory for the next run. It must be called first; on systems without glibc it does nothing.
pub fn keep_memory_for_next_run() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: mallopt sets two numbers of the allocator under the allocator's own lock.
    #[allow(unsafe_code)]
    unsafe {
        libc::mallopt(libc::M_TRIM_THRESHOLD, TRIM_THRESHOLD);
        libc::mallopt(libc::M_MMAP_THRESHOLD, MMAP_THRESHOLD);
    }
}
