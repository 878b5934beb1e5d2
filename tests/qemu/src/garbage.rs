//! What a line carries beside good commands: noise, and frames that are cut, joined, damaged or too long.

use crate::tape::command_frame;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::Ball;
use tetrad_core::wire::Command;

/// A piece of a line, the same for the same seed.
#[derive(Debug)]
pub struct Garbage {
    state: u64,
    /// The number of the next command.
    sequence: u32,
}

impl Garbage {
    /// Garbage of this seed.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self { state: seed, sequence: 0 }
    }

    /// The number that no command has had.
    #[must_use]
    pub const fn sequence(&self) -> u32 {
        self.sequence
    }

    /// SplitMix64: what is below `end`.
    fn below(&mut self, end: usize) -> usize {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % end as u64) as usize
    }

    /// A good command, in a frame. It asks for no picture.
    pub fn command(&mut self) -> Vec<u8> {
        let at = ImagePoint::new(self.below(320) as f32, self.below(240) as f32);
        let command = match self.below(12) {
            // a second of the board's time
            0 => Command::SelfTest,
            1..6 => Command::Stop,
            // it was never taught, and says so
            _ => Command::SetWindow { ball: Ball::ALL[self.below(4)], at },
        };
        self.sequence += 1;
        command_frame(self.sequence - 1, command)
    }

    fn noise(&mut self, length: usize) -> Vec<u8> {
        (0..length).map(|_| self.below(256) as u8).collect()
    }

    /// The next piece: one to three of these by chance, and then a command that has to get through, behind the
    /// zero byte that a sender puts there. It is short enough for the line's ring of 1024 bytes, whatever the
    /// board is busy with.
    pub fn piece(&mut self) -> Vec<u8> {
        let mut piece = Vec::new();
        for _ in 0..self.below(3) + 1 {
            let mut frame = self.command();
            match self.below(6) {
                0 => {
                    let length = self.below(300);
                    piece.extend(self.noise(length));
                }
                // truncated
                1 => {
                    let length = self.below(frame.len());
                    piece.extend(&frame[..length]);
                }
                // begun in its middle
                2 => {
                    let length = self.below(frame.len());
                    piece.extend(&frame[length..]);
                }
                // joined: the zero byte between two is lost
                3 => {
                    frame.pop();
                    piece.extend(frame);
                    piece.extend(self.command());
                }
                // a bit is flipped
                4 => {
                    let (byte, bit) = (self.below(frame.len()), self.below(8));
                    frame[byte] ^= 1 << bit;
                    piece.extend(frame);
                }
                // longer than any packet, without a zero byte
                _ => {
                    let length = 257 + self.below(64);
                    piece.extend((0..length).map(|_| self.below(255) as u8 + 1));
                }
            }
        }
        piece.push(0);
        piece.extend(self.command());
        piece
    }
}
