//! Cases on as many threads as there are cores, the longest first.

use super::Traced;
use super::run::RunError;
use super::trace::Case;
use std::num::NonZero;
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Runs every case; the results are in the order of the cases, whichever ended first.
pub(super) fn run(cases: Vec<Case>, each: &(impl Fn() + Sync)) -> Result<Vec<Traced>, RunError> {
    let mut waiting: Vec<(usize, Case)> = cases.into_iter().enumerate().collect();
    let count = waiting.len();
    // taken from the end: the longest, so that none is left over when the others are done
    waiting.sort_by_key(|(index, case)| (case.pictures(), std::cmp::Reverse(*index)));
    let waiting = Mutex::new(waiting);
    let done = Mutex::new(Vec::with_capacity(count));
    let take = || waiting.lock().unwrap_or_else(PoisonError::into_inner).pop();
    let work = || {
        while let Some((index, case)) = take() {
            let result = case.trace(each).map(|traces| Traced { case, traces });
            if result.is_err() {
                waiting.lock().unwrap_or_else(PoisonError::into_inner).clear();
            }
            done.lock().unwrap_or_else(PoisonError::into_inner).push((index, result));
        }
    };
    let threads = thread::available_parallelism().map_or(1, NonZero::get).min(count);
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
    });
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}
