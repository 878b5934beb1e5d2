//! One or two sources read in step.
//!
//! Recordings and scenes pair their frames by index, and a pair that was not taken together ends the
//! run: folders with timestamps.csv must agree to half a frame, other folders in the frame number. Two
//! live cameras pair them by capture time: the one that lags gives frames away until the two are at most
//! half a frame apart.

mod pairing;

use crate::exit::{Exit, Failure};
use crate::source::{Frame, Source, SourceError};
use pairing::Pairing;
use std::fmt;
use std::ops::ControlFlow;

/// A source with its name on the command line.
pub struct Stream {
    /// `left` or `right`.
    pub name: &'static str,
    /// Its pictures.
    pub source: Box<dyn Source>,
}

/// Why reading in step ended early.
#[derive(Debug, thiserror::Error)]
pub enum StreamError {
    /// A source could not deliver.
    #[error("the {name} source failed after {index} frames")]
    Source {
        /// `left` or `right`.
        name: &'static str,
        /// How many frames it delivered before.
        index: u64,
        /// What the source said.
        #[source]
        cause: SourceError,
    },
    /// A source without a single frame.
    #[error("the {name} source `{source_name}` has no frames")]
    Empty {
        /// `left` or `right`.
        name: &'static str,
        /// SRC as it was given.
        source_name: String,
    },
    /// A picture is missing in one recording and not in the other: from there on the pairs are wrong.
    #[error(
        "a picture is missing before frame {number} of the {name} source, and not in the other: \
         {pairs} pairs before it were tracked. Put it back, or take its partner away as well"
    )]
    Gap {
        /// `left` or `right`.
        name: &'static str,
        /// What the frame after the gap is called.
        number: u64,
        /// Pairs delivered before.
        pairs: u64,
    },
    /// Two recordings number the pictures of a pair differently.
    #[error(
        "left frame {left} does not belong to right frame {right}: the {lacks} source lacks picture {number} \
         ({pairs} pairs before it were tracked). Put it back, or take its partner away as well; if the \
         pictures were taken together, give them equal numbers"
    )]
    Numbers {
        /// The number of the left frame.
        left: u64,
        /// The number of the right frame.
        right: u64,
        /// `left` or `right`: whose picture is missing.
        lacks: &'static str,
        /// The number of the picture that is missing.
        number: u64,
        /// Pairs delivered before.
        pairs: u64,
    },
    /// The times of a pair are too far apart.
    #[error(
        "left frame {left} was taken at {left_s} s and right frame {right} at {right_s} s, more than half a \
         frame ({largest_skew_s:.4} s) apart ({pairs} pairs before them were tracked): a picture is missing in \
         one folder, or the two timestamps.csv do not go by one clock"
    )]
    Times {
        /// The number of the left frame.
        left: u64,
        /// The number of the right frame.
        right: u64,
        /// When the left frame was taken, seconds.
        left_s: f64,
        /// When the right frame was taken, seconds.
        right_s: f64,
        /// How far apart they may be, seconds.
        largest_skew_s: f64,
        /// Pairs delivered before.
        pairs: u64,
    },
    /// One source ended before the other.
    #[error(
        "the sources differ in length: left has {left} frames and right has {right}; \
         the {} both have were tracked. {mend}", left.min(right)
    )]
    Unequal {
        /// Frames of the left source.
        left: Count,
        /// Frames of the right source.
        right: Count,
        /// What would mend it.
        mend: &'static str,
    },
}

impl From<StreamError> for Failure {
    fn from(error: StreamError) -> Self {
        let exit = match &error {
            StreamError::Source { cause, .. } => cause.exit(),
            // nothing was begun: the recordings that were named do not go together
            StreamError::Gap { pairs: 0, .. }
            | StreamError::Numbers { pairs: 0, .. }
            | StreamError::Times { pairs: 0, .. } => Exit::BadArguments,
            StreamError::Empty { .. }
            | StreamError::Gap { .. }
            | StreamError::Numbers { .. }
            | StreamError::Times { .. }
            | StreamError::Unequal { .. } => Exit::Failed,
        };
        Self::new(exit, error)
    }
}

/// A number of frames that was counted to the end, or to an unreadable one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Count {
    /// The frames that could be read.
    pub frames: u64,
    /// Whether the source ended there.
    pub ended: bool,
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", if self.ended { "" } else { "at least " }, self.frames)
    }
}

/// What ended the reading without an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Every source ended, after as many frames.
    Exhausted,
    /// The callback asked to stop.
    Stopped,
}

