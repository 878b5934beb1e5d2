//! What the simulated arm can be told behind `sim:?`.

use crate::robot::query::Query;
use std::ops::RangeInclusive;
use tetrad_core::arm::port::{JointNumber, PortFault};
use tetrad_core::arm::puma560::Joints;
use tetrad_core::config::JOINTS;

/// What a fault is called when nothing else is said: CiA 402's following error.
const FOLLOWING_ERROR: u32 = 0x8611;

/// How often set-points are expected where nothing else is said, microseconds.
const CYCLE_US: u64 = 10_000;

/// How long it goes without one where nothing else is said, microseconds.
const WATCHDOG_US: u64 = 100_000;

/// Lags that a servo may have, milliseconds. Computed by the millisecond, a quicker one would not be.
pub(super) const LAG_MS: RangeInclusive<f64> = 10.0..=500.0;

/// By how much joints may tremble, counts.
pub(super) const NOISE_COUNTS: RangeInclusive<f64> = 0.0..=100.0;

/// A fault that happens by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimedFault {
    /// Microseconds after the port was opened.
    pub at_us: u64,
    /// What is reported.
    pub fault: PortFault,
}

/// The options, each with its default.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedOptions {
    /// `seed=1`: what the noise comes from.
    pub seed: u64,
    /// `noise=0.5|off`: by how many counts the joints tremble, standard deviation.
    pub noise_counts: f64,
    /// `lag_ms=20`: how far the joints are behind in time.
    pub lag_s: f64,
    /// `cycle_ms=10`: how often set-points are expected; a joint can go no farther than that from one
    /// to the next. Where it is not given, as often as whoever opens the port says, or 10 ms.
    pub cycle_us: Option<u64>,
    /// `watchdog_ms=100`: without a set-point for longer, it stops.
    pub watchdog_us: u64,
    /// `enable_ms=500`: how long switching on takes.
    pub enable_us: u64,
    /// `start_deg=0,45,-180,0,45,0`: where the joints stand at first, radians here.
    pub start: Option<Joints<f64>>,
    /// `fault=JOINT@TIME` or `fault=JOINT:CODE@TIME`, such as `3@5s` or `3:0x8611@500ms`.
    pub fault: Option<TimedFault>,
    /// `silence=TIME`: when it stops answering, microseconds after it was opened.
    pub silence_us: Option<u64>,
}

impl Default for SimulatedOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            noise_counts: 0.5,
            lag_s: 0.02,
            cycle_us: None,
            watchdog_us: WATCHDOG_US,
            enable_us: 500_000,
            start: None,
            fault: None,
            silence_us: None,
        }
    }
}

impl SimulatedOptions {
    /// Joints that stand still unless they are moved: nothing trembles.
    #[must_use]
    pub fn without_noise() -> Self {
        Self { noise_counts: 0.0, ..Self::default() }
    }

    /// How often set-points are expected, microseconds.
    pub(super) fn cycle_us(&self) -> u64 {
        self.cycle_us.unwrap_or(CYCLE_US)
    }

    /// For whoever makes a set-point every `cycle_us`: that cycle, where none was given, and a watchdog
    /// that it does not wake.
    ///
    /// # Errors
    /// A sentence that names an option that does not go with that cycle.
    pub fn for_cycle(&self, cycle_us: u32) -> Result<Self, String> {
        let wanted = u64::from(cycle_us);
        let ms = wanted as f64 / 1e3;
        if let Some(given) = self.cycle_us
            && given < wanted
        {
            return Err(format!(
                "cycle_ms={}: set-points come every {ms} ms (cycle_ms of [governor]): leave it out, or give no less",
                given / 1000
            ));
        }
        let mut options = Self { cycle_us: Some(self.cycle_us.unwrap_or(wanted)), ..self.clone() };
        if self.watchdog_us == WATCHDOG_US {
            options.watchdog_us = WATCHDOG_US.max(2 * wanted);
        } else if self.watchdog_us <= wanted {
            return Err(format!(
                "watchdog_ms={}: set-points come every {ms} ms (cycle_ms of [governor]): leave it out, or give more",
                self.watchdog_us / 1000
            ));
        }
        Ok(options)
    }

    /// Reads what stands behind `sim:?`.
    ///
    /// # Errors
    /// A sentence that names the option.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut query = Query::parse(text)?;
        let mut options = Self::default();
        if let Some(seed) = query.number("seed", "", 0..=u64::MAX)? {
            options.seed = seed;
        }
        if let Some(noise) = query.take("noise") {
            options.noise_counts = match noise.parse() {
                _ if noise == "off" => 0.0,
                Ok(counts) if NOISE_COUNTS.contains(&counts) => counts,
                _ => {
                    return Err(format!("'noise={noise}': 'off' or a number from 0 to 100 counts is needed"));
                }
            };
        }
        if let Some(ms) = query.number("lag_ms", "ms", LAG_MS)? {
            options.lag_s = ms / 1000.0;
        }
        options.cycle_us = query.number("cycle_ms", "ms", 1..=1_000)?.map(|ms: u64| ms * 1000);
        for (key, range, value) in [
            ("watchdog_ms", 1..=60_000, &mut options.watchdog_us),
            ("enable_ms", 0..=60_000, &mut options.enable_us),
        ] {
            if let Some(ms) = query.number(key, "ms", range)? {
                *value = ms * 1000;
            }
        }
        if let Some(degrees) = query.take("start_deg") {
            options.start = Some(joints(degrees).ok_or_else(|| {
                format!("'start_deg={degrees}': six angles in degrees are needed, as in 0,45,-180,0,45,0")
            })?);
        }
        if let Some(fault) = query.take("fault") {
            options.fault = Some(timed_fault(fault).ok_or_else(|| {
                format!("'fault={fault}': a joint and a time are needed, as in 3@5s or 3:0x8611@500ms")
            })?);
        }
        if let Some(time) = query.take("silence") {
            let us = microseconds(time);
            options.silence_us =
                Some(us.ok_or_else(|| format!("'silence={time}': a time is needed, as in 5s or 500ms"))?);
        }
        query.finish()?;
        Ok(options)
    }
}

