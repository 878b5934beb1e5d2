//! On simulated time, over the loopback with faults: when the arm follows, when it begins to stop, and
//! what the operator is told.

use super::*;
use crate::link::faulty::{Faults, FaultyEnd, pair};
use crate::robot::simulated::{Mischief, SimulatedArm, SimulatedOptions};
use crate::station::arm_words;
use tetrad_core::arm::teleop::{Note, Notes, Order, State};
use tetrad_core::wire::{
    ArmReason, ArmState, ArmStatePacket, ButtonsPacket, ControllerState, MotionPacket, PressFor, ScaleShare,
    Settled,
};
use tetrad_fixtures::packets;

const OPERATOR: u32 = 7;
const SLAVE: u32 = 8;
const FRAME_US: u64 = 16_667;
/// One millisecond: what the clock goes by, whatever the slave's cycle is.
const TICK_US: u64 = 1_000;

/// An operator, a slave with a simulated arm, and the faulty link between them.
struct Rig {
    clock: Clock,
    operator: FaultyEnd,
    slave: LinkedSlave<FaultyEnd>,
    mischief: Mischief,
    cycle_us: u64,
    /// When the slave's next cycle is due, and when the operator's next packets are.
    cycle_due_us: u64,
    frame_due_us: u64,
    sequence: u32,
    buttons: ButtonsPacket,
    /// What the operator's computer does: whether it sends motion, and buttons.
    sends: (bool, bool),
    /// The hand, metres a second along x since it was pressed.
    speed_m_s: f32,
    began_us: u64,
    /// When the last motion and buttons that counted were received, slave's clock.
    last: Option<Cycle>,
    /// When the hand was followed last, and not any more for the first time since.
    followed_us: u64,
    stopped_us: Option<u64>,
    states: Vec<ArmStatePacket>,
}

impl Rig {
    fn new(cycle_us: u32, faults: [Faults; 2]) -> Self {
        let clock = Clock::given();
        let mut config = SlaveConfig::default();
        config.governor.cycle_us = cycle_us;
        let options = SimulatedOptions::default();
        let arm = SimulatedArm::with_clock(&config.puma, &options, clock.clone()).unwrap();
        let mischief = arm.mischief();
        let [operator, end] = pair(3, faults, &clock);
        end.begin(OPERATOR).unwrap();
        operator.begin(SLAVE).unwrap();
        Self {
            slave: LinkedSlave::new(&config, Box::new(arm), end, SLAVE).unwrap(),
            clock,
            operator,
            mischief,
            cycle_us: u64::from(cycle_us),
            cycle_due_us: 0,
            frame_due_us: 0,
            sequence: 0,
            buttons: packets::buttons(OPERATOR, 0),
            sends: (true, true),
            speed_m_s: 0.1,
            began_us: u64::MAX,
            last: None,
            followed_us: 0,
            stopped_us: None,
            states: Vec::new(),
        }
    }

    fn run_ms(&mut self, ms: u64) {
        for _ in 0..ms {
            let now_us = self.clock.now_us() + TICK_US;
            self.clock.set(now_us);
            if now_us >= self.frame_due_us {
                self.frame_due_us += FRAME_US;
                self.send(now_us);
            }
            if now_us >= self.cycle_due_us {
                self.cycle_due_us += self.cycle_us;
                self.cycle(now_us);
            }
            if let Some(state) = self.operator.arm_state() {
                self.states.push(state.what);
            }
        }
    }

    fn send(&mut self, now_us: u64) {
        self.sequence += 1;
        let x_m = self.speed_m_s * now_us.saturating_sub(self.began_us) as f32 / 1e6;
        let motion = packets::motion_to(self.buttons.session, self.sequence, [x_m, 0.0, 0.0]);
        let motion = MotionPacket { capture_us: now_us, ..motion };
        self.buttons.sequence = self.sequence;
        self.buttons.time_us = now_us;
        if self.sends.0 {
            self.operator.send(&motion.into()).unwrap();
        }
        if self.sends.1 {
            self.operator.send(&self.buttons.into()).unwrap();
        }
    }

