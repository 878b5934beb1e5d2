//! A VAL II controller as the project's notes on its terminal describe it; nothing here was taken
//! from the driver, nor does it use a line of it.
//!
//! 9600 baud 8N1; commands end in CR; every character is echoed; the prompt is a new line and `.`; a
//! question ends in `?`; an error text stands between asterisks. A controller that was switched on
//! asks about its floppy and whether to initialize, and has to be calibrated. Motion takes no time
//! here, unless it is held.

use std::collections::HashMap;
use std::mem;

/// Joint angles, degrees, as VAL counts them.
pub(crate) type Degrees = [f64; 6];

/// READY: straight up.
pub(crate) const READY: Degrees = [0.0, -90.0, 90.0, 0.0, 0.0, 0.0];

const PROMPT: &str = "\r\n.";

/// What the controller waits for.
#[derive(Clone, Debug, PartialEq)]
enum Waiting {
    Floppy,
    Initialize,
    Command,
    /// New joints for the point of this name.
    Change(String),
    SureToCalibrate,
    /// The end of a motion that is held.
    Motion,
}

/// The controller and its arm.
#[derive(Debug)]
pub(crate) struct Controller {
    waiting: Waiting,
    line: String,
    /// Typed while it did not listen.
    ahead: Vec<u8>,
    points: HashMap<String, Degrees>,
    joints: Degrees,
    calibrated: bool,
    speed: f64,
    /// Where the arm was moved to, in order.
    pub(crate) visited: Vec<Degrees>,
    /// What was typed, line by line.
    pub(crate) typed: Vec<String>,
    /// Knows PPOINT (V+).
    pub(crate) plus: bool,
    /// The next DO is refused with this text.
    pub(crate) refuse: Option<String>,
    /// Does not answer and does not listen.
    pub(crate) silent: bool,
    /// The character that is lost on its way here, from now on; and that on its way back.
    pub(crate) lose_in: Option<usize>,
    pub(crate) lose_out: Option<usize>,
    /// A motion does not end before it is released.
    pub(crate) hold: bool,
}

impl Controller {
    /// Switched on long ago, calibrated, at READY, its prompt printed.
    pub(crate) fn running() -> Self {
        Self {
            waiting: Waiting::Command,
            line: String::new(),
            ahead: Vec::new(),
            points: HashMap::new(),
            joints: READY,
            calibrated: true,
            speed: 100.0,
            visited: Vec::new(),
            typed: Vec::new(),
            plus: false,
            refuse: None,
            silent: false,
            lose_in: None,
            lose_out: None,
            hold: false,
        }
    }

    /// The same, of V+.
    pub(crate) fn plus() -> Self {
        Self { plus: true, ..Self::running() }
    }

    /// Where the arm is.
    pub(crate) fn joints(&self) -> Degrees {
        self.joints
    }

    /// What SPEED it was told.
    pub(crate) fn speed(&self) -> f64 {
        self.speed
    }

    /// Puts the arm somewhere by hand.
    pub(crate) fn put(&mut self, joints: Degrees) {
        self.joints = joints;
    }

    /// Switched off and on. Points and joints are forgotten. What it prints.
    pub(crate) fn restart(&mut self) -> Vec<u8> {
        (self.waiting, self.calibrated) = (Waiting::Floppy, false);
        self.line.clear();
        self.points.clear();
        self.carried(b"\r\nVAL-II boot\r\nLoad VAL-II from floppy (Y/N)? ".to_vec())
    }

    /// Prints something unasked.
    pub(crate) fn print(&mut self, text: &str) -> Vec<u8> {
        self.carried(text.as_bytes().to_vec())
    }

    /// The motion that is held ends. What it prints.
    pub(crate) fn release(&mut self) -> Vec<u8> {
        self.hold = false;
        if self.waiting != Waiting::Motion {
            return Vec::new();
        }
        self.waiting = Waiting::Command;
        let mut out = self.carried(format!("\r\n{PROMPT}").into_bytes());
        let ahead = mem::take(&mut self.ahead);
        out.extend(self.hear(&ahead));
        out
    }

    /// Takes what was typed; gives back what it prints.
    pub(crate) fn hear(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        for byte in bytes {
            if self.silent || count_down(&mut self.lose_in) {
                continue;
            }
            if self.waiting == Waiting::Motion {
                self.ahead.push(*byte);
                continue;
            }
            let printed = match byte {
                b'\r' => {
                    let line = mem::take(&mut self.line);
                    format!("\r\n{}", self.take(line))
                }
                _ => {
                    self.line.push(char::from(*byte));
                    char::from(*byte).to_string()
                }
            };
            out.extend(self.carried(printed.into_bytes()));
        }
        out
    }

    fn carried(&mut self, bytes: Vec<u8>) -> Vec<u8> {
        bytes.into_iter().filter(|_| !self.silent && !count_down(&mut self.lose_out)).collect()
    }

