//! The port: what the slave station holds.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use tetrad_core::arm::port::{JointReading, PortError, PortStatus, RobotPort};
use tetrad_core::arm::puma560::Joints;
use tetrad_core::config::{PumaConfig, PumaConfigError};

use crate::robot::Robot;

use super::dialogue::Dialogue;
use super::line::{Line, Log};
use super::pace::Moves;
use super::settings::{Dialect, Val2AddressError, Val2Config, parse};
use super::worker::{Shared, Worker};

/// Why a port could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum Val2OpenError {
    /// The address is wrong.
    #[error(transparent)]
    Address(#[from] Val2AddressError),
    /// The arm's settings are.
    #[error(transparent)]
    Arm(#[from] PumaConfigError),
    /// The serial port.
    #[error("{device}: {source}; `tetrad devices` lists serial ports, and another program may have this one")]
    Device {
        /// Its path.
        device: String,
        /// What the system says.
        source: serialport::Error,
    },
    /// The log.
    #[error("{}: the log cannot be written: {source}", path.display())]
    Log {
        /// Its path.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// No thread for the line.
    #[error("no thread could be started for the arm's line: {0}")]
    Thread(io::Error),
}

/// An arm at a VAL II terminal. See the [module's text](super).
pub struct Val2Port {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    device: String,
    config: Val2Config,
}

/// Opens `val2:DEVICE?name=value&...`; what the address does not set is as in `config`. The
/// controller is not spoken to before [`RobotPort::enable`].
///
/// # Errors
/// [`Val2OpenError`].
pub fn open(address: &str, arm: &PumaConfig, config: &Val2Config) -> Result<Val2Port, Val2OpenError> {
    let (device, config) = parse(address, config)?;
    arm.check()?;
    let line = Line::open(&device, config.baud)
        .map_err(|source| Val2OpenError::Device { device: device.clone(), source })?;
    let log = match &config.log {
        Some(path) => {
            Some(Log::open(path).map_err(|source| Val2OpenError::Log { path: path.clone(), source })?)
        }
        None => None,
    };
    let shared = Shared::new(Dialogue::new(&config, arm));
    let worker = Worker {
        shared: Arc::clone(&shared),
        device: device.clone(),
        baud: config.baud,
        line: Some(line),
        log,
    };
    let thread = thread::Builder::new()
        .name("val2".to_owned())
        .spawn(|| worker.run())
        .map_err(Val2OpenError::Thread)?;
    Ok(Val2Port { shared, thread: Some(thread), device, config })
}

impl Val2Port {
    /// What a user has to know before this arm moves, in plain words.
    #[must_use]
    pub fn notice(&self) -> String {
        let Val2Config { baud, speed, dialect, .. } = &self.config;
        // characters of one point as they pass the line, ten bits each: what is sent, and what the
        // controller prints between; what it takes to think comes on top
        let (name, characters) = match dialect {
            Dialect::Point => ("point", 300),
            Dialect::PPoint => ("ppoint", 100),
        };
        let most = f64::from(*baud) / 10.0 / f64::from(characters);
        format!(
            "VAL II at {}: the arm follows slowly. At {baud} baud with dialect={name} it takes about {most:.0} \
             points a second at best and makes a move of its own of each; set-points between are left out. \
             It goes at SPEED {speed}, and the slave keeps below that share of the joints' top speeds. A stop \
             waits for the move under way: \
             keep the arm's emergency stop at hand.",
            self.device
        )
    }

    /// Why the arm stands as it does and what would mend it, where the status does not say it all; the
    /// controller's own words are quoted.
    #[must_use]
    pub fn reason(&self) -> Option<String> {
        if self.dead() {
            return Some("the thread of the arm's line has ended; open the port anew".to_owned());
        }
        self.shared.dialogue().reason()
    }

    /// The points the arm was moved to since the port was opened.
    #[must_use]
    pub fn moves(&self) -> Moves {
        self.shared.dialogue().moves()
    }

    fn dead(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }
}

impl RobotPort<f64> for Val2Port {
    fn read_joints(&mut self) -> Result<JointReading<f64>, PortError> {
        if self.dead() {
            return Err(PortError::Lost);
        }
        let now = self.shared.now();
        self.shared.dialogue().read_joints(now)
    }

    fn write_set_point(&mut self, joints: &Joints<f64>) -> Result<(), PortError> {
        if self.dead() {
            return Err(PortError::Lost);
        }
        let now = self.shared.now();
        self.shared.dialogue().write_set_point(joints, now)
    }

    fn enable(&mut self) -> Result<(), PortError> {
        if self.dead() {
            return Err(PortError::Lost);
        }
        self.shared.dialogue().enable();
        self.shared.begin();
        Ok(())
    }

    fn stop(&mut self) -> Result<(), PortError> {
        let mut dialogue = self.shared.dialogue();
        dialogue.stop();
        // nothing more is sent to an arm that is lost; but whether it stands cannot be known
        if dialogue.status() == PortStatus::Lost { Err(PortError::Lost) } else { Ok(()) }
    }

    fn status(&self) -> PortStatus {
        if self.dead() {
            return PortStatus::Lost;
        }
        self.shared.dialogue().status()
    }
}

impl Robot for Val2Port {
    fn reason(&self) -> Option<String> {
        Self::reason(self)
    }

    fn notice(&self) -> Option<String> {
        Some(Self::notice(self))
    }

    /// What SPEED leaves, and a tenth less: each move is accelerated and braked by itself.
    fn speed_share(&self) -> f64 {
        f64::from(self.config.speed) / 100.0 * 0.9
    }

    fn report(&self) -> Vec<String> {
        let moves = self.shared.dialogue().moves();
        let rate = moves.mean_period().map(|period| format!(", one every {} ms", period.as_millis()));
        vec![format!("val2: {} points moved to{}", moves.count(), rate.unwrap_or_default())]
    }
}

impl Drop for Val2Port {
    fn drop(&mut self) {
        self.shared.dialogue().stop();
        self.shared.quit();
        if let Some(thread) = self.thread.take() {
            // a thread that panicked has said so itself
            let _ = thread.join();
        }
    }
}
