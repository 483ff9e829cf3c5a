//! Threads where the system has any left; else everything runs on the one there is.

/// Makes the pool for parallel work, of the calling thread alone where no other can be had. To be called once, at the start.
pub fn prepare() {
    let pool = rayon::ThreadPoolBuilder::new;
    if pool().build_global().is_err() {
        // an error here means that there is a pool already
        let _ = pool().num_threads(1).use_current_thread().build_global();
    }
}
