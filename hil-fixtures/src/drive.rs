//! A CiA 402 drive written from the standards, not from the master: an object dictionary, an SDO
//! server, PDOs as they are mapped, the state machine, heartbeats both ways. It knows no clock.

use std::collections::BTreeMap;
use tetrad_core::arm::canopen::Frame;

/// Bits of the statusword, without those that say nothing of the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// No voltage may be put on the motor.
    SwitchOnDisabled = 0x40,
    /// Voltage may be put on.
    ReadyToSwitchOn = 0x21,
    /// Voltage is on, without torque.
    SwitchedOn = 0x23,
    /// It follows its targets.
    OperationEnabled = 0x27,
    /// It brakes, or has braked.
    QuickStop = 0x07,
    /// A fault waits to be reset.
    Fault = 0x08,
}

/// A node's states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nmt {
    /// SDOs alone.
    PreOperational = 0x7F,
    /// PDOs and SDOs.
    Operational = 0x05,
    /// Neither.
    Stopped = 0x04,
}

/// What a drive can be made to do wrong.
#[derive(Clone, Debug, Default)]
pub struct Faults {
    /// It neither hears nor says anything: no power.
    pub dead: bool,
    /// It says nothing but hears.
    pub mute: bool,
    /// A fault whose cause is not gone: it cannot be reset.
    pub lasting: bool,
    /// The emergency stop: voltage may not be put on.
    pub safe_torque_off: bool,
    /// What its TPDOs hold in place of what is true.
    pub nonsense: Option<Vec<u8>>,
    /// Objects that it does not have.
    pub lacking: Vec<u16>,
    /// Objects that it does not let be written.
    pub refusing: Vec<u16>,
}

/// A drive, and the axis that it turns.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Its node number.
    pub node: u8,
    /// Its state as a node.
    pub nmt: Nmt,
    /// Its state as a drive.
    pub status: Status,
    /// Bits of the statusword beyond the state.
    pub more_status: u16,
    /// What it does wrong.
    pub faults: Faults,
    /// The target at each SYNC in operation enabled.
    pub targets: Vec<i32>,
    /// Every state it has been in.
    pub history: Vec<Status>,
    /// How it came to brake last: told to, or by itself for want of the master's heartbeat.
    pub lost_master: bool,
    objects: BTreeMap<(u16, u8), (u32, u8)>,
    control: u16,
    buffered: Option<Vec<u8>>,
    /// Counts a SYNC; halves itself while braking.
    velocity: i32,
    heartbeat_us: u64,
    heard_master_us: Option<u64>,
    now_us: u64,
}

impl Drive {
    /// A drive that was switched on, its axis at rest at `position` counts.
    #[must_use]
    pub fn new(node: u8, position: i32) -> Self {
        let n = u32::from(node);
        let objects = BTreeMap::from([
            ((0x1000, 0), (0x0002_0192, 4)),
            ((0x1001, 0), (0, 1)),
            ((0x1006, 0), (0, 4)),
            ((0x1016, 0), (1, 1)),
            ((0x1016, 1), (0, 4)),
            ((0x1017, 0), (0, 2)),
            ((0x1018, 0), (1, 1)),
            ((0x1018, 1), (0x1F, 4)),
            ((0x1400, 0), (2, 1)),
            ((0x1400, 1), (0x200 + n, 4)),
            ((0x1400, 2), (255, 1)),
            ((0x1600, 0), (1, 1)),
            ((0x1600, 1), (0x6040_0010, 4)),
            ((0x1600, 2), (0, 4)),
            ((0x1800, 0), (2, 1)),
            ((0x1800, 1), (0x4000_0180 + n, 4)),
            ((0x1800, 2), (255, 1)),
            ((0x1A00, 0), (1, 1)),
            ((0x1A00, 1), (0x6041_0010, 4)),
            ((0x1A00, 2), (0, 4)),
            ((0x1801, 1), (0x4000_0280 + n, 4)),
            ((0x603F, 0), (0, 2)),
            ((0x6040, 0), (0, 2)),
            ((0x6041, 0), (0x40, 2)),
            ((0x6007, 0), (1, 2)),
            ((0x6060, 0), (1, 1)),
            ((0x6061, 0), (1, 1)),
            ((0x6064, 0), (position.cast_unsigned(), 4)),
            ((0x607A, 0), (0, 4)),
            ((0x60C2, 1), (1, 1)),
            ((0x60C2, 2), (0xFD, 1)),
            ((0x6502, 0), (0x81, 4)),
        ]);
        Self {
            node,
            nmt: Nmt::PreOperational,
            status: Status::SwitchOnDisabled,
            more_status: 0x0200,
            faults: Faults::default(),
            targets: Vec::new(),
            history: vec![Status::SwitchOnDisabled],
            lost_master: false,
            objects,
            control: 0,
            buffered: None,
            velocity: 0,
            heartbeat_us: 0,
            heard_master_us: None,
            now_us: 0,
        }
    }

