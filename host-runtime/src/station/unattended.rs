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

/// Buttons that follow from what the arm says of itself.
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
            (ArmState::Armed, ArmReason::LetGo | ArmReason::NewSender | ArmReason::PressChanged) => {
                self.release(now_us)
            }
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

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_fixtures::packets;

    /// The buttons while the arm says the same for so long, told each 10 ms.
    fn hold(unattended: &mut Unattended, now_us: &mut u64, says: (ArmState, ArmReason), us: u64) -> Buttons {
        let end_us = *now_us + us;
        while *now_us < end_us {
            *now_us += 10_000;
            unattended.hear(&packets::arm_state(says.0, says.1), *now_us);
        }
        unattended.buttons(*now_us)
    }

    #[test]
    fn it_resets_presses_lets_go_and_presses_again() {
        let (mut it, mut now_us) = (Unattended::default(), 0);
        let started = (ArmState::Stopped, ArmReason::Started);
        assert_eq!(hold(&mut it, &mut now_us, started, 100_000), Buttons::default(), "released first");
        assert_eq!(hold(&mut it, &mut now_us, started, 500_000).resets, 1, "once");
        assert_eq!(
            hold(&mut it, &mut now_us, started, 2_000_000).resets,
            2,
            "and again where nothing came of it"
        );
        let press = (ArmState::Armed, ArmReason::Press);
        assert!(hold(&mut it, &mut now_us, press, 10_000).pressed);
        assert!(hold(&mut it, &mut now_us, (ArmState::Hold, ArmReason::HandNotSeen), 500_000).pressed);
        assert!(!hold(&mut it, &mut now_us, (ArmState::Armed, ArmReason::LetGo), 100_000).pressed);
        assert!(!hold(&mut it, &mut now_us, press, 50_000).pressed, "the release has to be heard");
        assert!(hold(&mut it, &mut now_us, press, 200_000).pressed);
    }

    #[test]
    fn faults_and_stops_are_for_people_and_silence_lets_go() {
        for says in [(ArmState::Fault, ArmReason::Arm), (ArmState::Stopped, ArmReason::Asked)] {
            let (mut it, mut now_us) = (Unattended::default(), 0);
            assert_eq!(hold(&mut it, &mut now_us, says, 5_000_000), Buttons::default(), "{says:?}");
        }
        let (mut it, mut now_us) = (Unattended::default(), 0);
        assert!(hold(&mut it, &mut now_us, (ArmState::Engaged, ArmReason::None), 100_000).pressed);
        assert!(it.buttons(now_us + SILENT_US).pressed);
        assert!(!it.buttons(now_us + SILENT_US + 1).pressed);
    }
}
