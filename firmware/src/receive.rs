//! Commands out of a line's bytes, whatever else comes on it.

use crate::handover::{Input, Inputs};
use embedded_io_async::Read;
use tetrad_core::wire::{CommandPacket, Decoder, Packet};

/// Bytes taken from the line at a time.
const CHUNK: usize = 64;

/// Takes bytes as they come, and hands on commands.
#[derive(Default)]
pub struct Listener {
    decoder: Decoder,
}

impl Listener {
    /// Takes the next bytes. What is no command is told to the tracker, which tells the host. `handed_on`
    /// hears of each command once it is on its way there.
    pub async fn take(&mut self, bytes: &[u8], inputs: &Inputs, mut handed_on: impl FnMut(&CommandPacket)) {
        for byte in bytes {
            let Some(result) = self.decoder.packets(core::slice::from_ref(byte)).next() else { continue };
            match result {
                Ok(Packet::Command(command)) => {
                    inputs.send(Input::Command(command)).await;
                    handed_on(&command);
                }
                Ok(_) | Err(_) => inputs.send(Input::NotUnderstood).await,
            }
        }
    }
}

/// Listens to a line for ever.
pub async fn receive(line: impl Read, inputs: &Inputs) -> ! {
    receive_telling(line, inputs, |_| {}).await
}

/// The same for a board whose sensor has to know what was asked for: `handed_on` hears of each command once
/// it is on its way to the tracker, where it is before any picture that is taken from then on.
pub async fn receive_telling(
    mut line: impl Read,
    inputs: &Inputs,
    mut handed_on: impl FnMut(&CommandPacket),
) -> ! {
    let mut listener = Listener::default();
    let mut bytes = [0; CHUNK];
    loop {
        match line.read(&mut bytes).await {
            Ok(count) => {
                listener.take(bytes.get(..count).unwrap_or_default(), inputs, &mut handed_on).await;
            }
            // what was lost may have been the middle of a frame; the next zero byte mends that
            Err(_) => inputs.send(Input::LineOverrun).await,
        }
    }
}
