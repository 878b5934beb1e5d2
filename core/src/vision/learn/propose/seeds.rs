//! Where in a picture a ball of each colour may be: pixels far more colourful than what is around.

use crate::config::ProposeConfig;
use crate::geometry::ImagePoint;
use crate::observation::{BALLS, Ball};
use crate::vision::colour::Primary;
use crate::vision::frame::Rgb;
use crate::vision::learn::probe::{Probe, chroma};
use heapless::Vec;

/// Seeds kept of each colour.
pub(super) const MAX_SEEDS: usize = 8;

/// A pixel that stands out, and the middle of those beside it that do so as well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seed {
    x: i32,
    y: i32,
    /// Chroma above that of the surroundings, levels.
    contrast: i32,
    /// How far the surroundings are, pixels: no more than a diameter.
    reach: i32,
    /// Pixels of the grid that stand out here at least half as much, and the sums of their places.
    alike: i32,
    sum_x: i32,
    sum_y: i32,
}

impl Seed {
    /// Where to learn: the most colourful pixel of a ball lies beside its highlight, near the rim;
    /// the middle of the colourful ones is the better point.
    pub(super) fn point(&self) -> ImagePoint {
        let n = self.alike.max(1) as f32;
        ImagePoint::new(self.sum_x as f32 / n, self.sum_y as f32 / n)
    }
}

/// The best seeds of each colour, in no order.
pub(super) type Seeds = [Vec<Seed, MAX_SEEDS>; BALLS];

/// Goes over a grid of the picture. A pixel counts for the one colour whose chroma is greatest: an
/// orange ball is yellow, not red.
pub(super) fn find(probe: &mut Probe<'_, '_>, config: &ProposeConfig) -> Seeds {
    let mut seeds = Seeds::default();
    let pixels = (probe.width() * probe.height()) as f32;
    let step = libm::ceilf(libm::sqrtf(pixels / config.grid_samples.max(1) as f32)).max(2.0) as i32;
    let mut y = step / 2;
    while y < probe.height() {
        let mut x = step / 2;
        while x < probe.width() {
            if let Some(p) = probe.pixel(x, y) {
                let (ball, colourful) = strongest(p);
                if colourful >= config.learn.least_chroma
                    && let Some(seed) = stand_out(probe, (x, y), Primary::of(ball), colourful, step)
                    && let Some(list) = seeds.get_mut(ball.index())
                {
                    keep(list, seed);
                }
            }
            x += step;
        }
        y += step;
    }
    seeds
}

/// The ball whose colour a pixel has most of, and how much.
fn strongest(p: Rgb) -> (Ball, i32) {
    let mut best = (Ball::Red, i32::MIN);
    for ball in Ball::ALL {
        let found = chroma(Primary::of(ball), p);
        if found > best.1 {
            best = (ball, found);
        }
    }
    best
}

/// By how much a pixel exceeds its surroundings: on circles of eight pixels, ever larger, the third
/// most colourful, since fingers and other balls of the frame may touch. `None` where nothing does.
fn stand_out(
    probe: &mut Probe<'_, '_>,
    (x, y): (i32, i32),
    primary: Primary,
    colourful: i32,
    step: i32,
) -> Option<Seed> {
    let mut best: Option<Seed> = None;
    for scale in SCALES {
        let reach = scale * step;
        let diagonal = reach * 7 / 10;
        let around = [
            (reach, 0),
            (diagonal, diagonal),
            (0, reach),
            (-diagonal, diagonal),
            (-reach, 0),
            (-diagonal, -diagonal),
            (0, -reach),
            (diagonal, -diagonal),
        ];
        // The three most colourful, greatest first; outside the picture there is nothing.
        let mut top = [0i32; 3];
        for (dx, dy) in around {
            let mut found = probe.pixel(x + dx, y + dy).map_or(0, |p| chroma(primary, p));
            for slot in &mut top {
                if found > *slot {
                    core::mem::swap(slot, &mut found);
                }
            }
        }
        let [_, _, third] = top;
        let contrast = colourful - third;
        // A larger circle must do clearly better: the smallest that is off the ball tells its size.
        if contrast > 0 && best.is_none_or(|b| contrast * 10 > b.contrast * 11) {
            best = Some(Seed { x, y, contrast, reach, alike: 1, sum_x: x, sum_y: y });
        }
    }
    // Little contrast beside much colour is a shade within a coloured wall.
    best.filter(|seed| seed.contrast * 3 >= colourful)
}

/// Radii of the circles, in grid steps: balls from one and a half to some 30 steps across.
const SCALES: [i32; 5] = [2, 4, 7, 11, 17];

/// Keeps the best seeds, one where several stand within each other's reach.
fn keep(list: &mut Vec<Seed, MAX_SEEDS>, seed: Seed) {
    let near = |other: &Seed| {
        let reach = other.reach.min(seed.reach);
        (other.x - seed.x).abs() <= reach && (other.y - seed.y).abs() <= reach
    };
    if let Some(other) = list.iter_mut().find(|other| near(other)) {
        if seed.contrast * 2 >= other.contrast {
            let (alike, sum_x, sum_y) = if seed.contrast >= other.contrast * 2 {
                (1, seed.x, seed.y)
            } else {
                (other.alike + 1, other.sum_x + seed.x, other.sum_y + seed.y)
            };
            let better = if seed.contrast > other.contrast { seed } else { *other };
            *other = Seed { alike, sum_x, sum_y, ..better };
        }
        return;
    }
    if let Err(seed) = list.push(seed)
        && let Some(least) = list.iter_mut().min_by_key(|s| s.contrast)
        && seed.contrast > least.contrast
    {
        *least = seed;
    }
}
