//! The colours of curves: each is to be seen on the white and on the dark ground of every page that shows it.

/// Red.
pub const RED: &str = "#d64545";
/// Green.
pub const GREEN: &str = "#2f9e6e";
/// Blue.
pub const BLUE: &str = "#3b7dd8";
/// Orange.
pub const ORANGE: &str = "#c9711a";
/// Violet.
pub const VIOLET: &str = "#8457c4";
/// Grey.
pub const GREY: &str = "#8a8f98";

#[cfg(test)]
mod tests {
    use super::*;

    /// The report's paper and the console's panels (page.css, style.css), light and dark.
    const GROUNDS: [&str; 3] = ["#ffffff", "#15181c", "#1e232b"];

    /// WCAG 2.2: relative luminance.
    fn light(hex: &str) -> f64 {
        let channel = |at: usize| {
            let value = f64::from(u8::from_str_radix(&hex[at..at + 2], 16).unwrap()) / 255.0;
            if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
    }

    /// 1.4.11: three to one for what is drawn.
    #[test]
    fn curves_are_seen_in_the_light_and_in_the_dark() {
        for ground in GROUNDS {
            let style = [include_str!("page.css"), include_str!("../console/page/style.css")].concat();
            assert!(style.contains(ground) || ground == "#ffffff" && style.contains("#fff;"), "{ground}");
            for ink in [RED, GREEN, BLUE, ORANGE, VIOLET, GREY] {
                let (a, b) = (light(ink) + 0.05, light(ground) + 0.05);
                let ratio = a.max(b) / a.min(b);
                assert!(ratio >= 3.0, "{ink} on {ground}: {ratio:.2}");
            }
        }
    }
}
