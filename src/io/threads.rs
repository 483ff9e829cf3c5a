//! Threads where the system has any left; else everything runs on the one there is.

use std::num::NonZeroUsize;

/// Makes the pool for parallel work: as many threads as requested, else one per processor; the calling thread alone where no other can be
/// had. To be called once, at the start.
pub fn prepare(jobs: Option<NonZeroUsize>) {
    // 0 leaves the number to the machine and to `RAYON_NUM_THREADS`
    let pool = || rayon::ThreadPoolBuilder::new().num_threads(jobs.map_or(0, NonZeroUsize::get));
    // the one attempt at the pool of the process must not fail, as there is no other: whether its threads can be had is tried before
    let there_are = pool().build().is_ok();
    let alone = || rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    // an error here means that there is a pool already
    let chosen = if there_are { pool() } else { alone() };
    let _ = chosen.build_global();
}
