//! Frame numbers in file names, and the order they give.

use std::cmp::Ordering;

/// The frame number a file stem carries: its last run of digits (`take2_frame00158` is 158).
/// `Ok(None)` without digits.
///
/// # Errors
/// The digits, when they are too large for a number.
pub(super) fn frame_number(stem: &str) -> Result<Option<u64>, &str> {
    let Some(end) = stem.rfind(|c: char| c.is_ascii_digit()).map(|at| at + 1) else {
        return Ok(None);
    };
    let start = stem[..end].rfind(|c: char| !c.is_ascii_digit()).map_or(0, |at| {
        // One past the last character that is no digit; it may be several bytes long.
        at + stem[at..].chars().next().map_or(1, char::len_utf8)
    });
    let digits = &stem[start..end];
    digits.parse().map(Some).map_err(|_| digits)
}

/// Compares names the way people number them: digits by value, all else by character, so that
/// `frame10` comes after `frame9`.
pub(crate) fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut a_rest, mut b_rest) = (a, b);
    loop {
        let (Some(x), Some(y)) = (a_rest.chars().next(), b_rest.chars().next()) else {
            // One is the other's beginning, or they differ only in leading zeros.
            return a_rest.len().cmp(&b_rest.len()).then_with(|| a.cmp(b));
        };
        if x.is_ascii_digit() && y.is_ascii_digit() {
            let (x_digits, x_after) = split_digits(a_rest);
            let (y_digits, y_after) = split_digits(b_rest);
            let by_value = x_digits.len().cmp(&y_digits.len()).then_with(|| x_digits.cmp(y_digits));
            if by_value.is_ne() {
                return by_value;
            }
            (a_rest, b_rest) = (x_after, y_after);
        } else {
            if x != y {
                return x.cmp(&y);
            }
            (a_rest, b_rest) = (&a_rest[x.len_utf8()..], &b_rest[y.len_utf8()..]);
        }
    }
}

/// The digits at the beginning of `text` without leading zeros, and what follows them.
fn split_digits(text: &str) -> (&str, &str) {
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (digits, after) = text.split_at(end);
    (digits.trim_start_matches('0'), after)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_digits_are_the_number() {
        assert_eq!(frame_number("0060"), Ok(Some(60)));
        assert_eq!(frame_number("frame00158"), Ok(Some(158)));
        assert_eq!(frame_number("take2_007_left"), Ok(Some(7)));
        assert_eq!(frame_number("bild-ä12ö"), Ok(Some(12)));
        assert_eq!(frame_number("18446744073709551615"), Ok(Some(u64::MAX)));
        assert_eq!(frame_number("18446744073709551616"), Err("18446744073709551616"));
        assert_eq!(frame_number("left"), Ok(None));
        assert_eq!(frame_number(""), Ok(None));
    }

    #[test]
    fn names_are_ordered_by_the_value_of_their_digits() {
        let mut names = ["f10", "f9", "f09b", "f1", "e99", "f100", "f9a", "f", "ä2", "ä11"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["e99", "f", "f1", "f9", "f9a", "f09b", "f10", "f100", "ä2", "ä11"]);
        assert_eq!(natural_order("1305031102.75", "1305031103.05"), Ordering::Less);
        assert_eq!(natural_order("7", "07"), natural_order("07", "7").reverse());
        assert_ne!(natural_order("7", "07"), Ordering::Equal);
        assert_eq!(natural_order("7", "7"), Ordering::Equal);
    }
}
