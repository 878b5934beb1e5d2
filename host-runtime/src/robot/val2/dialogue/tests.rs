//! What holds for every conversation; whole conversations stand in hil-fixtures/data/val2 and
//! tests/tests/val2.rs.

use super::*;
use proptest::prelude::*;

const READY_ANSWER: &str = "\r\n  JT1 JT2 JT3 JT4 JT5 JT6\r\n 0.0 -90.0 90.0 0.0 0.0 0.0\r\n\r\n.";

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// A dialogue with its own time, and what it has sent.
struct Talk {
    dialogue: Dialogue,
    now: Duration,
    sent: Vec<String>,
}

impl Talk {
    fn new(config: &Val2Config) -> Self {
        Self { dialogue: Dialogue::new(config, &PumaConfig::default()), now: ms(0), sent: Vec::new() }
    }

    fn collect(&mut self) {
        let output = self.dialogue.take_output();
        self.sent.extend(output.split_terminator('\r').map(str::to_owned));
    }

    fn enable(&mut self) {
        self.dialogue.enable();
        self.dialogue.begin(self.now);
        self.collect();
    }

    fn hear(&mut self, bytes: &[u8]) {
        self.dialogue.receive(bytes, self.now);
        self.wait(1);
    }

    fn wait(&mut self, time: u64) {
        self.now += ms(time);
        self.dialogue.tick(self.now);
        self.collect();
    }

    /// Answers what was sent last with its echo and `answer`.
    fn answer(&mut self, answer: &str) {
        let echo = self.sent.last().cloned().unwrap_or_default();
        self.hear(format!("{echo}{answer}").as_bytes());
    }

    fn last(&self) -> &str {
        self.sent.last().map_or("", String::as_str)
    }

    fn moves(&self) -> usize {
        self.sent.iter().filter(|line| line.contains("MOVE")).count()
    }

    /// Up to ready, at READY.
    fn ready(config: &Val2Config) -> Self {
        let mut talk = Self::new(config);
        talk.enable();
        talk.answer("\r\n*Illegal command*\r\n\r\n.");
        talk.wait(301);
        assert_eq!(talk.last(), "SPEED 30");
        talk.answer("\r\n\r\n.");
        talk.answer(READY_ANSWER);
        talk.answer(READY_ANSWER);
        assert_eq!(talk.dialogue.status(), PortStatus::Ready, "{:?}", talk.dialogue.reason());
        talk
    }

    fn at(&self) -> Joints<f64> {
        self.dialogue.read_joints(self.now).unwrap().joints
    }

    fn go(&mut self, by: f64) -> Result<(), PortError> {
        let from = self.dialogue.target.map_or(self.dialogue.sent, |(joints, _)| joints);
        let mut joints = from;
        joints[0] += by;
        let result = self.dialogue.write_set_point(&joints, self.now);
        self.wait(0);
        result
    }

    fn reason(&self) -> String {
        self.dialogue.reason().unwrap_or_default()
    }
}

fn one_line() -> Val2Config {
    Val2Config { dialect: Dialect::PPoint, ..Val2Config::default() }
}

#[test]
fn a_point_takes_four_lines_and_moves_after_the_last_prompt() {
    let mut talk = Talk::ready(&Val2Config::default());
    talk.go(0.03).unwrap();
    assert_eq!(talk.last(), "POINT #P");
    talk.answer("\r\n 0.00 0.00 0.00 0.00 0.00 0.00\r\nCHANGE?");
    assert_eq!(talk.last(), "1.72,-90.00,90.00,0.00,0.00,0.00");
    talk.answer("\r\n 1.72 -90.00 90.00 0.00 0.00 0.00\r\nCHANGE? ");
    assert_eq!((talk.last(), talk.moves()), ("", 0));
    talk.answer("\r\n\r\n.");
    assert_eq!((talk.last(), talk.moves()), ("DO MOVE #P", 1));
    talk.answer("\r\n\r\n.");
    let sent = talk.sent.len();
    talk.wait(10);
    assert_eq!(talk.sent.len(), sent, "the arm is where it should be");
    assert_eq!(talk.dialogue.status(), PortStatus::Ready);
}

