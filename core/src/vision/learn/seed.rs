//! The ball's colour at the point the operator gave.

use super::LearnError;
use super::probe::{Probe, brightness, chroma};
use crate::config::{LearnConfig, MAX_DIAMETER};
use crate::geometry::ImagePoint;
use crate::vision::colour::Primary;
use crate::vision::frame::Rgb;

/// The most colourful pixel within two of the point; where those are a highlight, the search widens
/// ring by ring until it meets the colour, and goes as far again, past the highlight's pale rim.
pub(super) fn seed_colour(
    probe: &mut Probe<'_, '_>,
    primary: Primary,
    at: ImagePoint,
    config: &LearnConfig,
) -> Result<Rgb, LearnError> {
    let (cx, cy) = (libm::roundf(at.u) as i32, libm::roundf(at.v) as i32);
    let mut best: Option<(i32, Rgb)> = None;
    let mut reach = config.seed_reach.min(MAX_DIAMETER as i32);
    let mut ring = 0;
    while ring <= reach {
        for y in cy - ring..=cy + ring {
            for x in cx - ring..=cx + ring {
                if (x - cx).abs() != ring && (y - cy).abs() != ring {
                    continue;
                }
                let Some(p) = probe.pixel(x, y) else {
                    continue;
                };
                let found = chroma(primary, p);
                if found < config.least_chroma || best.is_some_and(|(most, _)| found <= most) {
                    continue;
                }
                if best.is_none() {
                    reach = reach.min(2 * ring + 2);
                }
                best = Some((found, p));
            }
        }
        ring += 1;
    }
    match (best, probe.pixel(cx, cy)) {
        (Some((_, p)), _) => Ok(p),
        (None, Some(p)) if p.r.min(p.g).min(p.b) >= BLOWN_OUT || brightness(p) <= BLACK => {
            Err(LearnError::Saturated)
        }
        _ => Err(LearnError::Background),
    }
}

/// A grey pixel from this level up is blown out.
const BLOWN_OUT: u8 = 240;
/// A pixel up to this level is black.
const BLACK: i32 = 16;
