//! Who drives, and whether the button is held: the rules of the console, without sockets or clocks.
//!
//! One tab at a time is in control. Its page says again and again that the button is held, and of each
//! message two things count:
//!
//! - it has come at most [`FRESH_US`] ago, by our clock;
//! - the page had heard from us at most [`HEARD_US`] before, so that what waited in a line that was stuck
//!   is not taken for news, and nobody drives by a picture that stands still.
//!
//! A press has a number, larger than that of the press before. It ends with a release, a stop, a reset, the
//! socket, or a silence of [`HICCUP_US`], and does not come back: the operator lets go and presses anew. A
//! shorter silence is a release while it lasts. Nor does a press count that was begun before its tab was
//! given control: the first that is heard of the button then has to be that it is let go, and a press that was
//! heard of before does not count after that either. A press is for one thing, following the hand or going home:
//! one that goes on for the other has ended.
//!
//! The scale is changed while the button is let go, by the tab in control, and stays for whoever drives next.
//!
//! A stop is for everybody, whoever is in control, and latches until the tab in control resets.

use crate::station::operator::Buttons;
use serde::Serialize;
use std::collections::BTreeMap;
use tetrad_core::wire::{PressFor, ScaleShare};

/// A press counts for so long after it was last told, microseconds: two of the page's messages.
pub const FRESH_US: u64 = 60_000;

/// A press that was silent for longer has ended, microseconds.
pub const HICCUP_US: u64 = 300_000;

/// What the page had last heard from us may be so old when it says that the button is held,
/// microseconds.
pub const HEARD_US: u64 = 250_000;

/// Who is in control and says nothing at all for so long is not any more, microseconds.
pub const ABSENT_US: u64 = 3_000_000;

/// A tab: one page with one socket. A page that is loaded again is another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tab(pub u64);

/// Why something was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// Another tab drives.
    #[error("another page is in control; it can give control up, and anybody can stop the arm")]
    AnotherDrives,
    /// Nobody has asked for control from this tab, or it was lost.
    #[error("this page is not in control: take control first")]
    NotInControl,
    /// Hold-to-run is not in the console.
    #[error("the buttons are not in the console: start with --hold-to-run console to drive from here")]
    ButtonsElsewhere,
    /// The arm is stopped.
    #[error("the arm is stopped: reset, then press anew")]
    Stopped,
    /// The press has ended before.
    #[error("this press has ended: let go and press again")]
    Ended,
    /// The button is held.
    #[error("the button is held: let go, then change the scale")]
    Held,
    /// The slave's scale is the most.
    #[error("the scale is a share of the slave's own, in percent: 1 to 100")]
    NoScale,
    /// The page acts on what it has heard too long ago.
    #[error("the page shows what was too long ago: wait until it follows, let go and press again")]
    Late,
}

/// What pages are told of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ControlView {
    /// Who drives, in words; `None`: nobody.
    pub holder: Option<String>,
    /// Whether it is the page that reads this.
    pub yours: bool,
    /// Whether hold-to-run is in the console at all.
    pub drives: bool,
    /// Whether hold-to-run is pressed, and freshly so.
    pub pressed: bool,
    /// Whether a stop is latched here.
    pub stopped: bool,
    /// Microseconds since the press was last told.
    pub press_age_us: Option<u64>,
    /// When a press was last told in a way that counts, by the operator's clock, also where it has ended since;
    /// `None`: none ever was.
    pub held_us: Option<u64>,
    /// Percent of the slave's scale that the next press follows by.
    pub scale_percent: u8,
}

/// The tab that drives.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Holder {
    tab: Tab,
    name: String,
    heard_us: u64,
    /// The button was let go since this tab drives.
    let_go: bool,
    press: Option<Press>,
    /// Presses up to this number have ended.
    ended: u64,
}

/// The button is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Press {
    number: u64,
    press_for: PressFor,
    told_us: u64,
}

/// See the [module's text](self).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Control {
    drives: bool,
    holder: Option<Holder>,
    /// The newest press that each tab has told of, in control or not.
    told: BTreeMap<Tab, u64>,
    /// When a press was last told, by whomever.
    held_us: Option<u64>,
    stop: bool,
    /// Counts the stops that were asked for.
    stops: u64,
    resets: u32,
    scale: ScaleShare,
    /// What the last press was for: it stays until the next one, so that a release ends what it began.
    press_for: PressFor,
}

