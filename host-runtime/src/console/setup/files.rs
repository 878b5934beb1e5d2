//! The station's files: each camera's colours, and the arms' length in the operator's tetrad.toml.

use super::Local;
use super::refused::Refused;
use crate::balls::BallSet;
use crate::colours::Colours;
use crate::text_file;
use serde::Deserialize;
use std::path::Path;
use tetrad_core::config::{MAX_ARM_M, MIN_ARM_M};
use toml::Spanned;

/// What of tetrad.toml is of interest here.
#[derive(Deserialize)]
struct Station {
    operator: Operator,
}

#[derive(Deserialize)]
struct Operator {
    arm_mm: Spanned<f64>,
}

/// The colours of a text, all four balls; `file` is for messages.
pub(super) fn colours(text: &str, file: &str) -> Result<Colours, Refused> {
    let colours = Colours::parse(text, file).and_then(|colours| colours.select(BallSet::ALL, file));
    colours.map_err(|error| Refused::Wrong(error.to_string()))
}

/// The file that keeps a camera's colours.
pub(super) fn kept<'a>(camera: &Local<'a>) -> Result<&'a Path, Refused> {
    camera.file.map(std::path::PathBuf::as_path).ok_or_else(|| {
        let mend = "download them, and name the file in its [[operator.camera]] as colours = \"FILE\"";
        Refused::Wrong(format!("{}: no file keeps its colours: {mend}", camera.name))
    })
}

/// Reads a camera's colours.
pub(super) fn load(file: &Path) -> Result<Colours, Refused> {
    let label = file.display().to_string();
    let text = text_file::read(file).map_err(|cause| {
        Refused::Wrong(format!("cannot read {label}: {cause}; save colours first, or upload some"))
    })?;
    colours(&text, &label)
}

/// Writes a camera's colours.
pub(super) fn save(file: &Path, colours: &Colours) -> Result<(), Refused> {
    write(file, &colours.to_toml())
}

/// A length in metres, of one in millimetres that somebody entered.
pub(super) fn arm_m(mm: f64) -> Result<f32, Refused> {
    let (least, most) = ((MIN_ARM_M * 1000.0).round(), (MAX_ARM_M * 1000.0).round());
    if (f64::from(least)..=f64::from(most)).contains(&mm) {
        Ok((mm / 1000.0) as f32)
    } else {
        let needed = format!("[operator] arm_mm: a number from {least} to {most} mm is needed, not {mm}");
        Err(Refused::Wrong(needed))
    }
}

/// Writes the arms' length into the station's file, of which everything else stays as it is.
pub(super) fn save_arm(file: &Path, mm: f64) -> Result<(), Refused> {
    let label = file.display();
    let text =
        text_file::read(file).map_err(|cause| Refused::Failed(format!("cannot read {label}: {cause}")))?;
    let changed = with_arm(&text, mm).map_err(|problem| Refused::Wrong(format!("{label}: {problem}")))?;
    write(file, &changed)
}

/// The text with another length.
fn with_arm(text: &str, mm: f64) -> Result<String, String> {
    let station =
        |text: &str| toml::from_str::<Station>(text).map_err(|error| error.to_string().trim_end().to_owned());
    let span = station(text)?.operator.arm_mm.span();
    let mut changed = text.to_owned();
    if changed.get(span.clone()).is_none() {
        return Err("[operator] arm_mm: its place is not found".to_owned());
    }
    changed.replace_range(span, &mm.to_string());
    // written is what is read
    let read = *station(&changed)?.operator.arm_mm.get_ref();
    if read == mm { Ok(changed) } else { Err(format!("[operator] arm_mm: it would be read as {read}")) }
}

fn write(file: &Path, text: &str) -> Result<(), Refused> {
    let label = file.display();
    text_file::replace(file, text).map_err(|cause| Refused::Failed(format!("cannot write {label}: {cause}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "# the hand\n[operator]\narm_mm = 80   # measured\nslave = \"here\"\n[[operator.camera]]\n\
                        source = \"sim:demo\"\n";

    #[test]
    fn only_the_length_changes() {
        let changed = with_arm(FILE, 62.5).unwrap();
        assert_eq!(changed, FILE.replace("80", "62.5"));
        assert_eq!(with_arm(&changed, 80.0).unwrap(), FILE);
        let inline = "operator = { slave = \"here\", arm_mm = 8e1 }\n";
        assert_eq!(with_arm(inline, 100.0).unwrap(), inline.replace("8e1", "100"));
    }

    #[test]
    fn a_file_without_a_length_is_left_alone() {
        assert!(with_arm("[operator]\nslave = \"here\"\n", 80.0).unwrap_err().contains("arm_mm"));
        assert!(with_arm("[operator", 80.0).is_err());
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("tetrad.toml");
        assert!(matches!(save_arm(&file, 80.0), Err(Refused::Failed(why)) if why.contains("tetrad.toml")));
        std::fs::write(&file, FILE).unwrap();
        save_arm(&file, 90.0).unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), FILE.replace("80", "90"));
    }

    #[test]
    fn lengths_have_the_bounds_of_the_file() {
        assert_eq!(arm_m(80.0), Ok(0.08));
        for mm in [0.0, 4.9, 2001.0, f64::NAN, f64::INFINITY] {
            let Err(Refused::Wrong(why)) = arm_m(mm) else { panic!("{mm}") };
            assert!(why.starts_with("[operator] arm_mm: a number from 5 to 2000 mm"), "{why}");
        }
    }
}
