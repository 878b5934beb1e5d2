//! Which frames of two sources were taken together, and how it is known.

use super::StreamError;
use crate::source::{DEFAULT_FPS, Frame, Gap, Labels, SourceInfo};

/// How the frames of two sources are told to belong together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pairing {
    /// Two live cameras: the one that lags gives frames away until this many seconds part them at most.
    Live {
        /// Half a frame of the slower camera.
        largest_skew_s: f64,
    },
    /// Both recordings have the times of their pictures, which this many seconds may part.
    Times {
        /// Half a frame of the faster recording.
        largest_skew_s: f64,
    },
    /// Both recordings number their pictures: equal numbers belong together.
    Numbers,
    /// They were recorded in pairs, and are in order.
    Recorded,
    /// One of them has no numbers: the order is all there is, and a gap in one alone breaks it.
    Order,
}

impl Pairing {
    /// What these two sources allow.
    pub(super) fn of(left: &SourceInfo, right: &SourceInfo) -> Self {
        if left.live && right.live {
            let fps = |info: &SourceInfo| info.fps.unwrap_or(DEFAULT_FPS);
            return Self::Live { largest_skew_s: 0.5 / fps(left).min(fps(right)) };
        }
        match (left.labels, right.labels) {
            (Labels::Pairs, Labels::Pairs) => Self::Recorded,
            (Labels::Order | Labels::Pairs, _) | (_, Labels::Order | Labels::Pairs) => Self::Order,
            (Labels::Times { step_s: left }, Labels::Times { step_s: right }) => {
                Self::Times { largest_skew_s: 0.5 * left.min(right) }
            }
            _ => Self::Numbers,
        }
    }

    /// Refuses two recorded frames that were not taken together; `pairs` were right before.
    pub(super) fn check(self, left: &Frame<'_>, right: &Frame<'_>, pairs: u64) -> Result<(), StreamError> {
        match self {
            Self::Live { .. } | Self::Recorded => Ok(()),
            Self::Times { largest_skew_s } => {
                if (left.t_s - right.t_s).abs() <= largest_skew_s {
                    return Ok(());
                }
                let (left_s, right_s) = (left.t_s, right.t_s);
                let (left, right) = (left.number, right.number);
                Err(StreamError::Times { left, right, left_s, right_s, largest_skew_s, pairs })
            }
            Self::Numbers if left.number == right.number => Ok(()),
            Self::Numbers => {
                let (left, right) = (left.number, right.number);
                let (lacks, number) = if left < right { ("right", left) } else { ("left", right) };
                Err(StreamError::Numbers { left, right, lacks, number, pairs })
            }
            Self::Order if left.gap == right.gap => Ok(()),
            Self::Order => {
                let (name, number) =
                    if left.gap == Gap::None { ("right", right.number) } else { ("left", left.number) };
                Err(StreamError::Gap { name, number, pairs })
            }
        }
    }

    /// What mends recordings of unequal length, every pair of which passed [`Pairing::check`].
    pub(super) const fn when_unequal(self) -> &'static str {
        match self {
            Self::Order => {
                "Frames paired by their order are right only if both sources begin together: \
                 make sure of that first, then cut the end of the longer one"
            }
            _ => "Cut the end of the longer one to the length of the shorter",
        }
    }
}
