//! What is behind the balls.

use crate::noise::Seeded;
use core::f64::consts::PI;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// What is behind the balls. It does not move with the balls, so it is made once and kept.
#[derive(Clone, Debug, PartialEq)]
pub enum Background {
    /// One grey level.
    Plain(f64),
    /// From one grey level in the top left corner to another in the bottom right one.
    Gradient(f64, f64),
    /// A desk with papers, books, boxes and hands, drawn from the seed; each camera has its own.
    Clutter {
        /// Another seed is another desk.
        seed: u64,
    },
    /// A picture for each camera (cameras beyond the last picture see the last), stretched to the
    /// scene's size.
    Pictures(Vec<Picture>),
}

/// An RGB888 picture.
#[derive(Clone, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    rgb: Arc<[u8]>,
}

impl Picture {
    /// A picture from packed rows of RGB888, or `None` when the size is zero or not that of `rgb`.
    #[must_use]
    pub fn new(width: usize, height: usize, rgb: Vec<u8>) -> Option<Self> {
        let right = width > 0 && height > 0 && rgb.len() == width.checked_mul(height)?.checked_mul(3)?;
        right.then(|| Self { width, height, rgb: rgb.into() })
    }
}

impl fmt::Debug for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Picture({}x{})", self.width, self.height)
    }
}

/// A rendered background: RGB in 1/256 grey level.
pub(crate) type Backdrop = Arc<[u16]>;

/// The backgrounds of a scene's cameras, each kept with what it was made from.
#[derive(Default)]
pub(crate) struct Kept(Mutex<Vec<(Key, Backdrop)>>);

type Key = (Background, u16, u16, usize);

impl Kept {
    /// The background of `camera`, made now if what it is made from has changed.
    pub(crate) fn get(&self, background: &Background, width: u16, height: u16, camera: usize) -> Backdrop {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = kept
            .iter()
            .find(|(key, _)| (key.1, key.2, key.3) == (width, height, camera) && key.0 == *background);
        if let Some((_, backdrop)) = found {
            return backdrop.clone();
        }
        kept.retain(|(key, _)| key.3 != camera);
        let backdrop = background.draw(usize::from(width), usize::from(height), camera);
        kept.push(((background.clone(), width, height, camera), backdrop.clone()));
        backdrop
    }
}

/// A copy of a scene makes its own.
impl Clone for Kept {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl fmt::Debug for Kept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Kept")
    }
}

impl Background {
    fn draw(&self, width: usize, height: usize, camera: usize) -> Backdrop {
        match self {
            Self::Plain(level) => vec![fixed(*level); width * height * 3].into(),
            Self::Gradient(from, to) => {
                let span = (width + height - 2).max(1) as f64;
                each_pixel(width, height, |x, y| [from + (to - from) * (x + y) as f64 / span; 3])
            }
            Self::Clutter { seed } => clutter(width, height, *seed, camera),
            Self::Pictures(pictures) => match pictures.get(camera).or(pictures.last()) {
                None => vec![0; width * height * 3].into(),
                Some(picture) => each_pixel(width, height, |x, y| {
                    let (px, py) = (x * picture.width / width, y * picture.height / height);
                    let at = 3 * (py * picture.width + px);
                    [0, 1, 2].map(|i| f64::from(picture.rgb[at + i]))
                }),
            },
        }
    }
}

/// Grey levels in 1/256, rounded and clipped.
pub(crate) fn fixed(level: f64) -> u16 {
    (level * 256.0 + 0.5).clamp(0.0, 65_535.0) as u16
}

fn each_pixel(width: usize, height: usize, colour: impl Fn(usize, usize) -> [f64; 3]) -> Backdrop {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    pixels.flat_map(|(x, y)| colour(x, y).map(fixed)).collect()
}

/// What lies on the desk, and how often: paper, card, leather, denim, steel, plant, brick, skin.
/// None is as pure as a ball, some are of a ball's hue.
const THINGS: [[f64; 3]; 12] = [
    [222.0, 220.0, 212.0],
    [236.0, 233.0, 226.0],
    [186.0, 158.0, 118.0],
    [96.0, 66.0, 48.0],
    [70.0, 84.0, 116.0],
    [132.0, 136.0, 140.0],
    [48.0, 50.0, 54.0],
    [96.0, 112.0, 78.0],
    [150.0, 92.0, 76.0],
    [206.0, 160.0, 134.0],
    [172.0, 122.0, 98.0],
    [204.0, 190.0, 140.0],
];

/// The table top.
const WOOD: [f64; 3] = [164.0, 136.0, 108.0];

/// How many things lie about in a picture of 640 x 480; other sizes have the same things, scaled.
const COUNT: usize = 60;

fn clutter(width: usize, height: usize, seed: u64, camera: usize) -> Backdrop {
    let mut random = Seeded::new("clutter", seed, &[camera as u64]);
    let scale = width as f64 / 640.0;
    let grain = Grain::new(&mut random);
    let mut canvas: Vec<[f64; 3]> = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let (u, v) = (x as f64 / scale, y as f64 / scale);
            // stretched along the boards
            let shade = 1.0 + 0.16 * grain.at(u / 90.0, v / 7.0) + 0.10 * grain.at(u / 31.0, v / 40.0);
            canvas.push(WOOD.map(|c| c * shade));
        }
    }
    for _ in 0..COUNT {
        let thing = Thing::drawn(&mut random, width as f64, height as f64, scale);
        thing.paint(&mut canvas, width, height, scale, &grain);
    }
    canvas.iter().flat_map(|pixel| pixel.map(fixed)).collect()
}

