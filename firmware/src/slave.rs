//! The slave: an operator's packets and the drives' frames in, set-points and the arm's state out.
//!
//! ```text
//! serial line ─bytes─► receive ──┐                            ┌─► packets ─► send ─frames─► serial line
//!                                ├─ inputs ─► drive (a cycle) ┤
//! CAN bus ─frames─► listen ──────┘                            └─► CAN bus
//! ```
//!
//! What it does is core's [`WiredSlave`]: the same packets and frames, to the byte, as a desktop makes of the
//! same.

use crate::can::Can;
use crate::handover::Packets;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use tetrad_core::arm::canopen::{Frame, Frames, slcan};
use tetrad_core::arm::wired::WiredSlave;
use tetrad_core::wire::{ArmStatePacket, Decoder, Packet};

/// Whatever comes to the slave, in the order in which it comes, with when by its clock, microseconds.
#[expect(clippy::large_enum_variant, reason = "there is no heap to box a packet on")]
pub enum SlaveInput {
    /// A packet of the serial line.
    Packet(Packet, u64),
    /// A frame of the bus.
    Frame(Frame, u64),
    /// A cycle is due.
    Cycle(u64),
    /// There is no more: a recording has been played.
    End,
}

/// What comes to the slave.
pub type SlaveInputs = Channel<CriticalSectionRawMutex, SlaveInput, 4>;

/// Takes bytes of both lines as they come, and hands on what is in them. Damaged packets and lines that hold
/// no frame are dropped: to the law they are silence.
#[derive(Default)]
pub struct Listener {
    line: Decoder,
    bus: slcan::Decoder,
}

impl Listener {
    /// Takes the next bytes of the serial line, which came at `now_us`.
    pub async fn line(&mut self, bytes: &[u8], now_us: u64, inputs: &SlaveInputs) {
        for byte in bytes {
            if let Some(Ok(packet)) = self.line.packets(core::slice::from_ref(byte)).next() {
                inputs.send(SlaveInput::Packet(packet, now_us)).await;
            }
        }
    }

    /// Takes the next bytes of a serial line that stands for the bus, which came at `now_us`.
    pub async fn bus(&mut self, bytes: &[u8], now_us: u64, inputs: &SlaveInputs) {
        for byte in bytes {
            if let Some(slcan::Line::Frame(frame)) = self.bus.push(*byte) {
                inputs.send(SlaveInput::Frame(frame, now_us)).await;
            }
        }
    }
}

/// Does what comes, in the order in which it comes; ends behind the last cycle of a recording.
///
/// `cycle` does a cycle of the slave: [`WiredSlave::cycle`], or that and a look at what it costs.
pub async fn drive(
    slave: &mut WiredSlave,
    inputs: &SlaveInputs,
    packets: &Packets,
    mut can: impl Can,
    mut cycle: impl FnMut(&mut WiredSlave, u64, &mut Frames) -> Option<ArmStatePacket>,
) {
    loop {
        match inputs.receive().await {
            SlaveInput::Packet(packet, now_us) => slave.take(&packet, now_us),
            SlaveInput::Frame(frame, now_us) => slave.hear(&frame, now_us),
            SlaveInput::Cycle(now_us) => {
                let mut frames = Frames::default();
                let state = cycle(slave, now_us, &mut frames);
                // set-points first: nobody waits for the state
                for frame in frames.as_slice() {
                    can.send(frame).await;
                }
                if let Some(state) = state {
                    packets.send(Some(state.into())).await;
                }
            }
            SlaveInput::End => {
                packets.send(None).await;
                return;
            }
        }
    }
}