#[test]
fn only_the_newest_of_many_set_points_is_sent() {
    let mut talk = Talk::ready(&one_line());
    talk.go(0.0).unwrap();
    for _ in 0..10 {
        talk.go(0.005).unwrap();
        talk.wait(10);
    }
    // the first of them went out, the others waited for the prompt
    assert!(talk.last().starts_with("DO SET #P=#PPOINT(0.29,"), "{:?}", talk.sent);
    talk.answer("\r\n\r\n.");
    talk.answer("\r\n\r\n.");
    assert!(talk.last().starts_with("DO SET #P=#PPOINT(2.86,"), "{:?}", talk.sent);
}

#[test]
fn a_stop_in_the_middle_of_a_point_sends_no_move() {
    let mut talk = Talk::ready(&Val2Config::default());
    talk.go(0.03).unwrap();
    talk.dialogue.stop();
    assert_eq!(talk.dialogue.status(), PortStatus::Stopped);
    talk.answer("\r\n 0 0 0 0 0 0\r\nCHANGE?");
    assert_eq!(talk.last(), "", "the question is answered, with no change");
    talk.answer("\r\n\r\n.");
    talk.wait(500);
    assert_eq!(talk.moves(), 0);
    assert_eq!(talk.go(0.0), Err(PortError::NotReady(PortStatus::Stopped)));
    assert_eq!(talk.dialogue.status(), PortStatus::Stopped);
}

#[test]
fn a_stop_in_a_move_says_that_the_controller_finishes_it() {
    let mut talk = Talk::ready(&one_line());
    talk.go(0.03).unwrap();
    talk.answer("\r\n\r\n.");
    assert_eq!(talk.last(), "DO MOVE #P");
    talk.dialogue.stop();
    assert!(talk.reason().contains("the controller finishes the move under way"), "{}", talk.reason());
    talk.answer("\r\n\r\n.");
    assert_eq!((talk.dialogue.status(), talk.dialogue.reason()), (PortStatus::Stopped, None));
}

#[test]
fn without_set_points_the_arm_is_stopped_by_name() {
    let mut talk = Talk::ready(&one_line());
    talk.wait(400);
    assert_eq!(talk.dialogue.status(), PortStatus::Ready, "before the first there is nothing to miss");
    talk.go(0.0).unwrap();
    talk.wait(501);
    assert_eq!(talk.dialogue.status(), PortStatus::Stopped);
    assert!(talk.reason().contains("no set-point came for 500 ms"), "{}", talk.reason());
}

#[test]
fn set_points_that_cannot_be_are_refused_and_the_last_one_stays() {
    let mut talk = Talk::ready(&one_line());
    assert_eq!(talk.go(0.05), Err(PortError::TooFar(1)), "the first is where the arm is");
    talk.go(0.01).unwrap();
    assert_eq!(talk.go(f64::NAN), Err(PortError::NotFinite(1)));
    assert_eq!(talk.go(3.0), Err(PortError::OutOfRange(1)));
    assert_eq!(talk.go(1.0), Err(PortError::TooFar(1)));
    talk.answer("\r\n\r\n.");
    assert_eq!(talk.moves(), 1);
    assert_eq!(talk.dialogue.status(), PortStatus::Ready);
}

#[test]
fn an_error_text_is_quoted_and_ends_it() {
    let mut talk = Talk::ready(&one_line());
    talk.go(0.03).unwrap();
    talk.answer("\r\n*Robot power is off*\r\n\r\n.");
    assert!(matches!(talk.dialogue.status(), PortStatus::Fault(_)));
    assert!(talk.reason().contains("*Robot power is off*"), "{}", talk.reason());
    let sent = talk.sent.len();
    talk.hear(b"\r\n.\r\n.");
    talk.wait(5000);
    assert_eq!((talk.sent.len(), talk.moves()), (sent, 0), "nothing is sent to it any more");
}

#[test]
fn an_echo_that_lacks_a_character_is_never_moved_to() {
    let mut talk = Talk::ready(&one_line());
    talk.go(0.03).unwrap();
    talk.hear(b"DO SET #P=#PPOINT(1.7,-90.00,90.00,0.00,0.00,0.00)\r\n\r\n.");
    assert_eq!((talk.dialogue.status(), talk.moves()), (PortStatus::Lost, 0));
    assert_eq!(talk.dialogue.read_joints(talk.now), Err(PortError::Nonsense));
    assert!(talk.reason().contains("echoed"), "{}", talk.reason());
}