/// A rectangle or an ellipse lying on the desk.
struct Thing {
    centre: (f64, f64),
    half: (f64, f64),
    axis: (f64, f64),
    round: bool,
    colour: [f64; 3],
    slope: f64,
    texture: f64,
}

impl Thing {
    fn drawn(random: &mut Seeded, width: f64, height: f64, scale: f64) -> Self {
        let centre = (random.between(0.0, width), random.between(0.0, height));
        let half = (scale * random.between(8.0, 70.0), scale * random.between(6.0, 45.0));
        let angle = random.between(0.0, PI);
        let colour = THINGS[random.next_u32() as usize % THINGS.len()];
        let brighter = random.between(0.82, 1.06);
        Self {
            centre,
            half,
            axis: (libm::cos(angle), libm::sin(angle)),
            round: random.unit() < 0.3,
            colour: colour.map(|c| c * brighter),
            slope: random.between(-0.12, 0.12),
            texture: random.between(0.02, 0.16),
        }
    }

    fn paint(&self, canvas: &mut [[f64; 3]], width: usize, height: usize, scale: f64, grain: &Grain) {
        let reach = self.half.0 + self.half.1 + 1.0;
        let range = |middle: f64, end: usize| {
            let low = (middle - reach).clamp(0.0, end as f64) as usize;
            let high = (middle + reach + 1.0).clamp(0.0, end as f64) as usize;
            low..high
        };
        for y in range(self.centre.1, height) {
            for x in range(self.centre.0, width) {
                let (dx, dy) = (x as f64 - self.centre.0, y as f64 - self.centre.1);
                let along = dx * self.axis.0 + dy * self.axis.1;
                let across = dy * self.axis.0 - dx * self.axis.1;
                let (a, b) = (along.abs() - self.half.0, across.abs() - self.half.1);
                // pixels inside the edge, roughly: the edge is one pixel soft
                let inside = if self.round {
                    let (p, q) = (along / self.half.0, across / self.half.1);
                    (1.0 - libm::sqrt(p * p + q * q)) * self.half.0.min(self.half.1)
                } else {
                    -a.max(b)
                };
                let cover = (inside + 0.5).clamp(0.0, 1.0);
                if cover > 0.0 {
                    let (u, v) = (along / scale, across / scale);
                    let shade = 1.0
                        + self.slope * along / self.half.0
                        + self.texture * grain.at(u / 11.0 + 40.0, v / 11.0 + 40.0);
                    let pixel = &mut canvas[y * width + x];
                    for (value, colour) in pixel.iter_mut().zip(self.colour) {
                        *value += cover * (colour * shade - *value);
                    }
                }
            }
        }
    }
}

/// Value noise: random values on a lattice, smooth between.
struct Grain(Vec<f64>);

impl Grain {
    const SIDE: usize = 64;

    fn new(random: &mut Seeded) -> Self {
        Self((0..Self::SIDE * Self::SIDE).map(|_| random.between(-1.0, 1.0)).collect())
    }

    /// Between -1 and 1; repeats every 64 units.
    fn at(&self, x: f64, y: f64) -> f64 {
        let (fx, fy) = (libm::floor(x), libm::floor(y));
        let wrap = |v: f64, step: i64| (v as i64 + step).rem_euclid(Self::SIDE as i64) as usize;
        let value = |i: i64, j: i64| self.0[wrap(fy, j) * Self::SIDE + wrap(fx, i)];
        let soft = |t: f64| t * t * (3.0 - 2.0 * t);
        let (s, t) = (soft(x - fx), soft(y - fy));
        let top = value(0, 0) + s * (value(1, 0) - value(0, 0));
        let bottom = value(0, 1) + s * (value(1, 1) - value(0, 1));
        top + t * (bottom - top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_must_have_its_size() {
        assert!(Picture::new(2, 2, vec![0; 12]).is_some());
        assert!(Picture::new(2, 2, vec![0; 11]).is_none());
        assert!(Picture::new(0, 2, vec![]).is_none());
        assert!(Picture::new(usize::MAX, 2, vec![0; 12]).is_none());
    }

    #[test]
    fn pictures_are_stretched_and_the_last_serves_the_cameras_left_over() {
        let picture = Picture::new(2, 1, vec![10, 20, 30, 40, 50, 60]).expect("the right size");
        let drawn = Background::Pictures(vec![picture]).draw(4, 2, 1);
        assert_eq!(&drawn[..3], &[10 * 256, 20 * 256, 30 * 256]);
        assert_eq!(&drawn[21..], &[40 * 256, 50 * 256, 60 * 256]);
    }

    #[test]
    fn a_changed_background_is_drawn_anew() {
        let kept = Kept::default();
        assert_eq!(kept.get(&Background::Plain(10.0), 2, 2, 0)[0], 2560);
        assert_eq!(kept.get(&Background::Plain(20.0), 2, 2, 0)[0], 5120);
        let desk = |camera, seed| kept.get(&Background::Clutter { seed }, 64, 48, camera);
        assert_eq!(desk(0, 1), desk(0, 1));
        assert_ne!(desk(0, 1), desk(1, 1));
        assert_ne!(desk(0, 1), desk(0, 2));
    }
}
