//! Threads where the system has any left; else everything runs on the one there is.

use std::sync::mpsc::channel;
use std::thread::Builder;

/// Makes the pool for parallel work, of the calling thread alone where no other can be had. To be called once, at the start.
pub fn prepare() {
    let pool = rayon::ThreadPoolBuilder::new;
    if pool().build_global().is_err() {
        // an error here means that there is a pool already
        let _ = pool().num_threads(1).use_current_thread().build_global();
    }
}

/// Whether `count` threads can be had at once.
pub fn are_there(count: usize) -> bool {
    let mut held = Vec::with_capacity(count);
    let mut threads = Vec::with_capacity(count);
    for _ in 0..count {
        let (hold, wait) = channel::<()>();
        let Ok(thread) = Builder::new().spawn(move || wait.recv()) else { break };
        held.push(hold);
        threads.push(thread);
    }
    let all = threads.len() == count;
    drop(held);
    for thread in threads {
        let _ = thread.join();
    }
    all
}
