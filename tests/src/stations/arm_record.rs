//! What the arm did, from the slave's arm.csv.

use std::path::Path;

/// The slave's cycles, in order.
#[derive(Clone, Debug)]
pub(super) struct ArmRecord(Vec<Row>);

/// One cycle of the slave.
#[derive(Clone, Debug)]
struct Row {
    /// Seconds.
    t_s: f64,
    /// The law's state.
    state: String,
    /// How old the newest command was, ms.
    age_ms: Option<f64>,
    /// Where the tool was sent, metres.
    tool_m: Option<[f64; 3]>,
}

/// How often the arm stopped following.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stops {
    pub(super) count: usize,
    /// The longest from the coming of the last command that was fresh to the first cycle that did not
    /// follow it, ms, by the slave's clock.
    pub(super) latest_ms: f64,
    /// The most that a cycle which began a stop came late, ms: a process that got no processor.
    pub(super) late_ms: f64,
}

/// How often the arm held for want of fresh commands, and why.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Holds {
    pub(super) count: usize,
    /// Those before which the slave's own cycles did not come: it got no processor.
    pub(super) starved: usize,
}

/// The cycle of the slave that is run here, seconds.
const CYCLE_S: f64 = 0.001;

/// The same in ms.
const CYCLE_MS: f64 = CYCLE_S * 1e3;

/// So long nothing fresh came before a hold, seconds.
const STALE_S: f64 = 0.1;

/// A slave whose cycles are missing for half of that time did not hear what came either.
const STARVED_S: f64 = STALE_S / 2.0;

/// Reads it. A line that was being written when the slave was killed is left out.
///
/// # Errors
/// What the file lacks.
pub(super) fn read(out: &Path) -> Result<ArmRecord, String> {
    let file = out.join("arm.csv");
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let mut lines = text.split_inclusive('\n').filter_map(|line| line.strip_suffix('\n'));
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = |name: &str| {
        let at = header.iter().position(|column| *column == name);
        at.ok_or_else(|| format!("{}: there is no column {name}", file.display()))
    };
    let (t, state, age) = (column("t")?, column("state")?, column("age_ms")?);
    let tool = [column("x")?, column("y")?, column("z")?];
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |at: usize| fields.get(at).and_then(|field| field.parse::<f64>().ok());
        let [x, y, z] = tool.map(number);
        Some(Row {
            t_s: number(t)?,
            state: (*fields.get(state)?).to_owned(),
            age_ms: number(age),
            tool_m: x.zip(y).zip(z).map(|((x, y), z)| [x, y, z]),
        })
    };
    Ok(ArmRecord(lines.filter_map(row).collect()))
}

impl ArmRecord {
    /// How far the tool was sent in all.
    pub(super) fn way_m(&self) -> f64 {
        let places: Vec<_> = self.0.iter().filter_map(|row| row.tool_m).collect();
        places.windows(2).map(|pair| apart(pair[0], pair[1])).sum()
    }

    /// The fastest the tool was sent from one cycle to the next.
    pub(super) fn fastest_m_s(&self) -> f64 {
        let speed = |pair: &[Row]| {
            let dt = pair[1].t_s - pair[0].t_s;
            // cycles that follow a late one come close to it, and have a whole step all the same
            Some(apart(pair[0].tool_m?, pair[1].tool_m?) / dt.max(CYCLE_S))
        };
        self.0.windows(2).filter_map(speed).fold(0.0, f64::max)
    }

    /// Whether the hand was ever followed.
    pub(super) fn followed(&self) -> bool {
        self.0.iter().any(|row| row.state == "engaged" && row.age_ms.is_some())
    }

    /// Each first cycle of a hold, and what it is explained by.
    pub(super) fn holds(&self) -> Holds {
        let mut holds = Holds::default();
        for at in self.left().filter(|at| self.0[*at].state == "hold") {
            holds.count += 1;
            holds.starved += usize::from(self.missed_s(at) >= STARVED_S);
        }
        holds
    }

