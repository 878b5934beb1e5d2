//! An operator's hand on the button where there is none: for simulated arms, scripts and tests.
//!
//! It does what a person would: asks for the first reset, presses when the arm waits for a press, lets go
//! where the arm wants that and presses again. A fault, and a stop that somebody asked for, it leaves to
//! people.

use super::operator::Buttons;
use tetrad_core::wire::{ArmReason, ArmState, ArmStatePacket};

/// How long the button is let go, so that the release is heard, and the least time between two resets,
/// microseconds.
const RELEASED_US: u64 = 200_000;
const RESET_US: u64 = 2_000_000;

/// A slave that has not been heard for so long is let go of, microseconds.
const SILENT_US: u64 = 1_000_000;

/// See the [module's text](self).
#[derive(Clone, Copy, Debug, Default)]
pub struct Unattended {
    buttons: Buttons,
    heard_us: Option<u64>,
    released_us: Option<u64>,
    reset_us: Option<u64>,
}

impl Unattended {
    /// The arm's state has come.
    pub fn hear(&mut self, state: &ArmStatePacket, now_us: u64) {
        self.heard_us = Some(now_us);
        match (state.state, state.reason) {
            (ArmState::Armed, ArmReason::LetGo | ArmReason::NewSender) => self.release(now_us),
            (ArmState::Armed | ArmState::Engaged | ArmState::Hold, _) => self.press(now_us),
            (ArmState::Stopped, ArmReason::Started) => {
                self.release(now_us);
                let since_us = |at_us: u64| now_us.saturating_sub(at_us);
                let released = self.released_us.is_some_and(|at_us| since_us(at_us) >= RELEASED_US);
                if released && self.reset_us.is_none_or(|at_us| since_us(at_us) >= RESET_US) {
                    self.reset_us = Some(now_us);
                    self.buttons.resets = self.buttons.resets.wrapping_add(1);
                }
            }
            (ArmState::Stopped | ArmState::Fault, _) => self.release(now_us),
        }
    }

    /// What is pressed.
    pub fn buttons(&mut self, now_us: u64) -> Buttons {
        if self.heard_us.is_none_or(|heard_us| now_us.saturating_sub(heard_us) > SILENT_US) {
            self.release(now_us);
        }
        self.buttons
    }

    fn release(&mut self, now_us: u64) {
        if self.buttons.pressed || self.released_us.is_none() {
            self.buttons.pressed = false;
            self.released_us = Some(now_us);
        }
    }

    fn press(&mut self, now_us: u64) {
        if self.released_us.is_none_or(|at_us| now_us.saturating_sub(at_us) >= RELEASED_US) {
            self.buttons.pressed = true;
        }
    }
}
