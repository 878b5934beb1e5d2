//! What the log says. Without the feature `defmt` there is none, and nothing of it is left in the program.

use tetrad_core::wire::NoticePacket;

/// A notice goes to the host.
#[cfg(feature = "defmt")]
pub(crate) fn notice(packet: &NoticePacket) {
    use tetrad_core::wire::Notice;
    match packet.notice {
        Notice::Done | Notice::Learnt { .. } => defmt::info!("{}", packet),
        Notice::SelfTestFailed => defmt::error!("{}", packet),
        _ => defmt::warn!("{}", packet),
    }
}

/// Nothing.
#[cfg(not(feature = "defmt"))]
pub(crate) fn notice(_: &NoticePacket) {}