    /// How long cycles were missing within the time of a command before this one, seconds.
    fn missed_s(&self, at: usize) -> f64 {
        let since_s = self.0[at].t_s - STALE_S;
        let pairs = self.0[..=at].windows(2).rev().take_while(|pair| pair[1].t_s >= since_s);
        pairs.map(|pair| (pair[1].t_s - pair[0].t_s.max(since_s) - CYCLE_S).max(0.0)).sum()
    }

    pub(super) fn stops(&self) -> Stops {
        let mut stops = Stops::default();
        for at in self.left() {
            let Some(age_ms) = self.0[at].age_ms else { continue };
            // both ages are counted at the cycle's own beginning; they differ by a cycle where it is in time
            let before_ms = self.0[at - 1].age_ms.unwrap_or(age_ms);
            let late_ms = (age_ms - before_ms - CYCLE_MS).max(0.0);
            stops.count += 1;
            stops.latest_ms = stops.latest_ms.max(age_ms);
            stops.late_ms = stops.late_ms.max(late_ms);
        }
        stops
    }

    /// Each first cycle in which the hand is not followed any more.
    fn left(&self) -> impl Iterator<Item = usize> {
        let left = |at: &usize| self.0[at - 1].state == "engaged" && self.0[*at].state != "engaged";
        (1..self.0.len()).filter(left)
    }
}

/// The way from one place to another, metres.
fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cycles at these times, ms, each with its state and its command's age.
    fn cycles(rows: &[(f64, &str, f64)]) -> ArmRecord {
        let row = |(t_ms, state, age_ms): &(f64, &str, f64)| Row {
            t_s: t_ms / 1e3,
            state: (*state).to_owned(),
            age_ms: Some(*age_ms),
            tool_m: None,
        };
        ArmRecord(rows.iter().map(row).collect())
    }

    #[test]
    fn a_stop_is_counted_whole_and_what_its_cycle_was_late_beside_it() {
        let stops = cycles(&[(0.0, "engaged", 98.5), (7.5, "hold", 106.0)]).stops();
        assert_eq!((stops.count, [stops.latest_ms, stops.late_ms]), (1, [106.0, 6.5]));
        // the law itself is late
        let stops = cycles(&[(0.0, "engaged", 103.0), (1.0, "hold", 104.0)]).stops();
        assert_eq!([stops.latest_ms, stops.late_ms], [104.0, 0.0]);
    }

    #[test]
    fn a_hold_is_explained_where_cycles_were_missing() {
        let mut rows: Vec<_> = (0..150).map(|ms| (f64::from(ms), "engaged", f64::from(ms))).collect();
        rows.push((150.0, "hold", 100.0));
        assert_eq!(cycles(&rows).holds(), Holds { count: 1, starved: 0 });
        // what was missing long before is no reason
        rows.drain(1..40);
        assert_eq!(cycles(&rows).holds(), Holds { count: 1, starved: 0 });
        rows.drain(20..80);
        assert_eq!(cycles(&rows).holds(), Holds { count: 1, starved: 1 });
    }

    #[test]
    fn stops_holds_and_the_way_are_told() {
        let row = |(cycle, state, age_ms, x_m): (u32, &str, f64, f64)| Row {
            t_s: f64::from(cycle) * CYCLE_S,
            state: state.to_owned(),
            age_ms: Some(age_ms),
            tool_m: Some([x_m, 0.0, 0.0]),
        };
        let record = ArmRecord(
            [
                (0, "armed", 1.0, 0.0),
                (1, "engaged", 2.0, 0.0),
                (2, "engaged", 99.0, 0.0004),
                (3, "hold", 99.5, 0.0005),
                (4, "engaged", 1.0, 0.0006),
                (5, "armed", 7.0, 0.0006),
            ]
            .map(row)
            .into(),
        );
        let stops = record.stops();
        assert_eq!((stops.count, record.holds().count, record.followed()), (2, 1, true));
        assert!((stops.latest_ms - 99.5).abs() < 1e-9);
        assert!((record.way_m() - 0.0006).abs() < 1e-9 && (record.fastest_m_s() - 0.4).abs() < 1e-6);
    }
}
