//! Commands out of a line's bytes, whatever else comes on it.

use crate::handover::{Input, Inputs};
use embedded_io_async::Read;
use tetrad_core::wire::{Decoder, Packet};

/// Bytes taken from the line at a time.
const CHUNK: usize = 64;

/// Takes bytes as they come, and hands on commands.
#[derive(Default)]
pub struct Listener {
    decoder: Decoder,
}

impl Listener {
    /// Takes the next bytes. What is no command is told to the tracker, which tells the host.
    pub async fn take(&mut self, bytes: &[u8], inputs: &Inputs) {
        for byte in bytes {
            let Some(result) = self.decoder.packets(core::slice::from_ref(byte)).next() else { continue };
            let input = match result {
                Ok(Packet::Command(command)) => Input::Command(command),
                Ok(_) | Err(_) => Input::NotUnderstood,
            };
            inputs.send(input).await;
        }
    }
}

/// Listens to a line for ever.
pub async fn receive(mut line: impl Read, inputs: &Inputs) -> ! {
    let mut listener = Listener::default();
    let mut bytes = [0; CHUNK];
    loop {
        match line.read(&mut bytes).await {
            Ok(count) => listener.take(bytes.get(..count).unwrap_or_default(), inputs).await,
            // what was lost may have been the middle of a frame; the next zero byte mends that
            Err(_) => inputs.send(Input::LineOverrun).await,
        }
    }
}
