//! The arms that can be driven: what turns joint set-points into motion.
//!
//! | port | file | address |
//! |---|---|---|
//! | a PUMA 560 that is not there | [`simulated`] | `sim:` |
//! | nothing but a record | [`dry_run`] | `dry-run:FILE` |
//! | a PUMA's own controller, at its terminal | [`val2`] | `val2:DEVICE` |
//! | six CiA 402 drives on a CAN bus | [`canopen`] | `canopen:INTERFACE`, `canopen+slcan:DEVICE` |
//!
//! [`address`] understands the address, [`open`] opens the port. All of them keep the contract of
//! [`tetrad_core::arm::port`].

pub mod address;

pub mod clock;

pub mod lateness;

pub(crate) mod query;

mod serial;

pub(crate) mod start;

pub mod simulated;

pub mod dry_run;

pub mod val2;

pub mod canopen;

pub use address::{AddressError, RobotAddress, RobotKind};

use dry_run::DryRun;
use simulated::SimulatedArm;
use std::error::Error;
use std::time::Instant;
use tetrad_core::arm::port::{JointReading, PortError, PortStatus, RobotPort};
use tetrad_core::arm::puma560::Joints;
use tetrad_core::config::{CanopenConfig, PumaConfig, PumaConfigError};

/// A port as the host drives it: it can say more than the microcontroller's.
pub trait Robot: RobotPort<f64> + Send {
    /// Why it stands as it does, in words, beyond the status; `None` where the status says all.
    fn reason(&self) -> Option<String> {
        None
    }

    /// What the user is to know before this arm moves; `None` where there is nothing special.
    fn notice(&self) -> Option<String> {
        None
    }

    /// Waits until the next set-point is wanted: until `due`, or by the port's own beat where it has one,
    /// so that each of its cycles gets one set-point and none gets two.
    fn pace(&mut self, due: Instant) {
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
    }

    /// The share of the joints' speeds that set-points may use: less than 1 where the controller itself
    /// goes slower, so that the arm can follow.
    fn speed_share(&self) -> f64 {
        1.0
    }

    /// Somebody vouches for it that every joint is homed: for controllers that cannot tell by themselves.
    /// Without effect on others.
    fn confirm_homed(&mut self) {}

    /// Lines for the end of a run: rates, jitter.
    fn report(&self) -> Vec<String> {
        Vec::new()
    }
}

/// A slave drives whatever it is.
impl RobotPort<f64> for Box<dyn Robot> {
    fn read_joints(&mut self) -> Result<JointReading<f64>, PortError> {
        (**self).read_joints()
    }

    fn write_set_point(&mut self, joints: &Joints<f64>) -> Result<(), PortError> {
        (**self).write_set_point(joints)
    }

    fn enable(&mut self) -> Result<(), PortError> {
        (**self).enable()
    }

    fn stop(&mut self) -> Result<(), PortError> {
        (**self).stop()
    }

    fn status(&self) -> PortStatus {
        (**self).status()
    }
}

/// Why a port could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum RobotError {
    /// The arm's own settings cannot be worked with.
    #[error("the arm's settings cannot be worked with")]
    Config(#[from] PumaConfigError),
    /// The address can be read, but asks for what does not go with this arm.
    #[error("{address} does not go with this arm")]
    Option {
        /// The address.
        address: String,
        /// What is wrong, and what would mend it.
        #[source]
        cause: Box<dyn Error + Send + Sync>,
    },
    /// The file or device behind the address cannot be opened or does not answer.
    #[error("cannot open {address}")]
    Open {
        /// The address.
        address: String,
        /// What was met.
        #[source]
        cause: Box<dyn Error + Send + Sync>,
    },
}

