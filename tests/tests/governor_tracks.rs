//! Promise (issue 4, Shows 5 and 6): recorded motions are followed within every bound, and where they
//! end the arm ends, exactly.
//!
//! The tracks are motions of a tool at 30 frames a second that pass near and through singularities,
//! some of them faster than the arm may go: then it lags, and catches up.

use puma560::{apart, folders, tracks};
use tetrad_core::arm::governor::{Governed, Governor};
use tetrad_core::arm::puma560::{Joints, Puma560};
use tetrad_core::arm::teleop::Order;
use tetrad_core::config::{GovernorConfig, JOINTS, PumaConfig};
use tetrad_core::geometry::Pose;

mod puma560;

/// What was sent, and its differences.
struct Sent {
    config: GovernorConfig,
    arm: PumaConfig,
    angles: Joints<f64>,
    speeds: Joints<f64>,
    accelerations: Joints<f64>,
    most: [f64; 3],
}

impl Sent {
    fn take(&mut self, governed: &Governed<f64>) {
        let cycle = f64::from(self.config.cycle_us) * 1e-6;
        // rounding of angles near 4 rad, thrice differenced, is 1e-8 of the jerk's bound
        let exact = 1.0 + 1e-7;
        for i in 0..JOINTS {
            let angle = governed.set_point[i];
            let speed = (angle - self.angles[i]) / cycle;
            let acceleration = (speed - self.speeds[i]) / cycle;
            let jerk = (acceleration - self.accelerations[i]) / cycle;
            let joint = &self.arm.joints[i];
            let shares = [
                speed.abs() / (joint.max_speed_rad_s * self.config.speed_share),
                acceleration.abs() / self.config.max_acceleration_rad_s2[i],
                jerk.abs() / self.config.max_jerk_rad_s3[i],
            ];
            assert!(shares.iter().all(|share| *share <= exact), "joint {}: {shares:?}", i + 1);
            assert!(angle >= joint.min_rad && angle <= joint.max_rad, "joint {}: {angle}", i + 1);
            for (most, share) in self.most.iter_mut().zip(shares) {
                *most = most.max(share);
            }
            (self.angles[i], self.speeds[i], self.accelerations[i]) = (angle, speed, acceleration);
        }
    }
}

#[test]
fn the_tracks_end_where_they_were_commanded_to() {
    let mut arm_config = PumaConfig::bare();
    // what the tracks were recorded of had no ranges
    for joint in &mut arm_config.joints {
        (joint.min_rad, joint.max_rad) = (-6.2, 6.2);
    }
    let arm = Puma560::<f64>::new(&arm_config).expect("wide ranges");
    let mut config = GovernorConfig::default();
    config.workspace.min_m = [-1.0, -1.0, -0.3];
    config.workspace.max_m = [1.0, 1.0, 1.7];
    config.passages.elbow = true;
    config.passages.shoulder = true;
    for folder in folders("the_tracks_end_where_they_were_commanded_to") {
        let (mut worst, mut lag, mut passages, mut most) = (0.0f64, 0.0f64, 0, [0.0f64; 3]);
        for (name, track) in tracks(&folder) {
            // one frame in seven is lost, twenty in a row once, and two stops come in between
            let mut governor = Governor::new(&arm, &config).expect("checked");
            let start = track[0].1;
            governor.start(&start).unwrap_or_else(|e| panic!("{name}: {e}"));
            let zero = [0.0; JOINTS];
            let mut sent = Sent {
                config,
                arm: arm_config,
                angles: start,
                speeds: zero,
                accelerations: zero,
                most: [0.0; 3],
            };
            let mut order: Order<f64> = Order::Follow(track[0].0);
            for (frame, (pose, _)) in track.iter().enumerate() {
                let heard = frame % 7 != 3 && !(60..80).contains(&frame);
                if heard || frame + 1 == track.len() {
                    order = Order::Follow(*pose);
                }
                let stopped = matches!(frame, 30..34 | 100..104);
                for _ in 0..3 + usize::from(frame % 3 == 0) {
                    let governed = governor.step(if stopped { &Order::Stop } else { &order }, None);
                    sent.take(&governed);
                    passages += usize::from(governed.change.is_some());
                }
                lag = lag.max(place(governor.pose(), pose));
            }
            for _ in 0..1_500 {
                sent.take(&governor.step(&order, None));
            }
            let (goal, _) = track.last().expect("a track has steps");
            let off = apart(governor.pose(), goal);
            assert!(off < 1e-8, "{name}: {off:.1e} off at its end, {}", governor.step(&order, None).limits);
            worst = worst.max(off);
            for (most, share) in most.iter_mut().zip(sent.most) {
                *most = most.max(share);
            }
        }
        println!(
            "ends {worst:.1e} off, at most {:.0} mm behind on the way, {passages} passages, \
             shares of the bounds: speed {:.3}, acceleration {:.3}, jerk {:.3}",
            lag * 1e3,
            most[0],
            most[1],
            most[2],
        );
        assert!(passages >= 1 && most[2] > 0.9, "{passages} passages, {most:?}");
    }
}

fn place(a: &Pose<f64>, b: &Pose<f64>) -> f64 {
    (a.translation - b.translation).norm()
}