    /// The value of an object, as its bits; 0 where there is no such object.
    #[must_use]
    pub fn get(&self, index: u16, sub: u8) -> u32 {
        self.objects.get(&(index, sub)).map_or(0, |(value, _)| *value)
    }

    /// Sets an object.
    ///
    /// # Panics
    /// When there is no such object.
    pub fn set(&mut self, index: u16, sub: u8, value: u32) {
        let object = self.objects.get_mut(&(index, sub)).expect("an object of the drive");
        object.0 = value;
    }

    /// Where the axis is, counts.
    #[must_use]
    pub fn position(&self) -> i32 {
        self.get(0x6064, 0).cast_signed()
    }

    /// Whether the axis is at rest.
    #[must_use]
    pub fn rests(&self) -> bool {
        self.velocity == 0
    }

    /// A fault happens: the drive brakes, and tells its code.
    pub fn fail(&mut self, code: u16, out: &mut Vec<Frame>) {
        self.set(0x603F, 0, u32::from(code));
        self.go(Status::Fault);
        let [low, high] = code.to_le_bytes();
        self.say(out, 0x080, &[low, high, 0x01, 0, 0, 0, 0, 0]);
    }

    /// It is switched off and on.
    pub fn restart(&mut self, out: &mut Vec<Frame>) {
        let position = self.position();
        let node = self.node;
        *self = Self { now_us: self.now_us, ..Self::new(node, position) };
        self.say(out, 0x700, &[0]);
    }

    fn go(&mut self, status: Status) {
        if self.status != status {
            self.status = status;
            self.history.push(status);
        }
    }

    fn say(&self, out: &mut Vec<Frame>, function: u16, data: &[u8]) {
        if !self.faults.dead && !self.faults.mute {
            out.push(Frame::new(function + u16::from(self.node), data).expect("a frame"));
        }
    }

    /// Time passes: heartbeats, and the watch on the master's.
    pub fn tick(&mut self, now_us: u64, out: &mut Vec<Frame>) {
        self.now_us = now_us;
        if self.faults.dead {
            return;
        }
        let every_us = u64::from(self.get(0x1017, 0)) * 1_000;
        if every_us > 0 && now_us >= self.heartbeat_us + every_us {
            self.heartbeat_us = now_us;
            self.say(out, 0x700, &[self.nmt as u8]);
        }
        let within_us = u64::from(self.get(0x1016, 1) & 0xFFFF) * 1_000;
        let late = self.heard_master_us.is_some_and(|at| now_us > at + within_us);
        if within_us > 0 && late && self.status == Status::OperationEnabled && self.get(0x6007, 0) == 3 {
            self.lost_master = true;
            self.go(Status::QuickStop);
        }
        if self.status != Status::OperationEnabled {
            // it brakes by itself, SYNC or not
            self.velocity /= 2;
            self.set(0x6064, 0, (self.position() + self.velocity).cast_unsigned());
        }
        if self.faults.safe_torque_off && !matches!(self.status, Status::Fault) {
            self.go(Status::SwitchOnDisabled);
        }
    }

    /// Takes a frame from the bus, whoever it is for.
    pub fn receive(&mut self, frame: &Frame, out: &mut Vec<Frame>) {
        if self.faults.dead {
            return;
        }
        let node = u16::from(self.node);
        let master = self.get(0x1016, 1) >> 16;
        match (frame.id(), frame.data()) {
            (0x000, &[command, to]) if to == 0 || to == self.node => match command {
                0x01 => self.nmt = Nmt::Operational,
                0x02 => self.nmt = Nmt::Stopped,
                0x80 => self.nmt = Nmt::PreOperational,
                _ => {}
            },
            (0x080, _) if self.nmt == Nmt::Operational => self.sync(out),
            (id, data) if id == 0x600 + node && self.nmt != Nmt::Stopped => {
                let answer = self.sdo(data);
                self.say(out, 0x580, &answer);
            }
            (id, data) if self.nmt == Nmt::Operational && u32::from(id) == self.get(0x1400, 1) => {
                self.buffered = Some(data.to_vec());
                if self.get(0x1400, 2) >= 254 {
                    self.take_rpdo();
                }
            }
            (id, _) if master != 0 && u32::from(id) == 0x700 + master => {
                self.heard_master_us = Some(self.now_us);
            }
            _ => {}
        }
    }

    fn sync(&mut self, out: &mut Vec<Frame>) {
        self.take_rpdo();
        self.act();
        let data = match &self.faults.nonsense {
            Some(data) => data.clone(),
            None => self.mapped(),
        };
        if self.get(0x1800, 1) >> 31 == 0 {
            self.say(out, 0x180, &data);
        }
    }

    /// What TPDO1 holds, by its mapping.
    fn mapped(&mut self) -> Vec<u8> {
        self.set(0x6041, 0, u32::from(self.status as u16 | self.more_status));
        let count = self.get(0x1A00, 0) as u8;
        let mut data = Vec::new();
        for entry in 1..=count {
            let map = self.get(0x1A00, entry);
            let value = self.get((map >> 16) as u16, (map >> 8) as u8);
            data.extend_from_slice(&value.to_le_bytes()[..(map as u8 / 8) as usize]);
        }
        data
    }

