//! What real cameras do to a picture and the scene renderer does not: a soft lens, one colour a pixel,
//! a tone curve.

/// What is between the scene and the picture, applied in the order lens, mosaic, tone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sensor {
    /// A lens whose image of a point is 2 px wide: weights 1, 2, 1 along both axes.
    pub soft: bool,
    /// A filter of one colour before each pixel (Bayer, red first), the other two interpolated.
    pub mosaic: bool,
    /// A tone curve: the light's power of 1 / 2.2.
    pub tone: bool,
}

impl Sensor {
    /// All three.
    pub const REAL: Self = Self { soft: true, mosaic: true, tone: true };

    /// Puts a picture of packed RGB through it.
    pub fn develop(self, rgb: &mut [u8], width: usize) {
        if self.soft {
            blur(rgb, width);
        }
        if self.mosaic {
            mosaic(rgb, width);
        }
        if self.tone {
            let curve: [u8; 256] =
                std::array::from_fn(|level| (255.0 * (level as f64 / 255.0).powf(1.0 / 2.2)).round() as u8);
            for value in rgb {
                *value = curve[usize::from(*value)];
            }
        }
    }
}

/// The value of a channel at a place, that of the border beyond it.
fn at(rgb: &[u8], (width, height): (usize, usize), x: isize, y: isize, channel: usize) -> u16 {
    let x = x.clamp(0, width as isize - 1) as usize;
    let y = y.clamp(0, height as isize - 1) as usize;
    u16::from(rgb[3 * (y * width + x) + channel])
}

fn blur(rgb: &mut [u8], width: usize) {
    let size = (width, rgb.len() / (3 * width));
    let sharp = rgb.to_vec();
    for (i, value) in rgb.iter_mut().enumerate() {
        let (x, y) = (((i / 3) % width) as isize, (i / 3 / width) as isize);
        let row = |dy: isize| {
            let here = |dx: isize| at(&sharp, size, x + dx, y + dy, i % 3);
            here(-1) + 2 * here(0) + here(1)
        };
        *value = ((row(-1) + 2 * row(0) + row(1) + 8) / 16) as u8;
    }
}

/// Which colour the filter before a pixel lets through: R G over G B.
fn filter(x: isize, y: isize) -> usize {
    (x.rem_euclid(2) + y.rem_euclid(2)) as usize
}

fn mosaic(rgb: &mut [u8], width: usize) {
    let (width, height) = (width, rgb.len() / (3 * width));
    let seen = rgb.to_vec();
    for (i, value) in rgb.iter_mut().enumerate() {
        let (x, y, channel) = (((i / 3) % width) as isize, (i / 3 / width) as isize, i % 3);
        if filter(x, y) == channel {
            continue;
        }
        // bilinear: the mean of the neighbours that have this colour
        let (mut sum, mut count) = (0u16, 0u16);
        for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
            let inside = (0..width as isize).contains(&(x + dx)) && (0..height as isize).contains(&(y + dy));
            // a green pixel's green neighbours are of no use to another colour, nor is the pixel itself
            let near = channel != 1 || dx == 0 || dy == 0;
            if inside && near && filter(x + dx, y + dy) == channel {
                sum += at(&seen, (width, height), x + dx, y + dy, channel);
                count += 1;
            }
        }
        *value = ((sum + count / 2) / count.max(1)) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(colour: impl Fn(usize, usize) -> [u8; 3]) -> Vec<u8> {
        (0..8).flat_map(|y| (0..8).map(move |x| (x, y))).flat_map(|(x, y)| colour(x, y)).collect()
    }

    #[test]
    fn one_colour_everywhere_stays_and_the_tone_curve_keeps_its_ends() {
        let plain = picture(|_, _| [0, 100, 255]);
        let mut seen = plain.clone();
        Sensor { tone: false, ..Sensor::REAL }.develop(&mut seen, 8);
        assert_eq!(seen, plain);
        Sensor { tone: true, ..Sensor::default() }.develop(&mut seen, 8);
        assert_eq!(seen[..3], [0, 167, 255]);
    }

    #[test]
    fn a_slope_survives_blur_and_mosaic_inside_the_picture() {
        let slope = picture(|x, y| [10 * x as u8, 100, 10 * y as u8]);
        let mut seen = slope.clone();
        Sensor { tone: false, ..Sensor::REAL }.develop(&mut seen, 8);
        for (x, y) in (2..6).flat_map(|y| (2..6).map(move |x| (x, y))) {
            let at = 3 * (8 * y + x);
            assert_eq!(seen[at..at + 3], slope[at..at + 3], "{x}, {y}");
        }
    }

    #[test]
    fn a_dot_is_spread_by_the_lens() {
        let mut dot = picture(|x, y| if (x, y) == (4, 4) { [160; 3] } else { [0; 3] });
        Sensor { soft: true, ..Sensor::default() }.develop(&mut dot, 8);
        let grey = |x: usize, y: usize| dot[3 * (8 * y + x)];
        assert_eq!([grey(4, 4), grey(3, 4), grey(3, 3), grey(2, 4)], [40, 20, 10, 0]);
    }
}
