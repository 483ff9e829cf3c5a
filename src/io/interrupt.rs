//! Outputs come into place undisturbed: whoever ends the process on a signal waits until none of them is partly in place.

use super::{lock, temporary};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{PoisonError, RwLock, RwLockReadGuard};

static PLACING: RwLock<()> = RwLock::new(());
static ENDING: AtomicBool = AtomicBool::new(false);

/// Outputs come into place: [`end`] waits until the guard is dropped.
pub fn placing() -> RwLockReadGuard<'static, ()> {
    PLACING.read().unwrap_or_else(PoisonError::into_inner)
}

/// Ends the process by `exit` once no output is partly in place, and leaves neither a temporary file nor a lock.
pub fn end(exit: impl FnOnce()) {
    ENDING.store(true, Ordering::SeqCst);
    let _none_placing = PLACING.write().unwrap_or_else(PoisonError::into_inner);
    temporary::discard();
    lock::discard();
    exit();
}

/// Whether the process is being ended: who waits for a reader gives up.
pub fn is_ending() -> bool {
    ENDING.load(Ordering::SeqCst)
}

/// Leaves the end to [`end`], which knows the exit code.
pub fn wait_for_end() -> ! {
    loop {
        std::thread::park();
    }
}
