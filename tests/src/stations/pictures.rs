//! When the operator had pictures of the hand, from its pose.csv.

use std::path::Path;

/// How often two instants that follow each other were so far apart or farther, seconds.
///
/// # Errors
/// What the file lacks.
pub(super) fn pauses(out: &Path, apart_s: f64) -> Result<usize, String> {
    let file = out.join("pose.csv");
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    pauses_in(&text, apart_s).ok_or_else(|| format!("{}: there is no column t", file.display()))
}

fn pauses_in(text: &str, apart_s: f64) -> Option<usize> {
    let mut lines = text.lines();
    let at = lines.next()?.split(',').position(|column| column == "t")?;
    let times: Vec<f64> = lines.filter_map(|line| line.split(',').nth(at)?.parse().ok()).collect();
    Some(times.windows(2).filter(|pair| pair[1] - pair[0] >= apart_s).count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_long_pauses_count() {
        let text = "frame,t,x\n0,1.000000,0\n1,1.016667,0\n2,1.116667,0\n3,1.190000,0\n";
        assert_eq!(pauses_in(text, 0.08), Some(1));
        assert_eq!(pauses_in("frame,x\n", 0.08), None);
    }
}
