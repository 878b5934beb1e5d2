//! A lock over plain data: whoever panicked with it left the data whole.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Waits for it.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
