//! What a station asks of whatever carries its packets: the network, or a loopback with faults.

use super::inbox::{Inbox, Received};
use super::picture::Picture;
use tetrad_core::wire::{
    ArmStatePacket, ButtonsPacket, EncodeError, MotionPacket, ObservationPacket, Packet,
};

/// One end of a link to one peer. No call waits; of each kind only the newest counts.
pub trait Carrier {
    /// Hands over a packet. Where one of its kind has not gone yet, it goes in its place.
    ///
    /// # Errors
    /// [`EncodeError`] for a packet that may not be sent. That nobody is there to take it is none: it
    /// is dropped.
    fn send(&self, packet: &Packet) -> Result<(), EncodeError>;

    /// Looks into what came.
    fn with_inbox<R>(&self, look: impl FnOnce(&mut Inbox) -> R) -> R;

    /// The newest motion, if it was not taken yet.
    fn motion(&self) -> Option<Received<MotionPacket>> {
        self.with_inbox(Inbox::motion)
    }

    /// The newest state of the operator's buttons, if it was not taken yet.
    fn buttons(&self) -> Option<Received<ButtonsPacket>> {
        self.with_inbox(Inbox::buttons)
    }

    /// The newest state of the arm, if it was not taken yet.
    fn arm_state(&self) -> Option<Received<ArmStatePacket>> {
        self.with_inbox(Inbox::arm_state)
    }

    /// The newest observations of a camera, if they were not taken yet.
    fn observation(&self, camera: u8) -> Option<Received<ObservationPacket>> {
        self.with_inbox(|inbox| inbox.observation(camera))
    }

    /// Hands over a picture: where one of its camera waits, it goes in its place. One that is too long,
    /// or that nobody is there to take, is dropped.
    fn send_picture(&self, picture: Picture);

    /// The newest picture of a camera, if it was not taken yet.
    fn picture(&self, camera: u8) -> Option<Received<Picture>>;

    /// What the other end shall know from now on. What is too long is not told.
    fn tell_configuration(&self, configuration: &[u8]);

    /// What the other end wants this one to know, if it was not taken yet.
    fn configuration(&self) -> Option<Vec<u8>>;
}
