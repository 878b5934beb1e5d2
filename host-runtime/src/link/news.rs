//! How a station's loop sleeps until something comes.

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Counts what came.
#[derive(Debug, Default)]
pub(super) struct News {
    count: Mutex<u64>,
    rung: Condvar,
}

/// What whoever brings something rings, so that a station's loop wakes. Clones are the same bell.
#[derive(Clone, Debug, Default)]
pub struct Doorbell(pub(super) Arc<News>);

impl Doorbell {
    /// Wakes whoever watches.
    pub fn ring(&self) {
        self.0.ring();
    }

    /// Something to sleep on until it rings.
    #[must_use]
    pub fn watch(&self) -> Watch {
        Watch::new(Arc::clone(&self.0))
    }
}

impl News {
    pub(super) fn ring(&self) {
        let mut count = self.count.lock().unwrap_or_else(PoisonError::into_inner);
        *count = count.wrapping_add(1);
        self.rung.notify_all();
    }
}

/// Sees what came since it was last looked at.
#[derive(Debug)]
pub struct Watch {
    news: Arc<News>,
    seen: u64,
}

impl Watch {
    pub(super) fn new(news: Arc<News>) -> Self {
        Self { news, seen: 0 }
    }

    /// Waits until something came that was not seen yet, or for so long; whether something came.
    pub fn wait(&mut self, at_most: Duration) -> bool {
        let count = self.news.count.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.news.rung.wait_timeout_while(count, at_most, |count| *count == self.seen);
        let (count, timeout) = waited.unwrap_or_else(PoisonError::into_inner);
        self.seen = *count;
        !timeout.timed_out()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_came_before_the_wait_is_seen_once() {
        let news = Arc::new(News::default());
        let mut watch = Watch::new(Arc::clone(&news));
        news.ring();
        news.ring();
        assert!(watch.wait(Duration::from_secs(60)));
        assert!(!watch.wait(Duration::ZERO));
        let ringer = std::thread::spawn({
            let news = Arc::clone(&news);
            move || news.ring()
        });
        assert!(watch.wait(Duration::from_secs(60)), "woken by another thread");
        ringer.join().unwrap();
    }
}
