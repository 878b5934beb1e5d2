//! Master and drives on one bus in simulated time.

use tetrad_core::arm::canopen::Frame;
use tetrad_core::arm::canopen::master::Master;
use tetrad_core::arm::port::PortStatus;
use tetrad_core::config::{CanopenConfig, PumaConfig};
use tetrad_fixtures::drive::{Drive, Status};

pub(crate) const PERIOD_US: u64 = 10_000;

/// Where the drives are at first, counts.
pub(crate) const START: [i32; 6] = [100, -200, 3_000, 0, 7, -12_345];

pub(crate) struct Bench {
    pub(crate) master: Master,
    pub(crate) drives: Vec<Drive>,
    pub(crate) now_us: u64,
    /// Whether frames get through, either way.
    pub(crate) cut: bool,
    /// Everything that the master sent.
    pub(crate) sent: Vec<Frame>,
}

impl Bench {
    pub(crate) fn new(config: &CanopenConfig) -> Self {
        let master = Master::new(config, &PumaConfig::default()).expect("a configuration");
        let drives = config.nodes.iter().zip(START).map(|(node, start)| Drive::new(*node, start)).collect();
        Self { master, drives, now_us: 0, cut: false, sent: Vec::new() }
    }

    /// Ready, with the default configuration.
    pub(crate) fn ready() -> Self {
        Self::ready_with(&CanopenConfig::default())
    }

    pub(crate) fn ready_with(config: &CanopenConfig) -> Self {
        let mut bench = Self::new(config);
        bench.master.enable();
        bench.until(PortStatus::Ready);
        bench
    }

    /// One cycle.
    pub(crate) fn step(&mut self) {
        self.now_us += PERIOD_US;
        let mut out = Vec::new();
        self.master.cycle(self.now_us, &mut out);
        self.sent.extend_from_slice(&out);
        let mut answers = Vec::new();
        for drive in &mut self.drives {
            for frame in out.iter().filter(|_| !self.cut) {
                drive.receive(frame, &mut answers);
            }
            drive.tick(self.now_us, &mut answers);
        }
        self.hear(&answers);
    }

    /// The master hears frames.
    pub(crate) fn hear(&mut self, frames: &[Frame]) {
        if !self.cut {
            // half a cycle later
            frames.iter().for_each(|frame| self.master.receive(self.now_us + PERIOD_US / 2, frame));
        }
    }

    pub(crate) fn steps(&mut self, cycles: usize) {
        (0..cycles).for_each(|_| self.step());
    }

    /// Until the master is in `status`, at most 10 s.
    pub(crate) fn until(&mut self, status: PortStatus) {
        for _ in 0..1_000 {
            if self.master.status() == status {
                return;
            }
            self.step();
        }
        panic!("{:?} and not {status:?}: {:?}", self.master.status(), self.master.cause());
    }

    /// Moves joint `joint` (from 0) by `counts` a cycle.
    pub(crate) fn drive_on(&mut self, joint: usize, counts: i32, cycles: usize) {
        for _ in 0..cycles {
            let mut targets = self.master.targets();
            targets[joint] += counts;
            self.master.set_point(targets);
            self.step();
        }
    }

    pub(crate) fn reason(&self) -> String {
        self.master.cause().map(|cause| cause.to_string()).unwrap_or_default()
    }

    /// Every drive but `except` is without torque or braking, and comes to rest.
    pub(crate) fn assert_others_stop(&mut self, except: Option<usize>) {
        self.steps(3);
        let others = |bench: &Self, check: &dyn Fn(&Drive) -> bool| {
            let mut others = bench.drives.iter().enumerate().filter(|(joint, _)| Some(*joint) != except);
            others.all(|(_, drive)| check(drive))
        };
        assert!(others(self, &|drive| drive.status != Status::OperationEnabled), "{}", self.reason());
        assert!(others(self, &|drive| drive.history.contains(&Status::QuickStop)), "no quick stop");
        self.steps(40);
        assert!(others(self, &Drive::rests));
    }
}