    fn cycle(&mut self, now_us: u64) {
        let cycle = self.slave.cycle(&self.clock);
        if matches!(cycle.step.decision.order, Order::Follow(_)) {
            (self.followed_us, self.stopped_us) = (now_us, None);
        } else if self.stopped_us.is_none() {
            self.stopped_us = Some(now_us);
        }
        self.last = Some(cycle);
    }

    fn state(&self) -> State {
        self.last.unwrap().step.decision.status.state()
    }

    fn told(&self) -> &ArmStatePacket {
        self.states.last().expect("the slave tells")
    }

    /// Switched on, reset and pressed; the hand moves.
    fn following(mut self) -> Self {
        self.run_ms(100);
        self.buttons.resets += 1;
        self.run_ms(3_000);
        assert_eq!(self.state(), State::Armed, "{:?}", self.last.unwrap().step.decision.status);
        self.buttons.pressed = true;
        self.began_us = self.clock.now_us();
        self.run_ms(500);
        assert_eq!(self.state(), State::Engaged);
        self
    }

    /// What the slave received last of the motion.
    fn heard_us(&self) -> u64 {
        self.slave.command().unwrap().received_us
    }
}

const NONE: Faults = Faults {
    loss: 0.0,
    delay_us: 0,
    jitter_us: 0,
    duplication: 0.0,
    corruption: 0.0,
    unseen: false,
    replay: 0.0,
    cut: None,
};

const NETWORK: Faults =
    Faults { loss: 0.05, delay_us: 8_000, jitter_us: 12_000, duplication: 0.05, replay: 0.05, ..NONE };

#[test]
fn nothing_moves_before_a_reset_and_a_press_after_it() {
    let mut rig = Rig::new(10_000, [NONE; 2]);
    rig.buttons.pressed = true;
    rig.buttons.resets = 40;
    rig.run_ms(1_000);
    assert_eq!(rig.state(), State::Stopped, "the first count of a session asks for nothing");
    assert_eq!(rig.told().controller, ControllerState::Disabled, "and switches nothing on");
    rig.buttons.resets += 1;
    rig.run_ms(3_000);
    assert_eq!(rig.state(), State::Stopped);
    let refused = rig.slave.take_refusal().unwrap();
    assert!(refused.to_string().contains("hold-to-run"), "{refused}");
    rig.buttons.pressed = false;
    rig.buttons.resets += 1;
    rig.run_ms(200);
    assert_eq!(rig.state(), State::Armed);
    assert_eq!((rig.followed_us, rig.slave.command()), (0, None));
    rig.buttons.pressed = true;
    rig.run_ms(200);
    assert_eq!(rig.state(), State::Engaged);
}

/// The operator's computer dies, the cable is cut, or the operator's motion stays away: the first cycle
/// that stops is at most 100 ms after the last motion that came, by the slave's clock, and not much sooner
/// than a late cycle needs.
#[test]
fn silence_stops_the_arm_within_100_ms_of_the_last_motion() {
    for cycle_us in [1_000, 4_000, 10_000] {
        for silent_from_ms in 0..20 {
            for sends in [(false, false), (false, true)] {
                let mut rig = Rig::new(cycle_us, [NETWORK, NONE]).following();
                rig.run_ms(silent_from_ms);
                rig.sends = sends;
                rig.run_ms(160);
                let stopped_us = rig.stopped_us.unwrap() - rig.heard_us();
                assert!(stopped_us <= 100_000, "{cycle_us}: {stopped_us}");
                let followed_us = rig.followed_us - rig.heard_us();
                assert!(followed_us + 2 * u64::from(cycle_us) > 90_000 - 1_000, "{cycle_us}: {followed_us}");
                assert_eq!(rig.told().reason, ArmReason::NoCommand);
                assert!(rig.told().command_age_us().unwrap() >= 100_000);
                // which a hold that lasts ends: it takes a release and a press
                rig.run_ms(1_000);
                assert_eq!(rig.state(), State::Armed);
            }
        }
    }
}