impl Control {
    /// Nobody drives, nothing is pressed. Without `drives` the buttons are elsewhere: a stop is all that
    /// can be done from here.
    #[must_use]
    pub const fn new(drives: bool) -> Self {
        Self {
            drives,
            holder: None,
            told: BTreeMap::new(),
            held_us: None,
            stop: false,
            stops: 0,
            resets: 0,
            scale: ScaleShare::FULL,
            press_for: PressFor::Follow,
        }
    }

    /// Gives a tab control, if nobody else has it; `name` is what the others are told.
    ///
    /// # Errors
    /// [`Refusal::AnotherDrives`], [`Refusal::ButtonsElsewhere`]
    pub fn take(&mut self, tab: Tab, name: &str, now_us: u64) -> Result<(), Refusal> {
        if !self.drives {
            return Err(Refusal::ButtonsElsewhere);
        }
        match self.present(now_us) {
            Some(holder) if holder.tab == tab => Ok(()),
            Some(_) => Err(Refusal::AnotherDrives),
            None => {
                let name = name.to_owned();
                // what was pressed by now was not pressed in control
                let ended = self.told.get(&tab).copied().unwrap_or_default();
                let holder = Holder { tab, name, heard_us: now_us, let_go: false, press: None, ended };
                self.holder = Some(holder);
                Ok(())
            }
        }
    }

    /// The tab drives no longer: it gave control up.
    pub fn leave(&mut self, tab: Tab) {
        self.holder.take_if(|holder| holder.tab == tab);
    }

    /// The tab's socket is gone, and nothing comes of it any more.
    pub fn gone(&mut self, tab: Tab) {
        self.leave(tab);
        self.told.remove(&tab);
    }

    /// The tab is there, and nothing else.
    pub fn here(&mut self, tab: Tab, now_us: u64) {
        if let Some(holder) = self.holder_mut(tab, now_us) {
            holder.heard_us = now_us;
        }
    }

    /// The button is held for that, since the press of that number; the page had heard from us at `shown_us`.
    ///
    /// # Errors
    /// Why it does not count; the arm does not move then.
    pub fn hold(
        &mut self,
        tab: Tab,
        number: u64,
        press_for: PressFor,
        shown_us: u64,
        now_us: u64,
    ) -> Result<(), Refusal> {
        let stop = self.stop;
        let newest = self.told.entry(tab).or_default();
        *newest = number.max(*newest);
        let holder = self.holder_mut(tab, now_us).ok_or(Refusal::NotInControl)?;
        holder.heard_us = now_us;
        let ended = |press: Press| {
            let another = (press.number, press.press_for) != (number, press_for);
            another || now_us.saturating_sub(press.told_us) > HICCUP_US
        };
        if holder.press.is_some_and(ended) {
            holder.end_press();
        }
        if stop {
            holder.ended = holder.ended.max(number);
            return Err(Refusal::Stopped);
        }
        if !holder.let_go || number <= holder.ended {
            return Err(Refusal::Ended);
        }
        // what the page says it has heard later than now it has not heard from us
        if shown_us > now_us || now_us - shown_us > HEARD_US {
            if holder.press.is_none() {
                holder.ended = number;
            }
            return Err(Refusal::Late);
        }
        holder.press = Some(Press { number, press_for, told_us: now_us });
        self.press_for = press_for;
        self.held_us = Some(now_us);
        Ok(())
    }

    /// The button is let go.
    pub fn release(&mut self, tab: Tab, now_us: u64) {
        if let Some(holder) = self.holder_mut(tab, now_us) {
            holder.heard_us = now_us;
            holder.let_go = true;
            holder.end_press();
        }
    }