#[test]
fn silence_is_a_loss_that_enabling_ends() {
    let mut talk = Talk::ready(&one_line());
    talk.go(0.03).unwrap();
    talk.wait(2001);
    assert_eq!(talk.dialogue.status(), PortStatus::Lost);
    assert!(talk.reason().contains("did not answer \"DO SET"), "{}", talk.reason());
    // what comes late is not taken up
    talk.answer("\r\n\r\n.");
    assert_eq!(talk.moves(), 0);
    talk.enable();
    talk.answer("\r\n*?*\r\n.");
    talk.wait(301);
    assert_eq!(talk.last(), "SPEED 30");
}

#[test]
fn attention_is_asked_for_three_times() {
    let mut talk = Talk::new(&one_line());
    talk.enable();
    (0..3).for_each(|_| talk.wait(2001));
    assert_eq!(talk.sent, ["QQQ", "QQQ", "QQQ"]);
    assert_eq!(talk.dialogue.status(), PortStatus::Lost);
}

#[test]
fn what_came_before_the_first_words_does_not_count_but_a_restart_is_remembered() {
    let mut talk = Talk::new(&one_line());
    talk.dialogue.enable();
    talk.hear(b"VAL-II boot\r\n*x*\xffInitialize (Y/N)?");
    assert_eq!(talk.dialogue.status(), PortStatus::Enabling);
    talk.dialogue.begin(talk.now);
    talk.collect();
    talk.answer("\r\n*Illegal command*\r\n\r\n.");
    talk.wait(301);
    assert_eq!(talk.dialogue.status(), PortStatus::NotHomed);
}

#[test]
fn a_restart_is_a_loss_and_then_wants_a_calibration() {
    let mut talk = Talk::ready(&one_line());
    talk.hear(b"\r\nVAL-II\r\n");
    assert_eq!(talk.dialogue.status(), PortStatus::Lost, "nobody asked for that");
    talk.hear(b"Load VAL-II from floppy (Y/N)?");
    talk.enable();
    talk.answer("\r\nLoad VAL-II from floppy (Y/N)?");
    assert_eq!(talk.last(), "n");
    talk.answer("\r\nInitialize (Y/N)?");
    assert_eq!(talk.last(), "n");
    talk.answer("\r\n\r\n.");
    talk.wait(301);
    assert_eq!(talk.dialogue.status(), PortStatus::NotHomed);
    assert!(talk.reason().contains("calibrate=yes"), "{}", talk.reason());
    // enabling again does not make it calibrated
    talk.enable();
    talk.answer("\r\n*?*\r\n.");
    talk.wait(301);
    assert_eq!(talk.dialogue.status(), PortStatus::NotHomed);
    assert!(!talk.sent.iter().any(|line| line == "CAL"));
}

#[test]
fn the_arm_is_calibrated_only_where_that_was_asked_for() {
    let mut talk = Talk::new(&Val2Config { calibrate: true, ..one_line() });
    talk.enable();
    talk.answer("\r\nInitialize (Y/N)?");
    talk.answer("\r\n\r\n.");
    talk.wait(301);
    assert_eq!(talk.last(), "CAL");
    talk.answer("\r\nAre you sure (Y/N)?");
    assert_eq!(talk.last(), "y");
    talk.wait(30_000);
    talk.answer("\r\n\r\n.");
    assert_eq!(talk.last(), "SPEED 30");

    // an arm that says so only when it is asked where it is
    let mut talk = Talk::new(&Val2Config { calibrate: true, ..one_line() });
    talk.enable();
    talk.answer("\r\n*?*\r\n.");
    talk.wait(301);
    talk.answer("\r\n\r\n.");
    talk.answer("\r\n*Arm not calibrated*\r\n\r\n.");
    assert_eq!(talk.last(), "CAL");
    talk.answer("\r\n*Arm not calibrated*\r\n\r\n.");
    assert_eq!(talk.dialogue.status(), PortStatus::NotHomed, "once is enough");
}

#[test]
fn where_the_arm_is_counts_when_two_answers_agree() {
    let mut talk = Talk::new(&one_line());
    talk.enable();
    talk.answer("\r\n*?*\r\n.");
    talk.wait(301);
    talk.answer("\r\n\r\n.");
    talk.answer("\r\n 0 -9 90 0 0 0\r\n.");
    talk.answer(READY_ANSWER);
    assert_eq!(talk.dialogue.status(), PortStatus::Enabling, "a digit was lost");
    talk.answer(READY_ANSWER);
    assert_eq!(talk.dialogue.status(), PortStatus::Ready);
    assert!((talk.at()[1] - 90.0_f64.to_radians()).abs() < 1e-12);
}