/// A computer that has something else to do runs one cycle late, whichever it is.
#[test]
fn a_cycle_that_comes_late_still_stops_within_100_ms() {
    for cycle_us in [1_000, 10_000] {
        for late_us in [3_000, 10_000] {
            let mut met = 0;
            for silent_ms in 60..100 {
                let mut rig = Rig::new(cycle_us, [NONE; 2]).following();
                rig.sends = (false, false);
                rig.run_ms(silent_ms);
                let on_time_us = rig.cycle_due_us;
                rig.cycle_due_us += late_us;
                rig.run_ms(60);
                let stopped_us = rig.stopped_us.unwrap() - rig.heard_us();
                assert!(stopped_us <= 100_000, "{cycle_us}, {late_us} late: {stopped_us}");
                met += usize::from(rig.stopped_us == Some(on_time_us + late_us));
            }
            assert!(met > 0, "{cycle_us}, {late_us} late: one of them was the cycle that stops");
        }
    }
}

#[test]
fn a_cut_cable_is_silence() {
    let mut rig = Rig::new(10_000, [NETWORK, NONE]).following();
    let now_us = rig.clock.now_us();
    rig.operator.set_faults(Faults { cut: Some((now_us, now_us + 2_000_000)), ..NETWORK });
    rig.run_ms(200);
    let stopped_us = rig.stopped_us.unwrap() - rig.heard_us();
    assert!(stopped_us <= 100_000, "{stopped_us}");
    rig.run_ms(1_800);
    let place = rig.last.unwrap().step.governed.unwrap().set_point;
    rig.run_ms(2_000);
    assert_eq!(rig.state(), State::Armed, "the end of the cut moves nothing");
    assert_eq!(rig.last.unwrap().step.governed.unwrap().set_point, place);
    rig.buttons.pressed = false;
    rig.run_ms(200);
    rig.buttons.pressed = true;
    rig.run_ms(200);
    assert_eq!(rig.state(), State::Engaged, "a release and a press do");
}

#[test]
fn buttons_that_are_not_heard_are_no_release_and_no_press() {
    let mut rig = Rig::new(10_000, [NONE; 2]).following();
    rig.sends = (true, false);
    rig.run_ms(150);
    assert_eq!(rig.state(), State::Engaged, "not heard for a while is not released");
    rig.run_ms(150);
    assert_eq!(rig.told().reason, ArmReason::NoHoldToRun, "but not for long");
    rig.sends = (true, true);
    rig.run_ms(50);
    assert_eq!(rig.state(), State::Engaged, "it was held all the time");
}

#[test]
fn a_release_stops_in_the_cycle_in_which_it_is_heard() {
    for cycle_us in [1_000, 10_000] {
        let mut rig = Rig::new(cycle_us, [NONE; 2]).following();
        rig.buttons.pressed = false;
        let sent_us = rig.frame_due_us.max(rig.clock.now_us());
        rig.run_ms(40);
        let after_us = rig.stopped_us.unwrap() - sent_us;
        assert!(after_us <= u64::from(cycle_us) + TICK_US, "{after_us}");
        assert_eq!(rig.told().state, ArmState::Armed);
    }
}