/// Opens what is at the address, for this arm and a set-point every `cycle_us` microseconds. It is not
/// switched on by that. `canopen` is what is set about drives on a CAN bus, which has a cycle of its own.
///
/// # Errors
/// [`RobotError`].
pub fn open(
    address: &RobotAddress,
    puma: &PumaConfig,
    canopen: &CanopenConfig,
    cycle_us: u32,
) -> Result<Box<dyn Robot>, RobotError> {
    puma.check()?;
    let text = || address.to_string();
    match address.kind() {
        RobotKind::Simulated(options) => {
            let wrong = |cause| RobotError::Option { address: text(), cause };
            let options = options.for_cycle(cycle_us).map_err(|problem| wrong(problem.into()))?;
            let port = SimulatedArm::new(puma, &options).map_err(|error| wrong(error.into()))?;
            Ok(Box::new(port))
        }
        RobotKind::DryRun(file) => match DryRun::create(file, puma, cycle_us) {
            Ok(port) => Ok(Box::new(port)),
            Err(cause) => Err(RobotError::Open { address: text(), cause: cause.into() }),
        },
        RobotKind::Canopen(place) => match canopen::open(place, puma, canopen) {
            Ok(port) => Ok(Box::new(port)),
            Err(cause) => Err(RobotError::Open { address: text(), cause: cause.into() }),
        },
        RobotKind::Val2(place) => match val2::open(place, puma, &val2::Val2Config::default()) {
            Ok(port) => Ok(Box::new(port)),
            Err(cause) => Err(RobotError::Open { address: text(), cause: cause.into() }),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open_text(text: &str) -> Result<Box<dyn Robot>, RobotError> {
        open(&text.parse().unwrap(), &PumaConfig::default(), &CanopenConfig::default(), 10_000)
    }

    /// The fastest step of a cycle of 30 ms, at which a governor of that cycle makes set-points.
    #[test]
    fn set_points_of_the_cycle_that_was_told_are_taken() {
        let dir = tempfile::tempdir().unwrap();
        let puma = PumaConfig::default();
        let file = format!("dry-run:{}", dir.path().join("a.csv").display());
        for address in ["sim:?noise=off&enable_ms=0", &file] {
            let canopen = CanopenConfig::default();
            let mut arm = open(&address.parse().unwrap(), &puma, &canopen, 30_000).unwrap();
            arm.enable().unwrap();
            while arm.status() != PortStatus::Ready {
                std::thread::yield_now();
            }
            let mut joints = arm.read_joints().unwrap().joints;
            arm.write_set_point(&joints).unwrap();
            joints[0] += 0.9 * 0.03 * puma.joints[0].max_speed_rad_s;
            assert_eq!(arm.write_set_point(&joints), Ok(()), "{address}");
        }
    }

    #[test]
    fn a_cycle_that_contradicts_the_one_of_set_points_is_refused_before_anything_moves() {
        let puma = PumaConfig::default();
        let canopen = CanopenConfig::default();
        let refused = open(&"sim:?cycle_ms=10".parse().unwrap(), &puma, &canopen, 30_000);
        let Err(error) = refused else { panic!("opened") };
        let cause = error.source().unwrap().to_string();
        assert!(cause.starts_with("cycle_ms=10: set-points come every 30 ms"), "{cause}");
    }

    #[test]
    fn a_port_is_opened_switched_off() {
        let arm = open_text("sim:?noise=off").unwrap();
        assert_eq!((arm.status(), arm.reason()), (PortStatus::Disabled, None));
    }

    #[test]
    fn what_cannot_be_opened_says_why() {
        let Err(error) = open_text("sim:?start_deg=0,45,60,0,0,0") else { panic!("opened") };
        assert_eq!(error.to_string(), "sim:?start_deg=0,45,60,0,0,0 does not go with this arm");
        let cause = error.source().unwrap().to_string();
        assert_eq!(cause, "start_deg: joint 3 can be from -225.0 to 45.0 degrees");
        let Err(error) = open_text("dry-run:/nowhere/at/all.csv") else { panic!("opened") };
        assert_eq!(error.to_string(), "cannot open dry-run:/nowhere/at/all.csv");
        let cause = error.source().unwrap().to_string();
        assert_eq!(cause, "there is no folder /nowhere/at: make it first, or name a file elsewhere");
        let mut bad = PumaConfig::default();
        bad.lengths.forearm_m = 0.0;
        assert!(matches!(
            open(&"sim:".parse().unwrap(), &bad, &CanopenConfig::default(), 10_000),
            Err(RobotError::Config(_))
        ));
    }
}