fn joints(text: &str) -> Option<Joints<f64>> {
    let angles: Option<Vec<f64>> = text
        .split(',')
        .map(|angle| angle.trim().parse().ok().filter(|angle: &f64| angle.is_finite()))
        .collect();
    let joints: Joints<f64> = angles?.try_into().ok()?;
    Some(joints.map(f64::to_radians))
}

fn timed_fault(text: &str) -> Option<TimedFault> {
    let (what, time) = text.split_once('@')?;
    let (joint, code) = match what.split_once(':') {
        Some((joint, code)) => (joint, number(code)?),
        None => (what, FOLLOWING_ERROR),
    };
    let joint: JointNumber = joint.parse().ok()?;
    let joint = Some(joint).filter(|joint| (1..=JOINTS).contains(&usize::from(*joint)));
    Some(TimedFault { at_us: microseconds(time)?, fault: PortFault { joint: Some(joint?), code } })
}

/// A whole number, decimal or with `0x` in front.
fn number(text: &str) -> Option<u32> {
    match text.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}

/// `5s` or `500ms`, at most an hour.
fn microseconds(text: &str) -> Option<u64> {
    let (digits, us) = match text.strip_suffix("ms") {
        Some(digits) => (digits, 1e3),
        None => (text.strip_suffix('s')?, 1e6),
    };
    let us = digits.parse::<f64>().ok()? * us;
    (0.0..=3.6e9).contains(&us).then_some(us.round() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_option_can_be_set() {
        let text = "seed=7&noise=off&lag_ms=30&cycle_ms=20&watchdog_ms=250&enable_ms=0\
                    &start_deg=0,45,-180,0,45,10&fault=3:0x2310@1.5s&silence=500ms";
        let options = SimulatedOptions::parse(text).unwrap();
        let expected = SimulatedOptions {
            seed: 7,
            noise_counts: 0.0,
            lag_s: 0.03,
            cycle_us: Some(20_000),
            watchdog_us: 250_000,
            enable_us: 0,
            start: Some([0.0, 45.0, -180.0, 0.0, 45.0, 10.0].map(f64::to_radians)),
            fault: Some(TimedFault { at_us: 1_500_000, fault: PortFault { joint: Some(3), code: 0x2310 } }),
            silence_us: Some(500_000),
        };
        assert_eq!(options, expected);
        assert_eq!(SimulatedOptions::parse(""), Ok(SimulatedOptions::default()));
        let fault = SimulatedOptions::parse("fault=6@0s").unwrap().fault.unwrap();
        assert_eq!(fault, TimedFault { at_us: 0, fault: PortFault { joint: Some(6), code: 0x8611 } });
    }

    #[test]
    fn set_points_of_any_cycle_are_expected_as_often_or_refused_by_option() {
        let parsed = |text| SimulatedOptions::parse(text).unwrap();
        let slow = parsed("").for_cycle(30_000).unwrap();
        assert_eq!((slow.cycle_us(), slow.watchdog_us), (30_000, 100_000));
        assert_eq!(parsed("").for_cycle(100_000).unwrap().watchdog_us, 200_000);
        // room to go farther than is asked is no contradiction
        assert_eq!(parsed("cycle_ms=40").for_cycle(30_000).unwrap().cycle_us(), 40_000);
        let refused = parsed("cycle_ms=10").for_cycle(30_000).unwrap_err();
        assert!(refused.starts_with("cycle_ms=10: set-points come every 30 ms"), "{refused}");
        let refused = parsed("watchdog_ms=20").for_cycle(30_000).unwrap_err();
        assert!(refused.starts_with("watchdog_ms=20: set-points come every 30 ms"), "{refused}");
    }

    #[test]
    fn what_is_wrong_is_named_with_what_would_do() {
        for (text, problem) in [
            (
                "sed=7",
                "'sed' means nothing here: the options are seed, noise, lag_ms, cycle_ms, watchdog_ms, enable_ms, start_deg, fault, silence",
            ),
            ("seed=-1", "'seed=-1': a number from 0 to 18446744073709551615 is needed"),
            ("noise=loud", "'noise=loud': 'off' or a number from 0 to 100 counts is needed"),
            ("lag_ms=0", "'lag_ms=0': a number from 10 to 500 ms is needed"),
            (
                "start_deg=1,2,3",
                "'start_deg=1,2,3': six angles in degrees are needed, as in 0,45,-180,0,45,0",
            ),
            ("fault=7@1s", "'fault=7@1s': a joint and a time are needed, as in 3@5s or 3:0x8611@500ms"),
            ("fault=3@5", "'fault=3@5': a joint and a time are needed, as in 3@5s or 3:0x8611@500ms"),
            ("silence=-1s", "'silence=-1s': a time is needed, as in 5s or 500ms"),
        ] {
            assert_eq!(SimulatedOptions::parse(text).unwrap_err(), problem);
        }
    }
}