/// The way home takes the button alone, and as fresh as the hand has to be.
#[test]
fn the_button_alone_takes_the_arm_home_and_its_silence_stops_it() {
    let mut rig = Rig::new(10_000, [NETWORK, NONE]).following();
    rig.run_ms(1_000);
    let home = rig.states.iter().find(|state| state.state == ArmState::Armed).unwrap().tool;
    let away_m = |rig: &Rig| {
        let (at, home) = (rig.told().tool.translation, home.translation);
        at.iter().zip(home).map(|(at, home)| (at - home).powi(2)).sum::<f32>().sqrt()
    };
    rig.buttons.pressed = false;
    rig.run_ms(1_000);
    let from_m = away_m(&rig);
    assert!(from_m > 0.05, "{from_m}");
    (rig.buttons.pressed, rig.buttons.press_for) = (true, PressFor::Home);
    rig.sends = (false, true);
    rig.run_ms(400);
    let is_on = |rig: &Rig, note| Notes::from_bits(rig.told().notes).contains(note);
    assert!(is_on(&rig, Note::GoesHome) && !is_on(&rig, Note::AtHome));
    assert!(away_m(&rig) < from_m - 0.005, "no motion of a hand is needed");

    rig.sends = (false, false);
    let silent_us = rig.clock.now_us();
    rig.run_ms(1_000);
    let stands =
        rig.states.iter().find(|state| state.time_us > silent_us && state.state != ArmState::Engaged);
    let after_us = stands.unwrap().time_us - silent_us;
    assert!(after_us <= 120_000, "what was on its way, and 100 ms: {after_us}");
    let place = rig.told().set_point;
    rig.sends = (false, true);
    rig.run_ms(500);
    assert_eq!(rig.told().set_point, place, "a press that has ended does not come back");

    rig.buttons.pressed = false;
    rig.run_ms(100);
    rig.buttons.pressed = true;
    rig.run_ms(5_000);
    assert!(is_on(&rig, Note::GoesHome) && is_on(&rig, Note::AtHome));
    assert!(away_m(&rig) < 1e-3, "{}", away_m(&rig));
    // a button that is held on for something else is a new press, and has to be one
    rig.buttons.press_for = PressFor::Follow;
    rig.sends = (true, true);
    rig.run_ms(200);
    assert_eq!((rig.told().state, rig.told().reason), (ArmState::Armed, ArmReason::PressChanged));
}

#[test]
fn the_share_of_the_scale_counts_from_the_next_press_on() {
    let mut rig = Rig::new(10_000, [NONE; 2]).following();
    let full = rig.told().scale;
    rig.buttons.scale = ScaleShare::from_percent(10).unwrap();
    rig.run_ms(300);
    assert_eq!((rig.told().state, rig.told().scale), (ArmState::Engaged, full), "not within a press");
    rig.buttons.pressed = false;
    rig.run_ms(1_500);
    assert!((rig.told().scale - full / 10.0).abs() < 1e-6, "of the next press: {}", rig.told().scale);
    let from = rig.told().tool.translation;
    rig.buttons.pressed = true;
    let pressed_us = rig.clock.now_us();
    rig.run_ms(2_000);
    let to = rig.told().tool.translation;
    let moved_m = from.iter().zip(to).map(|(from, to)| (from - to).powi(2)).sum::<f32>().sqrt();
    let hand_m = rig.speed_m_s * (rig.clock.now_us() - pressed_us) as f32 / 1e6;
    assert!((moved_m / (hand_m * full) - 0.1).abs() < 0.02, "{moved_m} of {hand_m}");
}

#[test]
fn a_stop_latches_through_every_reset_until_it_is_let_go() {
    let mut rig = Rig::new(10_000, [NONE; 2]).following();
    rig.buttons.stop = true;
    rig.buttons.resets += 1;
    rig.run_ms(300);
    assert_eq!((rig.told().state, rig.told().reason), (ArmState::Stopped, ArmReason::Asked));
    rig.buttons.stop = false;
    rig.run_ms(300);
    assert_eq!(rig.state(), State::Stopped, "the reset was asked for while it was pressed");
    rig.buttons.pressed = false;
    rig.run_ms(50);
    rig.buttons.resets += 1;
    rig.run_ms(100);
    assert_eq!(rig.state(), State::Armed);
}

#[test]
fn somebody_at_the_arm_stops_it() {
    let mut rig = Rig::new(10_000, [NONE; 2]).following();
    rig.slave.stop();
    rig.run_ms(500);
    assert_eq!((rig.told().state, rig.told().reason), (ArmState::Stopped, ArmReason::Asked));
    let governed = rig.last.unwrap().step.governed.unwrap();
    assert!(governed.at_rest, "{governed:?}");
}

