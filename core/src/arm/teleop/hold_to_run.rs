//! Hold-to-run: the button or pedal that the operator keeps pressed while the arm may move. It has a
//! freshness of its own, apart from that of the commands.

/// What is known of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct HoldToRun {
    pressed: bool,
    /// When it was last heard; `None` before the first time.
    heard_us: Option<u64>,
    /// When it was first heard to be pressed since it was released.
    pressed_us: u64,
}

impl HoldToRun {
    pub(super) const fn unheard() -> Self {
        Self { pressed: false, heard_us: None, pressed_us: 0 }
    }

    pub(super) const fn hear(&mut self, pressed: bool, at_us: u64) {
        if pressed && !self.pressed {
            self.pressed_us = at_us;
        }
        self.pressed = pressed;
        self.heard_us = Some(at_us);
    }

    /// Whether it was heard in the last `within_us` before `now_us`.
    pub(super) fn is_fresh(&self, now_us: u64, within_us: u32) -> bool {
        self.heard_us.is_some_and(|heard| now_us.saturating_sub(heard) <= u64::from(within_us))
    }

    pub(super) const fn is_pressed(&self) -> bool {
        self.pressed
    }

    /// Since when it is pressed.
    pub(super) const fn pressed_us(&self) -> u64 {
        self.pressed_us
    }
}
