//! A colour's name, for those who cannot tell it by looking.

use tetrad_core::vision::frame::Rgb;

/// Of 255, from where on it is a colour at all.
const BLACK: u8 = 40;

/// A hue of so many degrees is called so, up to the next.
const HUES: [(u16, &str); 11] = [
    (0, "red"),
    (16, "orange"),
    (45, "yellow"),
    (68, "yellow-green"),
    (90, "green"),
    (160, "blue-green"),
    (195, "blue"),
    (250, "violet"),
    (290, "purple"),
    (325, "pink-red"),
    (345, "red"),
];

/// What people call it, roughly.
#[must_use]
pub(super) fn name(colour: Rgb) -> String {
    let Rgb { r, g, b } = colour;
    let (most, least) = (r.max(g).max(b), r.min(g).min(b));
    let chroma = u16::from(most - least);
    if most < BLACK {
        return "black".to_owned();
    }
    if chroma * 100 < 15 * u16::from(most) {
        let grey = match most {
            0..90 => "dark grey",
            90..160 => "grey",
            160..225 => "light grey",
            225.. => "white",
        };
        return grey.to_owned();
    }
    let degrees = hue(colour, i32::from(most), i32::from(chroma));
    let hue = HUES.iter().rev().find(|(from, _)| degrees >= *from).map_or("red", |(_, name)| name);
    let saturation = chroma * 100 / u16::from(most);
    match (most, saturation) {
        (0..110, _) => format!("dark {hue}"),
        (180.., 75..) => format!("strong {hue}"),
        (_, 0..40) => format!("pale {hue}"),
        _ => hue.to_owned(),
    }
}

/// Degrees from red over green to blue, 0 to 359; `chroma` is above 0.
fn hue(Rgb { r, g, b }: Rgb, most: i32, chroma: i32) -> u16 {
    let [r, g, b] = [r, g, b].map(i32::from);
    let turned = if most == r {
        60 * (g - b) / chroma
    } else if most == g {
        120 + 60 * (b - r) / chroma
    } else {
        240 + 60 * (r - g) / chroma
    };
    turned.rem_euclid(360) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_called_what_people_call_them() {
        let names = [
            ((203, 41, 52), "strong red"),
            ((90, 20, 25), "dark red"),
            ((40, 160, 70), "green"),
            ((40, 70, 200), "strong blue"),
            ((230, 200, 40), "strong yellow"),
            ((230, 200, 160), "pale orange"),
            ((255, 255, 255), "white"),
            ((120, 118, 110), "grey"),
            ((10, 12, 9), "black"),
            ((200, 60, 200), "purple"),
            ((200, 20, 40), "strong red"),
        ];
        for ((r, g, b), expected) in names {
            assert_eq!(name(Rgb::new(r, g, b)), expected, "{r} {g} {b}");
        }
    }

    #[test]
    fn every_colour_has_a_name() {
        for r in (0..=255).step_by(15) {
            for g in (0..=255).step_by(15) {
                for b in (0..=255).step_by(15) {
                    assert!(!name(Rgb::new(r, g, b)).is_empty());
                }
            }
        }
    }
}
