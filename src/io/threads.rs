//! Threads where the system has any left; else everything runs on the one there is.

use std::num::NonZeroUsize;

/// Makes the pool for parallel work: as many threads as requested, else one per processor; the calling thread alone where no other can be
/// had. To be called once, at the start.
pub fn prepare(jobs: Option<NonZeroUsize>) {
    let pool = rayon::ThreadPoolBuilder::new;
    // 0 leaves the number to the machine and to `RAYON_NUM_THREADS`
    if pool().num_threads(jobs.map_or(0, NonZeroUsize::get)).build_global().is_err() {
        // an error here means that there is a pool already
        let _ = pool().num_threads(1).use_current_thread().build_global();
    }
}
