//! Plays a golden script (hil-fixtures/data/val2, README there) to the conversation.

use std::path::Path;
use std::time::Duration;
use tetrad::robot::val2::{Dialogue, Val2Config, parse};
use tetrad_core::config::PumaConfig;

/// The script's text with every byte that was sent as it was really sent.
pub(crate) fn play(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut settings = Val2Config::default();
    let mut dialogue = Dialogue::new(&settings, &PumaConfig::default());
    let mut now = Duration::ZERO;
    let mut told = String::new();
    for (number, line) in (1..).zip(text.lines()) {
        let wrong = || -> ! { panic!("{}:{number}: {line}: cannot be read", path.display()) };
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        let mut said = line.to_owned();
        match word {
            "" | "#" => {}
            "settings" => {
                settings = parse(&format!("val2:x?{rest}"), &settings).unwrap_or_else(|_| wrong()).1;
                dialogue = Dialogue::new(&settings, &PumaConfig::default());
            }
            "enable" => {
                dialogue.enable();
                dialogue.begin(now);
            }
            "stop" => dialogue.stop(),
            "wait" => {
                now += Duration::from_millis(rest.parse().unwrap_or_else(|_| wrong()));
                dialogue.tick(now);
            }
            // the model's degrees
            "set" => {
                let (asked, _) = line.split_once(" ! ").unwrap_or((line, ""));
                let degrees =
                    asked.split([' ', ',']).skip(1).map(|angle| angle.parse().unwrap_or_else(|_| wrong()));
                let degrees: Vec<f64> = degrees.collect();
                let joints: [f64; 6] = degrees.try_into().unwrap_or_else(|_| wrong());
                let joints = joints.map(f64::to_radians);
                said = match dialogue.write_set_point(&joints, now) {
                    Ok(()) => asked.to_owned(),
                    Err(error) => format!("{asked} ! {error:?}"),
                };
                dialogue.tick(now);
            }
            "<" => {
                dialogue.receive(&unescaped(rest), now);
                dialogue.tick(now);
            }
            // what is really sent is put in its place
            ">" => {
                let sent = format!("> {}", dialogue.take_output().as_bytes().escape_ascii());
                said = sent.trim_end().to_owned();
            }
            "is" => {
                let reason = dialogue.reason().map(|reason| format!(": {reason}")).unwrap_or_default();
                said = format!("is {:?}{reason}", dialogue.status());
            }
            _ => wrong(),
        }
        told.push_str(&said);
        told.push('\n');
    }
    assert_eq!(dialogue.take_output(), "", "{}: more was sent than the script has", path.display());
    told
}

fn unescaped(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(match (byte, byte == b'\\') {
            (_, true) => match rest.next() {
                Some(b'r') => b'\r',
                Some(b'n') => b'\n',
                Some(b'x') => {
                    let digits: String = rest.by_ref().take(2).map(char::from).collect();
                    u8::from_str_radix(&digits, 16).expect("two hexadecimal digits")
                }
                Some(other) => other,
                None => b'\\',
            },
            (plain, false) => plain,
        });
    }
    bytes
}
