//! Promise: a change of the pose filter shows. Noise at rest and lag in motion of its settings, on a
//! simulated hand, are compared with tests/snapshots/filter.txt.
//!
//! `TETRAD_BLESS=1 cargo test -p tetrad-tests --test filter` rewrites it: read the difference.

use std::fmt::Write as _;
use tetrad::filter_quality::{SimulatedHand, measure};
use tetrad_core::config::{FilterConfig, Prediction, Smoothing};
use tetrad_fixtures::golden;

const LEADS_MS: [u32; 4] = [0, 33, 50, 100];
const MEMORIES_MS: [u32; 3] = [25, 50, 100];

fn row(name: &str, config: &FilterConfig) -> Result<String, Box<dyn std::error::Error>> {
    let quality = measure(config, &SimulatedHand::default())?;
    let (rest, moving) = (quality.rest_out, quality.moving);
    Ok(format!(
        "{name:<8} {:<12} {:>4} {:>6} | {:>5.2} {:>5.2} | {:>5.1} {:>5.1} {:>6.2} {:>6.2}",
        format!("{:?}", config.prediction).to_lowercase(),
        config.lead_us / 1000,
        config.memory_us / 1000,
        rest.place_m / quality.rest_in.place_m,
        rest.turn_rad / quality.rest_in.turn_rad,
        moving.lag_s * 1e3,
        moving.turn_lag_s * 1e3,
        moving.error_m * 1e3,
        moving.error_rad.to_degrees()
    ))
}

#[test]
fn noise_and_lag_of_the_settings() -> Result<(), Box<dyn std::error::Error>> {
    let mut table = String::from(
        "# A simulated hand at 30 frames/s, measured with 0.5 mm and 5 mrad of noise on each axis. Rest: what is\n\
         # left of the noise. Moving: round a circle of 0.1 m at 0.5 m/s, turning at 1 rad/s; error\n\
         # (root mean square) and lag against the truth `lead` later.\n\
         #                      lead memory |    rest     |  lag    lag  error  error\n\
         # smoothing prediction   ms     ms | place  turn | place  turn  mm     deg\n",
    );
    for (name, smoothing) in [("one-euro", FilterConfig::default().smoothing), ("off", Smoothing::Off)] {
        for prediction in [Prediction::Velocity, Prediction::Acceleration] {
            let config = FilterConfig { smoothing, prediction, ..FilterConfig::default() };
            for lead_ms in LEADS_MS {
                writeln!(table, "{}", row(name, &FilterConfig { lead_us: lead_ms * 1000, ..config })?)?;
            }
            for memory_us in MEMORIES_MS.map(|ms| ms * 1000).into_iter().filter(|&us| us != config.memory_us)
            {
                writeln!(table, "{}", row(name, &FilterConfig { lead_us: 50_000, memory_us, ..config })?)?;
            }
        }
    }
    golden::check_file(&tetrad_tests::repository().join("tests/snapshots/filter.txt"), table.as_bytes())?;
    Ok(())
}
