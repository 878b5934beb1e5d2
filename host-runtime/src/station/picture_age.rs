//! How old a picture of the scene is, and from when on nobody may steer by it unwarned.

use crate::link::{Picture, Received};

/// From this age on a picture is marked as stale, microseconds: at the lowest rate of pictures (15 / 4 a
/// second) a line that is in order brings a new one in half of this time.
pub const STALE_US: u64 = 500_000;

/// How old what the picture shows is at `now_us` of this station's clock, microseconds: since it was
/// taken, as far as the other clock is known, and never less than since it came.
#[must_use]
pub fn picture_age_us(picture: &Received<Picture>, now_us: u64) -> u64 {
    let since_taken = picture.captured_us.map_or(0, |captured_us| now_us.saturating_sub(captured_us));
    since_taken.max(picture.age_us(now_us))
}

/// Whether the picture is to be marked as stale.
#[must_use]
pub fn is_stale(picture: &Received<Picture>, now_us: u64) -> bool {
    picture_age_us(picture, now_us) >= STALE_US
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_age_is_the_worst_that_is_known() {
        let picture = |captured_us| Received {
            what: Picture {
                camera: 0,
                session: 1,
                sequence: 2,
                capture_us: 77,
                width: 640,
                height: 480,
                jpeg: Vec::new(),
            },
            received_us: 1_000_000,
            captured_us,
        };
        assert_eq!(picture_age_us(&picture(Some(940_000)), 1_010_000), 70_000);
        assert_eq!(picture_age_us(&picture(None), 1_010_000), 10_000);
        // clocks that are known badly make nothing younger
        assert_eq!(picture_age_us(&picture(Some(2_000_000)), 1_010_000), 10_000);
        assert!(!is_stale(&picture(Some(900_000)), 1_399_999));
        assert!(is_stale(&picture(Some(900_000)), 1_400_000));
        assert!(is_stale(&picture(None), 1_500_000));
    }
}