#[test]
fn an_unknown_question_is_not_answered() {
    let mut talk = Talk::ready(&one_line());
    talk.go(0.03).unwrap();
    let sent = talk.sent.len();
    talk.answer("\r\nOverwrite (Y/N)?");
    assert!(matches!(talk.dialogue.status(), PortStatus::Fault(_)));
    assert!(talk.reason().contains("Overwrite (Y/N)?"), "{}", talk.reason());
    assert_eq!(talk.sent.len(), sent);
}

#[test]
fn an_arm_that_is_held_is_noticed_at_the_next_reading() {
    let mut talk = Talk::ready(&Val2Config { where_period: ms(100), ..one_line() });
    talk.wait(100);
    assert_eq!(talk.last(), "WHERE");
    talk.answer("\r\n 60 -90 90 0 0 0\r\n.");
    assert_eq!(talk.dialogue.status(), PortStatus::Lost);
    assert!(talk.reason().contains("joint 1 is not where it was sent"), "{}", talk.reason());
}

/// What a line may bring: words that mean something, in any order, and any bytes.
fn pieces() -> impl Strategy<Value = Vec<Vec<u8>>> {
    let known = prop::sample::select(vec![
        "\r\n.",
        "\r\n",
        "DO MOVE #P\r\n",
        "WHERE\r\n 0 -90 90 0 0 0\r\n.",
        "CHANGE?",
        "POINT #P\r\n",
        "*Envelope error*",
        "Initialize (Y/N)?",
        "QQQ\r\n",
        "1 2 3",
        "echo",
    ]);
    let known = known.prop_map(|text| text.as_bytes().to_vec());
    prop::collection::vec(prop_oneof![3 => known, 1 => prop::collection::vec(any::<u8>(), 0..40)], 0..30)
}

proptest! {
    /// Whatever comes, at whatever time: no panic, and after the first thing that is not understood
    /// nothing is sent until it is enabled anew.
    #[test]
    fn nothing_moves_after_what_is_not_understood(pieces in pieces(), echoes in any::<u64>(), ppoint in any::<bool>()) {
        let config = if ppoint { one_line() } else { Val2Config::default() };
        let mut talk = Talk::ready(&config);
        for (turn, piece) in pieces.iter().enumerate() {
            let _ = talk.go(0.001);
            let before = (talk.dialogue.status(), talk.sent.len());
            if echoes >> (turn % 64) & 1 == 1 {
                talk.answer("\r\n");
            }
            talk.hear(piece);
            talk.wait(20);
            if before.0 != PortStatus::Ready {
                prop_assert_eq!(before, (talk.dialogue.status(), talk.sent.len()));
            }
        }
    }

    /// A byte lost or changed anywhere on the way back, from enabling on: no point is moved to whose
    /// echo did not come whole.
    #[test]
    fn a_damaged_byte_never_moves_the_arm(at in 0_usize..900, with in prop::option::of(any::<u8>())) {
        let mut talk = Talk::new(&one_line());
        talk.enable();
        let mut passed = 0;
        for _ in 0..30 {
            talk.wait(301);
            let Some(sent) = talk.sent.last().cloned() else { break };
            let answer = match sent.as_str() {
                "QQQ" => "\r\n*Illegal command*\r\n\r\n.",
                "WHERE" => READY_ANSWER,
                _ => "\r\n\r\n.",
            };
            let moves = talk.moves();
            let mut came = Vec::new();
            for byte in format!("{sent}{answer}").into_bytes() {
                passed += 1;
                came.extend(if passed == at { with } else { Some(byte) });
            }
            talk.hear(&came);
            if talk.moves() > moves {
                // blanks and the bell mean nothing
                came.retain(u8::is_ascii_graphic);
                let came = String::from_utf8_lossy(&came).to_uppercase();
                let point = sent.replace(' ', "");
                prop_assert!(point.starts_with("DOSET") && came.contains(&point), "{sent:?} {came:?}");
            }
            let _ = talk.go(0.02);
        }
        // and without damage it goes on
        prop_assert!(at != 0 || talk.moves() > 5, "{:?}", talk.sent);
    }
}
