//! What is written to the controller, and the numbers it prints.

use super::convention::ValDegrees;

/// Ends every command and every answer.
pub(super) const END: char = '\r';

/// A line that is no command, no answer and no name: what an interrupted session left on the
/// controller's line becomes an error by it instead of a command, "DO MOVE #P" for one. No command of
/// VAL begins so.
pub(super) const SPOIL: &str = "QQQ";

/// Asks where the joints are.
pub(super) const WHERE: &str = "WHERE";

/// Begins the calibration, which moves every joint a little.
pub(super) const CALIBRATE: &str = "CAL";

/// Begins to define the joint point that is moved to.
pub(super) const POINT: &str = "POINT #P";

/// Moves to it.
pub(super) const MOVE: &str = "DO MOVE #P";

/// Says yes.
pub(super) const YES: &str = "y";

/// Says no.
pub(super) const NO: &str = "n";

/// What the question says that POINT asks, in capitals.
pub(super) const CHANGE: &str = "CHANGE";

/// What the questions say that a controller asks when it is switched on, in capitals.
const START_UP: [&str; 2] = ["FLOPPY", "INITIALIZE"];

/// What an error text says when the arm is not calibrated, in capitals.
const NOT_CALIBRATED: &str = "CALIB";

/// A hundredth of a degree: what is sent, 0.15 mm at the end of a stretched arm.
const PER_DEGREE: f64 = 100.0;

/// Whether a controller asks this when it is switched on.
#[must_use]
pub(super) fn is_start_up(question: &str) -> bool {
    let question = question.to_uppercase();
    START_UP.iter().any(|word| question.contains(word))
}

/// Whether an error text says that the arm is not calibrated.
#[must_use]
pub(super) fn is_not_calibrated(error: &str) -> bool {
    error.to_uppercase().contains(NOT_CALIBRATED)
}

/// Whether `echo` is `sent`, capitals and blanks apart.
#[must_use]
pub(super) fn is_echo(echo: &str, sent: &str) -> bool {
    let letters = |text: &str| -> Vec<u8> {
        text.bytes().filter(|byte| *byte != b' ').map(|byte| byte.to_ascii_uppercase()).collect()
    };
    letters(echo) == letters(sent)
}

/// The hundredths of a degree nearest to `angles`.
#[must_use]
pub(super) fn hundredths(angles: &ValDegrees) -> [i64; 6] {
    angles.map(|angle| (angle * PER_DEGREE).round() as i64)
}

/// `j1,...,j6` in degrees.
#[must_use]
pub(super) fn point(hundredths: &[i64; 6]) -> String {
    hundredths.map(|angle| format!("{:.2}", angle as f64 / PER_DEGREE)).join(",")
}

/// V+ sets the point in one line.
#[must_use]
pub(super) fn set_point(hundredths: &[i64; 6]) -> String {
    format!("DO SET #P=#PPOINT({})", point(hundredths))
}

/// The arm's own speed, percent.
#[must_use]
pub(super) fn speed(percent: u8) -> String {
    format!("SPEED {percent}")
}

/// The numbers on a line; words, and digits in them, are passed over. Columns may touch: a minus sign
/// begins a number.
pub(super) fn numbers(line: &str, found: &mut Vec<f64>) {
    for word in line.split(|c: char| c.is_whitespace() || c == ',') {
        let mut rest = word;
        while !rest.is_empty() {
            let next = rest.get(1..).and_then(|tail| tail.find(['-', '+'])).map_or(rest.len(), |at| at + 1);
            let (number, tail) = rest.split_at(next);
            let plain = number.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'.' | b'-' | b'+'));
            match number.parse::<f64>() {
                Ok(value) if plain && value.is_finite() => found.push(value),
                // "JT1-JT6" is a word to its end
                _ => break,
            }
            rest = tail;
        }
    }
}

/// The joints in what WHERE printed, degrees: the place of the tool and then the joints, or the joints
/// alone.
#[must_use]
pub(super) fn joints(numbers: &[f64]) -> Option<ValDegrees> {
    if ![6, 12].contains(&numbers.len()) {
        return None;
    }
    numbers.last_chunk::<6>().copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Vec<f64> {
        let mut found = Vec::new();
        text.lines().for_each(|line| numbers(line, &mut found));
        found
    }

    #[test]
    fn where_is_read_whatever_its_columns() {
        let classic = "   X      Y      Z      O      A      T\n -20.32 149.09 921.12 90.000 -90.000 0.000\n  JT1 JT2 JT3 JT4 JT5 JT6\n 0.000 -90.000 90.000 0.000 0.000 0.000";
        assert_eq!(joints(&read(classic)), Some([0.0, -90.0, 90.0, 0.0, 0.0, 0.0]));
        let bare = "1,2,3\n4,5,-6.5";
        assert_eq!(joints(&read(bare)), Some([1.0, 2.0, 3.0, 4.0, 5.0, -6.5]));
        let touching = "-120.000-100.00-1.5 2 3 4";
        assert_eq!(joints(&read(touching)), Some([-120.0, -100.0, -1.5, 2.0, 3.0, 4.0]));
        assert_eq!(read("JT1-JT6 J2 inf NaN 1e5 0x10 --3 3."), [3.0]);
    }

    #[test]
    fn a_number_too_few_or_too_many_is_no_answer() {
        assert_eq!(joints(&[0.0; 5]), None);
        assert_eq!(joints(&[0.0; 7]), None);
        assert_eq!(joints(&[0.0; 11]), None);
        assert_eq!(joints(&[0.0; 13]), None);
    }

    #[test]
    fn a_point_has_hundredths_of_a_degree() {
        let angles = [0.0, -90.004, 89.996, -0.004, 12.345_1, 265.999];
        assert_eq!(point(&hundredths(&angles)), "0.00,-90.00,90.00,0.00,12.35,266.00");
        assert_eq!(set_point(&[1, 0, 0, 0, 0, -100]), "DO SET #P=#PPOINT(0.01,0.00,0.00,0.00,0.00,-1.00)");
    }

    #[test]
    fn an_echo_may_be_in_capitals_but_not_lack_a_character() {
        assert!(is_echo("do move  #p", MOVE));
        assert!(!is_echo("DO MOE #P", MOVE));
        assert!(!is_echo("1.00,2.00", "1.00,-2.00"));
    }
}
