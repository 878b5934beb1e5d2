//! Who holds hold-to-run: the terminal's space bar, a page of the console, or nobody where no arm of iron can
//! move.

use super::super::keyboard::{Key, Keyboard, next_scale, went_away};
use crate::console::Desk;
use crate::exit::{Exit, Failure};
use crate::station::operator::Buttons;
use crate::station::{SlaveAnnouncement, Unattended};
use std::time::Instant;
use tetrad_core::wire::{ArmStatePacket, ScaleShare};

/// Where the buttons are.
pub(super) enum Hold {
    Keyboard { keyboard: Keyboard, buttons: Buttons },
    Console(Desk),
    Always { unattended: Unattended, allowed: bool },
}

/// What the operator wants beside the buttons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wish {
    Nothing,
    /// The program shall end.
    Quit,
    /// The joints are said to be homed, which is for somebody at the arm to say.
    Homed,
    /// The hand shall lead by that share of the slave's scale.
    Scaled(ScaleShare),
}

impl Hold {
    pub(super) fn keyboard() -> Result<Self, Failure> {
        let keyboard = Keyboard::open().map_err(|cause| {
            let cause =
                anyhow::Error::new(cause).context("there is no terminal whose space bar could be held");
            Failure::new(Exit::BadArguments, cause)
                .help("run it from a terminal; with a simulated arm --hold-to-run always needs none")
        })?;
        Ok(Self::Keyboard { keyboard, buttons: Buttons::default() })
    }

    /// `allowed`: whether it is known that no arm can move.
    pub(super) fn always(allowed: bool) -> Self {
        Self::Always { unattended: Unattended::default(), allowed }
    }

    /// Whether somebody holds the button.
    pub(super) const fn is_attended(&self) -> bool {
        !matches!(self, Self::Always { .. })
    }

    pub(super) const fn is_console(&self) -> bool {
        matches!(self, Self::Console(_))
    }

    pub(super) const fn is_keyboard(&self) -> bool {
        matches!(self, Self::Keyboard { .. })
    }

    pub(super) const fn usage(&self) -> &'static str {
        match self {
            Self::Keyboard { .. } => {
                "r resets, hold the space bar to move, h to go home, - and + for the scale, any other key stops, q ends"
            }
            Self::Console(_) => "the buttons are in the console; Ctrl-C ends",
            Self::Always { .. } => {
                "hold-to-run is pressed by itself, for nothing that moves is at the other end"
            }
        }
    }

    /// What the slave says of itself.
    ///
    /// # Errors
    /// It moves an arm, and nobody would hold the button.
    pub(super) fn announced(&mut self, slave: &SlaveAnnouncement) -> Result<(), Failure> {
        let Self::Always { allowed, .. } = self else { return Ok(()) };
        *allowed = !slave.moves_an_arm;
        if *allowed {
            return Ok(());
        }
        Err(Failure::bad_arguments(format!(
            "the slave's port ({}) moves an arm: somebody has to hold the button, --hold-to-run always will not do",
            slave.port
        ))
        .help("leave the flag out and hold the space bar, or try it with a slave at sim: first"))
    }

    /// The slave is gone: whoever comes back has to say anew what it moves.
    pub(super) const fn slave_gone(&mut self) {
        if let Self::Always { allowed, .. } = self {
            *allowed = false;
        }
    }

    /// The arm's state has come.
    pub(super) fn hear(&mut self, state: &ArmStatePacket, now_us: u64) {
        if let Self::Always { unattended, allowed: true } = self {
            unattended.hear(state, now_us);
        }
    }

    /// Takes what was struck. A terminal that goes away has let go.
    pub(super) fn keys(&mut self, now: Instant) -> Result<Wish, Failure> {
        let (keyboard, buttons) = match self {
            Self::Keyboard { keyboard, buttons } => (keyboard, buttons),
            Self::Console(desk) if desk.take_homed() => return Ok(Wish::Homed),
            Self::Console(_) | Self::Always { .. } => return Ok(Wish::Nothing),
        };
        let mut wish = Wish::Nothing;
        loop {
            match keyboard.next() {
                Ok(Some(Key::Quit)) => return Ok(Wish::Quit),
                Ok(Some(Key::Stop)) => buttons.stop = true,
                Ok(Some(Key::Reset)) => {
                    buttons.stop = false;
                    buttons.resets = buttons.resets.wrapping_add(1);
                }
                Ok(Some(Key::Homed)) => wish = Wish::Homed,
                Ok(Some(key @ (Key::Finer | Key::Coarser))) => {
                    buttons.scale = next_scale(buttons.scale, key);
                    wish = Wish::Scaled(buttons.scale);
                }
                Ok(None) => break,
                Err(cause) => return Err(went_away(cause)),
            }
        }
        buttons.pressed = keyboard.is_held(now) && !buttons.stop;
        buttons.press_for = keyboard.held_for();
        Ok(wish)
    }

    /// Whether whoever holds the keys still could.
    ///
    /// # Errors
    /// The terminal went away.
    pub(super) fn still_there(&mut self) -> Result<(), Failure> {
        match self {
            Self::Keyboard { keyboard, .. } => keyboard.still_there().map_err(went_away),
            Self::Console(_) | Self::Always { .. } => Ok(()),
        }
    }

    pub(super) fn buttons(&mut self, now_us: u64) -> Buttons {
        match self {
            Self::Keyboard { buttons, .. } => *buttons,
            Self::Console(desk) => desk.buttons(),
            Self::Always { unattended, allowed: true } => unattended.buttons(now_us),
            // the count stays: another one would ask for a reset
            Self::Always { unattended, .. } => Buttons { pressed: false, ..unattended.buttons(now_us) },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::config::SlaveConfig;
    use tetrad_core::wire::{ArmReason, ArmState};
    use tetrad_fixtures::packets;

    #[test]
    fn a_slave_that_goes_and_comes_back_is_asked_for_no_reset() {
        let mut hold = Hold::always(true);
        let mut now_us = 0;
        let mut hear = |hold: &mut Hold, state, reason| {
            for _ in 0..60 {
                now_us += 10_000;
                hold.hear(&packets::arm_state(state, reason), now_us);
            }
            hold.buttons(now_us)
        };
        assert_eq!(hear(&mut hold, ArmState::Stopped, ArmReason::Started).resets, 1);
        assert!(hear(&mut hold, ArmState::Engaged, ArmReason::None).pressed);
        hold.slave_gone();
        let gone = hear(&mut hold, ArmState::Engaged, ArmReason::None);
        assert_eq!(gone, Buttons { resets: 1, ..Buttons::default() });
        let sim = SlaveAnnouncement::new(&"sim:".parse().unwrap(), &SlaveConfig::default(), 0);
        hold.announced(&sim).unwrap();
        assert_eq!(hear(&mut hold, ArmState::Stopped, ArmReason::Asked), gone);
    }
}