    fn take_rpdo(&mut self) {
        let Some(data) = self.buffered.take() else { return };
        let mut rest = &data[..];
        for entry in 1..=self.get(0x1600, 0) as u8 {
            let map = self.get(0x1600, entry);
            let (bytes, after) = rest.split_at((map as u8 / 8) as usize);
            let value = bytes.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte));
            self.set((map >> 16) as u16, (map >> 8) as u8, value);
            rest = after;
        }
        if self.get(0x1400, 2) >= 254 {
            self.act();
        }
    }

    /// The state machine of CiA 402, then the axis.
    fn act(&mut self) {
        let word = self.get(0x6040, 0) as u16;
        let risen = word & !self.control & 0x80 != 0;
        self.control = word;
        let (shutdown, switch_on, enable) = (word & 0x87 == 0x06, word & 0x8F == 0x07, word & 0x8F == 0x0F);
        let (no_voltage, quick_stop) = (word & 0x82 == 0, word & 0x86 == 0x02);
        let next = match self.status {
            Status::Fault if risen && !self.faults.lasting => {
                self.set(0x603F, 0, 0);
                Status::SwitchOnDisabled
            }
            Status::Fault => Status::Fault,
            _ if self.faults.safe_torque_off => Status::SwitchOnDisabled,
            Status::QuickStop if no_voltage => Status::SwitchOnDisabled,
            // quick stop option 2: at rest it switches off
            Status::QuickStop if self.velocity == 0 => Status::SwitchOnDisabled,
            Status::QuickStop => Status::QuickStop,
            _ if no_voltage => Status::SwitchOnDisabled,
            Status::OperationEnabled if quick_stop => Status::QuickStop,
            _ if quick_stop => Status::SwitchOnDisabled,
            Status::SwitchOnDisabled if shutdown => Status::ReadyToSwitchOn,
            Status::ReadyToSwitchOn if switch_on || enable => Status::SwitchedOn,
            Status::SwitchedOn if enable => Status::OperationEnabled,
            Status::SwitchedOn | Status::OperationEnabled if shutdown => Status::ReadyToSwitchOn,
            Status::OperationEnabled if switch_on => Status::SwitchedOn,
            status => status,
        };
        self.go(next);
        if self.status == Status::OperationEnabled && self.get(0x6061, 0) == 8 {
            let target = self.get(0x607A, 0).cast_signed();
            self.targets.push(target);
            self.velocity = target - self.position();
            self.set(0x6064, 0, target.cast_unsigned());
        }
    }

    fn sdo(&mut self, data: &[u8]) -> [u8; 8] {
        let &[command, low, high, sub, a, b, c, d] = data else { return [0; 8] };
        let index = u16::from_le_bytes([low, high]);
        let abort = |code: u32| {
            let [a, b, c, d] = code.to_le_bytes();
            [0x80, low, high, sub, a, b, c, d]
        };
        if self.faults.lacking.contains(&index) {
            return abort(0x0602_0000);
        }
        let Some(&(value, bytes)) = self.objects.get(&(index, sub)) else {
            let known = self.objects.range((index, 0)..=(index, 0xFF)).next().is_some();
            return abort(if known { 0x0609_0011 } else { 0x0602_0000 });
        };
        if command >> 5 == 2 {
            let value =
                if index == 0x6041 { u32::from(self.status as u16 | self.more_status) } else { value };
            let [a, b, c, d] = value.to_le_bytes();
            return [0x43 | (4 - bytes) << 2, low, high, sub, a, b, c, d];
        }
        if command & 0xE3 != 0x23 {
            return abort(0x0504_0001);
        }
        if self.faults.refusing.contains(&index) {
            return abort(0x0800_0022);
        }
        if 4 - (command >> 2 & 3) != bytes {
            return abort(0x0607_0010);
        }
        if let Some(code) = self.misuse(index, sub) {
            return abort(code);
        }
        self.set(index, sub, u32::from_le_bytes([a, b, c, d]));
        if index == 0x6060 {
            self.set(0x6061, 0, u32::from(a));
        }
        [0x60, low, high, sub, 0, 0, 0, 0]
    }

    /// What CiA 301 forbids: to map while the PDO exists or is counted.
    fn misuse(&self, index: u16, sub: u8) -> Option<u32> {
        let exists = |communication| self.get(communication, 1) >> 31 == 0;
        match index {
            0x1000 | 0x6041 | 0x6061 | 0x6064 => Some(0x0601_0002),
            0x1600 | 0x1A00 if exists(index - 0x200) => Some(0x0800_0022),
            0x1600 | 0x1A00 if sub > 0 && self.get(index, 0) != 0 => Some(0x0800_0022),
            _ => None,
        }
    }
}