/// One or two sources read in step.
pub struct Streams {
    left: Stream,
    right: Option<Stream>,
}

impl Streams {
    /// The left (or only) source, and the right one.
    #[must_use]
    pub fn new(left: Stream, right: Option<Stream>) -> Self {
        Self { left, right }
    }

    /// The sources, left first.
    pub fn iter(&self) -> impl Iterator<Item = &Stream> {
        std::iter::once(&self.left).chain(&self.right)
    }

    /// The sources, left first.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Stream> {
        std::iter::once(&mut self.left).chain(&mut self.right)
    }

    /// How many frames each source has, if all are known beforehand: of the shortest.
    #[must_use]
    pub fn frames(&self) -> Option<u64> {
        self.iter().map(|stream| stream.source.info().frames).min().flatten()
    }

    /// Lends one frame of each source at a time to `each`, until the sources end or it breaks.
    ///
    /// # Errors
    /// [`StreamError`] when a source fails, has no frame at all, ends before the other or has frames
    /// that were not taken with its; or what `each` returned.
    pub fn run<E: From<StreamError>>(
        &mut self,
        mut each: impl FnMut(&[Frame<'_>]) -> Result<ControlFlow<()>, E>,
    ) -> Result<End, E> {
        match &mut self.right {
            None => run_one(&mut self.left, &mut each),
            Some(right) => run_two(&mut self.left, right, &mut each),
        }
    }
}

impl Stream {
    /// The next frame; `delivered` is how many there were before, for the message.
    fn next(&mut self, delivered: u64) -> Result<Option<Frame<'_>>, StreamError> {
        match self.source.next() {
            Ok(frame) => Ok(frame),
            Err(cause) => Err(StreamError::Source { name: self.name, index: delivered, cause }),
        }
    }

    fn empty(&self) -> StreamError {
        StreamError::Empty { name: self.name, source_name: self.source.info().name.clone() }
    }

    /// Reads on to the end, to say how long the source is.
    fn count(&mut self, mut frames: u64) -> Count {
        loop {
            match self.source.next() {
                Ok(Some(_)) => frames += 1,
                Ok(None) => return Count { frames, ended: true },
                Err(_) => return Count { frames, ended: false },
            }
        }
    }
}

fn run_one<E: From<StreamError>>(
    left: &mut Stream,
    each: &mut impl FnMut(&[Frame<'_>]) -> Result<ControlFlow<()>, E>,
) -> Result<End, E> {
    let mut delivered = 0;
    while let Some(frame) = left.next(delivered)? {
        delivered += 1;
        if each(&[frame])?.is_break() {
            return Ok(End::Stopped);
        }
    }
    if delivered == 0 { Err(left.empty().into()) } else { Ok(End::Exhausted) }
}

fn run_two<E: From<StreamError>>(
    left: &mut Stream,
    right: &mut Stream,
    each: &mut impl FnMut(&[Frame<'_>]) -> Result<ControlFlow<()>, E>,
) -> Result<End, E> {
    let pairing = Pairing::of(left.source.info(), right.source.info());
    let mend = pairing.when_unequal();
    let mut pairs = 0;
    loop {
        let mut from_left = left.next(pairs)?;
        let mut from_right = right.next(pairs)?;
        if let Pairing::Live { largest_skew_s: largest } = pairing {
            while let (Some(l), Some(r)) = (&from_left, &from_right) {
                let skew_s = l.t_s - r.t_s;
                if skew_s < -largest {
                    from_left = left.next(pairs)?;
                } else if skew_s > largest {
                    from_right = right.next(pairs)?;
                } else {
                    break;
                }
            }
        }
        let ended = |frames| Count { frames, ended: true };
        match (from_left, from_right) {
            (Some(l), Some(r)) => {
                pairing.check(&l, &r, pairs)?;
                pairs += 1;
                if each(&[l, r])?.is_break() {
                    return Ok(End::Stopped);
                }
            }
            (None, None) if pairs == 0 => return Err(left.empty().into()),
            (None, None) => return Ok(End::Exhausted),
            (None, Some(_)) if pairs == 0 => return Err(left.empty().into()),
            (Some(_), None) if pairs == 0 => return Err(right.empty().into()),
            (None, Some(_)) => {
                let right = right.count(pairs + 1);
                return Err(StreamError::Unequal { left: ended(pairs), right, mend }.into());
            }
            (Some(_), None) => {
                let left = left.count(pairs + 1);
                return Err(StreamError::Unequal { left, right: ended(pairs), mend }.into());
            }
        }
    }
}

#[cfg(test)]
mod tests;