    /// Sets the share of the slave's scale that the next press follows by.
    ///
    /// # Errors
    /// [`Refusal::NoScale`], [`Refusal::ButtonsElsewhere`], [`Refusal::NotInControl`], [`Refusal::Held`]; the
    /// scale stays.
    pub fn set_scale(&mut self, tab: Tab, percent: u8, now_us: u64) -> Result<(), Refusal> {
        let scale = ScaleShare::from_percent(percent).ok_or(Refusal::NoScale)?;
        if !self.drives {
            return Err(Refusal::ButtonsElsewhere);
        }
        let holder = self.holder_mut(tab, now_us).ok_or(Refusal::NotInControl)?;
        holder.heard_us = now_us;
        // a silence within a press is no release
        let goes_on = |press: &Press| now_us.saturating_sub(press.told_us) <= HICCUP_US;
        if holder.press.as_ref().is_some_and(goes_on) {
            return Err(Refusal::Held);
        }
        self.scale = scale;
        Ok(())
    }

    /// Stop: by anybody.
    pub fn stop(&mut self) {
        self.stop = true;
        self.stops += 1;
        if let Some(holder) = &mut self.holder {
            holder.end_press();
        }
    }

    /// Ends a stop, here and at the slave. The button has to be pressed anew.
    ///
    /// # Errors
    /// [`Refusal::NotInControl`], [`Refusal::ButtonsElsewhere`]
    pub fn reset(&mut self, tab: Tab, now_us: u64) -> Result<(), Refusal> {
        if !self.drives {
            return Err(Refusal::ButtonsElsewhere);
        }
        let holder = self.holder_mut(tab, now_us).ok_or(Refusal::NotInControl)?;
        holder.heard_us = now_us;
        holder.end_press();
        self.stop = false;
        self.resets = self.resets.wrapping_add(1);
        Ok(())
    }

    /// Whoever has the buttons elsewhere has reset: stops from here up to that [count](Self::stops) are over. A later
    /// one is not, for it was not known of there.
    pub const fn reset_elsewhere(&mut self, up_to: u64) {
        if self.stops <= up_to {
            self.stop = false;
        }
    }

    /// How many stops were asked for.
    #[must_use]
    pub const fn stops(&self) -> u64 {
        self.stops
    }

    /// Whether a stop is latched here.
    #[must_use]
    pub const fn is_stopped(&self) -> bool {
        self.stop
    }

    /// Whether this tab drives.
    #[must_use]
    pub fn is_holder(&self, tab: Tab, now_us: u64) -> bool {
        self.present(now_us).is_some_and(|holder| holder.tab == tab)
    }

    /// What the arm is told now.
    #[must_use]
    pub fn buttons(&self, now_us: u64) -> Buttons {
        Buttons {
            pressed: self.is_pressed(now_us),
            stop: self.stop,
            resets: self.resets,
            press_for: self.press_for,
            scale: self.scale,
        }
    }

    /// What a page is told of it; `tab` reads it.
    #[must_use]
    pub fn view(&self, tab: Option<Tab>, now_us: u64) -> ControlView {
        let holder = self.present(now_us);
        ControlView {
            holder: holder.map(|holder| holder.name.clone()),
            yours: tab.is_some_and(|tab| self.is_holder(tab, now_us)),
            drives: self.drives,
            pressed: self.is_pressed(now_us),
            stopped: self.stop,
            press_age_us: holder
                .and_then(|holder| holder.press)
                .map(|press| now_us.saturating_sub(press.told_us)),
            held_us: self.held_us,
            scale_percent: self.scale.percent(),
        }
    }

    fn is_pressed(&self, now_us: u64) -> bool {
        let press = self.present(now_us).and_then(|holder| holder.press);
        !self.stop && press.is_some_and(|press| now_us.saturating_sub(press.told_us) <= FRESH_US)
    }

    /// Who drives and has been heard lately.
    fn present(&self, now_us: u64) -> Option<&Holder> {
        self.holder.as_ref().filter(|holder| now_us.saturating_sub(holder.heard_us) <= ABSENT_US)
    }

    fn holder_mut(&mut self, tab: Tab, now_us: u64) -> Option<&mut Holder> {
        let here = self.is_holder(tab, now_us);
        self.holder.as_mut().filter(|_| here)
    }
}

impl Holder {
    fn end_press(&mut self) {
        if let Some(press) = self.press.take() {
            self.ended = self.ended.max(press.number);
        }
    }
}

#[cfg(test)]
mod tests;
