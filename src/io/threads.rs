//! Threads where the system has any left; else everything runs on the one there is.

use std::num::NonZeroUsize;
use std::thread;

/// Makes the pool for parallel work: as many threads as requested, else one per processor; the calling thread alone where no other can be
/// had. To be called once, at the start.
pub fn prepare(jobs: Option<NonZeroUsize>) {
    // 0 leaves the number to the machine and to `RAYON_NUM_THREADS`
    let pool = || rayon::ThreadPoolBuilder::new().num_threads(jobs.map_or(0, NonZeroUsize::get));
    // the one attempt at the pool of the process must not fail, as there is no other: whether its threads can be had is tried before
    let chosen =
        if can_be_had(pool()) { pool() } else { rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread() };
    // an error here means that there is a pool already
    let _ = chosen.build_global();
}

/// Whether the threads of a pool can be had. They have ended when this returns, so that the system has room for as many again.
fn can_be_had(pool: rayon::ThreadPoolBuilder) -> bool {
    let mut threads = Vec::new();
    let trial = pool
        .spawn_handler(|worker| {
            threads.push(thread::Builder::new().spawn(|| worker.run())?);
            Ok(())
        })
        .build();
    let there_are = trial.is_ok();
    // a pool that is dropped tells its threads to end; one that could not be built whole has done so already
    drop(trial);
    threads.into_iter().for_each(|t| drop(t.join()));
    there_are
}