#[test]
fn another_session_of_the_operator_moves_nothing_without_a_press() {
    let mut rig = Rig::new(10_000, [NONE; 2]).following();
    // the operator's computer starts anew, its button held
    rig.sends = (false, false);
    rig.run_ms(600);
    rig.sends = (true, true);
    rig.slave.carrier.begin(OPERATOR + 1).unwrap();
    rig.buttons = ButtonsPacket { session: OPERATOR + 1, resets: 9, ..rig.buttons };
    rig.sequence = 0;
    rig.run_ms(1_000);
    assert_ne!(rig.state(), State::Engaged, "it was pressed already");
    rig.buttons.pressed = false;
    rig.run_ms(100);
    rig.buttons.pressed = true;
    rig.run_ms(300);
    assert_eq!(rig.state(), State::Engaged);
    let told = rig.told();
    assert_eq!(told.command.unwrap().session, OPERATOR + 1);
    let settled = told.settled.map(|settled| settled.sequence);
    assert!(settled.is_none_or(|sequence| sequence <= told.command.unwrap().sequence), "{settled:?}");
}

/// Started again sooner than its silence could be noticed: no second operator, and no jump.
#[test]
fn an_operator_that_starts_again_at_once_takes_over_and_needs_a_press() {
    for gap_ms in [0, 40, 90, 300, 450] {
        let mut rig = Rig::new(10_000, [NONE; 2]).following();
        rig.sends = (false, false);
        rig.run_ms(gap_ms);
        rig.sends = (true, true);
        rig.slave.carrier.begin(OPERATOR + 1).unwrap();
        // its button is held, its hand is elsewhere, its numbers begin anew
        rig.buttons = ButtonsPacket { session: OPERATOR + 1, ..rig.buttons };
        (rig.sequence, rig.began_us) = (0, rig.clock.now_us() - 2_000_000);
        let heard_us = rig.heard_us();
        rig.run_ms(300);
        assert!(rig.stopped_us.unwrap() - heard_us <= 100_000, "{gap_ms}");
        assert_eq!((rig.told().state, rig.told().reason), (ArmState::Armed, ArmReason::NewSender));
        let governed = rig.last.unwrap().step.governed.unwrap();
        rig.run_ms(1_000);
        assert_eq!(rig.last.unwrap().step.governed.unwrap().set_point, governed.set_point, "it stands");
        rig.buttons.pressed = false;
        rig.run_ms(100);
        rig.buttons.pressed = true;
        rig.run_ms(100);
        assert_eq!((rig.state(), rig.slave.counts().another_sender), (State::Engaged, 0));
    }
}

#[test]
fn a_station_that_ends_stops_for_good_and_says_so() {
    let mut rig = Rig::new(10_000, [NONE; 2]).following();
    for _ in 0..40 {
        rig.slave.end();
        rig.buttons.resets += 1;
        rig.run_ms(10);
    }
    let status = rig.last.unwrap().step.decision.status;
    assert_eq!(status.to_string(), "stopped: the slave station ends");
    assert!(arm_words::standing(rig.told()).contains("or the slave station ends"));
}

#[test]
fn an_arm_that_faults_says_so_and_takes_a_reset() {
    let mut rig = Rig::new(10_000, [NONE; 2]).following();
    rig.mischief.fault(Some(3), 77);
    rig.run_ms(100);
    let told = rig.told();
    assert_eq!((told.state, told.reason), (ArmState::Fault, ArmReason::Arm));
    assert_eq!(told.controller, ControllerState::Fault { joint: 3, code: 77 });
    rig.mischief.mend();
    rig.buttons.pressed = false;
    rig.run_ms(100);
    rig.buttons.resets += 1;
    rig.run_ms(3_000);
    assert_eq!(rig.state(), State::Armed);
}

#[test]
fn the_state_is_told_100_times_a_second_and_for_every_motion() {
    for cycle_us in [1_000, 10_000] {
        let mut rig = Rig::new(cycle_us, [NONE; 2]);
        rig.run_ms(1_000);
        assert_eq!(rig.states.len(), 100, "at rest");
        let mut rig = rig.following();
        rig.states.clear();
        rig.run_ms(1_000);
        let mut told: Vec<u32> = rig.states.iter().map(|state| state.command.unwrap().sequence).collect();
        told.dedup();
        assert!(told.windows(2).all(|pair| pair[1] == pair[0] + 1), "{told:?}");
        assert!(told.len() >= 59, "{}", told.len());
        assert!(rig.states.len() <= 161, "{}", rig.states.len());
        let sequences: Vec<u32> = rig.states.iter().map(|state| state.sequence).collect();
        assert!(sequences.windows(2).all(|pair| pair[1] == pair[0] + 1));
    }
}

