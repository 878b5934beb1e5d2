//! A bus in memory, for tests: each participant receives what the others send, in their order.

use super::{Bus, Receive, Transmit};
use std::io;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;
use tetrad_core::arm::canopen::Frame;

struct Out {
    others: Vec<Sender<Frame>>,
}

struct In {
    frames: Receiver<Frame>,
}

/// A bus with so many participants.
#[must_use]
pub fn in_memory(participants: usize) -> Vec<Bus> {
    let (senders, receivers): (Vec<_>, Vec<_>) = (0..participants).map(|_| channel()).unzip();
    let join = |(own, frames)| {
        let others = senders.iter().enumerate().filter(|(other, _)| *other != own);
        let others = others.map(|(_, sender): (usize, &Sender<Frame>)| sender.clone()).collect();
        Bus { transmit: Box::new(Out { others }), receive: Box::new(In { frames }) }
    };
    receivers.into_iter().enumerate().map(join).collect()
}

impl Transmit for Out {
    fn send(&mut self, frames: &[Frame]) -> io::Result<usize> {
        for other in &self.others {
            for frame in frames {
                // a participant that is gone hears nothing, as on any bus
                let _ = other.send(*frame);
            }
        }
        Ok(frames.len())
    }
}

impl Receive for In {
    fn receive(&mut self, within: Duration) -> io::Result<Option<Frame>> {
        match self.frames.recv_timeout(within) {
            Ok(frame) => Ok(Some(frame)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }
}