    fn take(&mut self, line: String) -> String {
        self.typed.push(line.clone());
        let line = line.trim().to_uppercase();
        match mem::replace(&mut self.waiting, Waiting::Command) {
            Waiting::Floppy if line == "N" => {
                self.waiting = Waiting::Initialize;
                "Initialize (Y/N)? ".to_owned()
            }
            Waiting::Floppy => {
                self.waiting = Waiting::Floppy;
                "Load VAL-II from floppy (Y/N)? ".to_owned()
            }
            Waiting::Initialize if line == "N" => PROMPT.to_owned(),
            Waiting::Initialize => {
                self.waiting = Waiting::Initialize;
                "Initialize (Y/N)? ".to_owned()
            }
            Waiting::SureToCalibrate => {
                if line == "Y" {
                    (self.calibrated, self.joints) = (true, READY);
                }
                PROMPT.to_owned()
            }
            Waiting::Change(_) if line.is_empty() => PROMPT.to_owned(),
            Waiting::Change(name) => {
                let Some(joints) = joints(&line) else {
                    self.waiting = Waiting::Change(name);
                    return "*Illegal value*\r\nCHANGE? ".to_owned();
                };
                self.points.insert(name.clone(), joints);
                self.waiting = Waiting::Change(name);
                format!("{}CHANGE? ", table(&joints))
            }
            Waiting::Command | Waiting::Motion => {
                let printed = self.command(&line);
                match self.waiting {
                    Waiting::Command => format!("{printed}{PROMPT}"),
                    _ => printed,
                }
            }
        }
    }

    fn command(&mut self, line: &str) -> String {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match word {
            "" => String::new(),
            "WHERE" => {
                let place = "      X        Y        Z        O        A        T\r\n   -20.32   149.09   921.12   90.000  -90.000    0.000\r\n";
                format!("{place}{}", table(&self.joints))
            }
            "SPEED" => match rest.parse() {
                Ok(speed) if (0.01..=327.0).contains(&speed) => {
                    self.speed = speed;
                    String::new()
                }
                _ => "*Illegal value*\r\n".to_owned(),
            },
            "POINT" if rest.starts_with('#') => {
                let joints = *self.points.entry(rest.to_owned()).or_insert(self.joints);
                self.waiting = Waiting::Change(rest.to_owned());
                format!("{}CHANGE? ", table(&joints))
            }
            "CAL" => {
                self.waiting = Waiting::SureToCalibrate;
                "Are you sure (Y/N)? ".to_owned()
            }
            "DO" => self.refuse.take().map_or_else(|| self.instruction(rest), |text| format!("{text}\r\n")),
            _ => "*Illegal monitor command*\r\n".to_owned(),
        }
    }

    fn instruction(&mut self, line: &str) -> String {
        if let Some(definition) = line.strip_prefix("SET ").filter(|_| self.plus) {
            let set = definition.split_once('=').and_then(|(name, value)| {
                let inner = value.strip_prefix("#PPOINT(")?.strip_suffix(')')?;
                Some((name.to_owned(), joints(inner)?))
            });
            return match set {
                Some((name, joints)) => {
                    self.points.insert(name, joints);
                    String::new()
                }
                None => "*Illegal value*\r\n".to_owned(),
            };
        }
        let to = match line {
            "READY" => Some(READY),
            _ => line.strip_prefix("MOVE ").and_then(|name| self.points.get(name)).copied(),
        };
        match to {
            _ if !self.calibrated => "*Arm not calibrated*\r\n".to_owned(),
            None => "*Undefined location*\r\n".to_owned(),
            Some(to) => {
                self.joints = to;
                self.visited.push(to);
                if self.hold {
                    self.waiting = Waiting::Motion;
                }
                String::new()
            }
        }
    }
}

/// Whether this is the one that is lost.
fn count_down(left: &mut Option<usize>) -> bool {
    match left {
        Some(0) => {
            *left = None;
            true
        }
        Some(left) => {
            *left -= 1;
            false
        }
        None => false,
    }
}

fn joints(text: &str) -> Option<Degrees> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    numbers.ok()?.try_into().ok()
}

fn table(joints: &Degrees) -> String {
    let row: String = joints.iter().map(|angle| format!("{angle:9.3}")).collect();
    format!("      JT1      JT2      JT3      JT4      JT5      JT6\r\n{row}\r\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(controller: &mut Controller, line: &str) -> String {
        String::from_utf8(controller.hear(format!("{line}\r").as_bytes())).unwrap()
    }

    #[test]
    fn a_session_as_the_notes_tell_it() {
        let mut controller = Controller::running();
        let boot = String::from_utf8(controller.restart()).unwrap();
        assert!(boot.ends_with("floppy (Y/N)? "), "{boot:?}");
        assert_eq!(said(&mut controller, "n"), "n\r\nInitialize (Y/N)? ");
        assert_eq!(said(&mut controller, "n"), "n\r\n\r\n.");
        assert!(said(&mut controller, "DO READY").contains("*Arm not calibrated*"));
        assert!(said(&mut controller, "CAL").ends_with("(Y/N)? "));
        assert_eq!(said(&mut controller, "y"), "y\r\n\r\n.");
        assert!(said(&mut controller, "POINT #P").ends_with("CHANGE? "));
        assert!(said(&mut controller, "1,-80,70,4,5,6").contains("   70.000"));
        assert_eq!(said(&mut controller, ""), "\r\n\r\n.");
        assert_eq!(said(&mut controller, "DO MOVE #P"), "DO MOVE #P\r\n\r\n.");
        assert_eq!(controller.visited, [[1.0, -80.0, 70.0, 4.0, 5.0, 6.0]]);
        assert!(said(&mut controller, "WHERE").contains("  -80.000   70.000"));
        assert!(said(&mut controller, "DO SET #P=#PPOINT(0,0,0,0,0,0)").contains("*Undefined"), "not VAL II");
    }

    #[test]
    fn half_a_line_is_finished_by_whoever_types_next() {
        let mut controller = Controller::running();
        said(&mut controller, "POINT #P");
        said(&mut controller, "");
        controller.hear(b"DO MOVE #P");
        controller.hear(b"\r");
        assert_eq!(controller.visited.len(), 1);
    }
}