#[test]
fn the_motions_that_the_arm_has_reached_are_told() {
    let mut rig = Rig::new(1_000, [NONE; 2]).following();
    rig.states.clear();
    rig.run_ms(1_000);
    let settled: Vec<Settled> = rig.states.iter().filter_map(|state| state.settled).collect();
    assert!(settled.windows(2).all(|pair| pair[0].sequence <= pair[1].sequence));
    let (first, last) = (settled[0], settled[settled.len() - 1]);
    assert!(last.sequence > first.sequence + 40, "{first:?} {last:?}");
    let mut after_us: Vec<u32> = settled.iter().map(|settled| settled.after_us).collect();
    after_us.sort_unstable();
    let median_us = after_us[after_us.len() / 2];
    // the servos of the simulated arm are some tens of milliseconds behind, and the governor is too
    assert!((5_000..400_000).contains(&median_us), "{median_us}");
    // at rest it ends where the hand is
    rig.speed_m_s = 0.0;
    rig.began_us = 0;
    rig.run_ms(50);
    let newest = rig.told().command.unwrap().sequence;
    rig.run_ms(3_000);
    assert!(rig.told().settled.unwrap().sequence > newest);
}

/// Somebody at the arm stops it; a reset that was asked for before the operator can know of it does nothing.
#[test]
fn a_reset_from_before_a_stop_at_the_arm_does_not_undo_it() {
    let stopped = |rig: &Rig| {
        assert_eq!(rig.state(), State::Stopped, "{:?}", rig.last.unwrap().step.decision.status);
    };
    // on its way when the arm is stopped
    let rig = Rig::new(10_000, [Faults { delay_us: 300_000, ..NONE }, NONE]);
    rig.operator.share_clock();
    rig.slave.carrier.share_clock();
    let mut rig = rig.following();
    rig.buttons.pressed = false;
    rig.buttons.resets += 1;
    rig.run_ms(100);
    rig.slave.stop();
    rig.run_ms(2_000);
    stopped(&rig);
    assert_eq!(rig.slave.take_refusal(), Some(NoReset::Outdated));
    rig.buttons.resets += 1;
    rig.run_ms(1_000);
    assert_eq!(rig.state(), State::Armed, "one that answers the stop ends it");

    // while the cable is cut, however long before the stop
    for stop_after_ms in [100, 1_500] {
        let mut rig = Rig::new(10_000, [NONE; 2]).following();
        rig.buttons.pressed = false;
        rig.run_ms(50);
        let now_us = rig.clock.now_us();
        rig.operator.set_faults(Faults { cut: Some((now_us, now_us + 2_000_000)), ..NONE });
        rig.run_ms(50);
        rig.buttons.resets += 1;
        rig.run_ms(stop_after_ms);
        rig.slave.stop();
        rig.run_ms(4_000);
        stopped(&rig);
        assert_eq!(rig.slave.take_refusal(), Some(NoReset::Outdated), "{stop_after_ms}");
        rig.buttons.resets += 1;
        rig.run_ms(500);
        assert_eq!(rig.state(), State::Armed);
    }
}

/// A burst of losses in which somebody stops the arm, shorter than any silence that is noticed.
#[test]
fn the_first_buttons_after_a_stop_at_the_arm_tell_only_what_was_asked_before() {
    let mut rig = Rig::new(10_000, [NONE; 2]).following();
    rig.buttons.pressed = false;
    rig.run_ms(50);
    rig.sends = (false, false);
    rig.buttons.resets += 1;
    rig.run_ms(40);
    rig.slave.stop();
    rig.run_ms(40);
    rig.sends = (true, true);
    rig.run_ms(1_000);
    assert_eq!(rig.state(), State::Stopped);
    assert_eq!(rig.slave.take_refusal(), Some(NoReset::Outdated));
}
