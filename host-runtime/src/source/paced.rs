//! A recording played once, each picture when it is due.

use super::{Frame, Source, SourceError, SourceInfo};
use std::thread;
use std::time::{Duration, Instant};

/// A longer pause between two pictures is cut to this, and being late by more is not made up for.
const LONGEST: Duration = Duration::from_secs(2);

/// A recording that is played. Times are seconds since it was opened.
pub struct Paced {
    recording: Box<dyn Source>,
    opened: Instant,
    /// What is to be added to the recording's times.
    shift_s: Option<f64>,
}

impl Paced {
    /// The recording, from its first picture on.
    #[must_use]
    pub fn new(recording: Box<dyn Source>) -> Self {
        Self { recording, opened: Instant::now(), shift_s: None }
    }
}

impl Source for Paced {
    fn info(&self) -> &SourceInfo {
        self.recording.info()
    }

    fn next(&mut self) -> Result<Option<Frame<'_>>, SourceError> {
        let Some(frame) = self.recording.next()? else { return Ok(None) };
        let now_s = self.opened.elapsed().as_secs_f64();
        let (at_s, wait) = due(frame.t_s, &mut self.shift_s, now_s);
        thread::sleep(wait);
        Ok(Some(Frame { t_s: at_s, ..frame }))
    }

    fn now_s(&self) -> Option<f64> {
        Some(self.opened.elapsed().as_secs_f64())
    }

    fn take_notices(&mut self) -> Vec<String> {
        self.recording.take_notices()
    }
}

/// When a picture is due, by the clock of `now_s`, and how long that is from now.
fn due(t_s: f64, shift_s: &mut Option<f64>, now_s: f64) -> (f64, Duration) {
    let longest_s = LONGEST.as_secs_f64();
    let shift = shift_s.get_or_insert(now_s - t_s);
    let at_s = t_s + *shift;
    let at_s = if at_s > now_s + longest_s {
        now_s + longest_s
    } else if at_s < now_s - longest_s {
        now_s
    } else {
        at_s
    };
    *shift = at_s - t_s;
    (at_s, Duration::from_secs_f64((at_s - now_s).max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_as_they_were_taken_with_long_pauses_cut() {
        let mut shift = None;
        let mut at = |t_s, now_s| {
            let (at_s, wait) = due(t_s, &mut shift, now_s);
            (at_s, wait.as_millis())
        };
        assert_eq!(at(100.0, 5.0), (5.0, 0), "the first at once");
        assert_eq!(at(100.5, 5.25), (5.5, 250));
        assert_eq!(at(101.0, 6.5), (6.0, 0), "late, and its time says so");
        assert_eq!(at(200.0, 7.0), (9.0, 2_000), "a pause of 99 s");
        assert_eq!(at(200.5, 9.0), (9.5, 500), "goes on from there");
        assert_eq!(at(201.0, 20.0), (20.0, 0), "somebody was away");
        assert_eq!(at(201.5, 20.0), (20.5, 500));
    }
}
