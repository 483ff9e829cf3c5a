//! Outputs come into place undisturbed: whoever ends the process on a signal waits until none of them is partly in place.

use super::temporary;
use std::sync::{PoisonError, RwLock, RwLockReadGuard};

static PLACING: RwLock<()> = RwLock::new(());

/// Outputs come into place: [`end`] waits until the guard is dropped.
pub fn placing() -> RwLockReadGuard<'static, ()> {
    PLACING.read().unwrap_or_else(PoisonError::into_inner)
}

/// Ends the process by `exit` once no output is partly in place, and leaves no temporary file.
pub fn end(exit: impl FnOnce()) {
    let _none_placing = PLACING.write().unwrap_or_else(PoisonError::into_inner);
    temporary::discard();
    exit();
}
