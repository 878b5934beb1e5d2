//! `tetrad record` and `tetrad replay`: the same bits, and words where it cannot be.

mod common;

use common::{Clip, csv, tetrad};
use std::fs;

const RECORD: &str = "record --left left --right right --scene scene.json --out session.mcap";

fn read(clip: &Clip, name: &str) -> String {
    fs::read_to_string(clip.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn a_session_replays_to_what_was_recorded_and_to_what_track_sees() {
    let clip = Clip::of("linear-0.25-10fps", 8);
    let ran = clip.tetrad(RECORD).done();
    assert!(ran.stdout.starts_with("8 frames of each camera recorded in session.mcap: "), "{ran:#?}");
    let ran = clip.tetrad("replay session.mcap --out replayed").done();
    for what in ["left observations", "right observations", "poses"] {
        let line = ran.stdout.lines().find(|line| line.starts_with(what));
        assert!(line.is_some_and(|line| line.contains(" 8 identical, hash ")), "{ran:#?}");
    }
    assert!(ran.stdout.starts_with("16 pictures tracked again"), "{ran:#?}");

    clip.tetrad("track --left left --right right --scene scene.json --out tracked").done();
    let session = "track --left session.mcap --right session.mcap --scene scene.json --out from_session";
    clip.tetrad(session).done();
    for file in ["observations.csv", "uncertainty.csv", "pose.csv", "filtered.csv", "motion.csv"] {
        let tracked = read(&clip, &format!("tracked/{file}"));
        assert!(tracked.lines().count() > 8, "{file}");
        for other in ["replayed", "from_session"] {
            assert!(read(&clip, &format!("{other}/{file}")) == tracked, "{other}/{file} is another");
        }
    }
}

#[test]
fn one_camera_of_a_session_is_a_source_as_well() {
    let clip = Clip::of("still", 3);
    clip.tetrad(RECORD).done();
    clip.tetrad("track --left session.mcap --scene scene.json --out out").done();
    assert_eq!(csv(&clip.path("out/observations.csv")).len(), 1 + 3 * 4);
    clip.tetrad("record --left left --scene scene.json --out one.mcap").done();
    let ran = clip.tetrad("replay one.mcap --out replayed").done();
    assert!(ran.stdout.contains("left observations") && !ran.stdout.contains("poses"), "{ran:#?}");
    clip.tetrad("track --left one.mcap --right one.mcap --scene scene.json --out out")
        .refused(2, &["one.mcap: no pictures of a right camera are recorded in it, only of: left"]);
}

#[test]
fn a_session_that_was_cut_short_is_replayed_as_far_as_it_goes() {
    let clip = Clip::of("linear-0.25-10fps", 8);
    clip.tetrad(RECORD).done();
    let whole = fs::read(clip.path("session.mcap")).unwrap();
    fs::write(clip.path("session.mcap"), &whole[..whole.len() * 2 / 3]).unwrap();
    let ran = clip.tetrad("replay session.mcap --out replayed").done();
    assert!(ran.stderr.contains("session.mcap: cut short"), "{ran:#?}");
    let steps = csv(&clip.path("replayed/pose.csv")).len() - 1;
    assert!((3..6).contains(&steps), "{steps} of 8");
    let session = "track --left session.mcap --right session.mcap --scene scene.json --out tracked";
    let ran = clip.tetrad(session).done();
    assert!(
        ran.stderr.contains("cut short") && ran.stdout.starts_with(&format!("{steps} frames")),
        "{ran:#?}"
    );
}

#[test]
fn a_bit_that_flipped_is_noticed() {
    let clip = Clip::of("still", 4);
    clip.tetrad(RECORD).done();
    let mut bytes = fs::read(clip.path("session.mcap")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(clip.path("session.mcap"), bytes).unwrap();
    clip.tetrad("replay session.mcap --out replayed")
        .refused(1, &["session.mcap: damaged at byte ", "check sum", "copy the file again"]);
    clip.tetrad("track --left session.mcap --scene scene.json --out out").refused(1, &["damaged at byte"]);
}

#[test]
fn bad_files_and_flags_are_named() {
    let clip = Clip::of("still", 2);
    fs::write(clip.path("words.mcap"), "no film").unwrap();
    clip.tetrad("replay words.mcap --out out").refused(1, &["words.mcap: no MCAP file"]);
    clip.tetrad("replay gone.mcap --out out").refused(1, &["cannot read gone.mcap"]);
    clip.tetrad("track --left words.mcap --scene scene.json --out out").refused(1, &["words.mcap"]);
    clip.tetrad(&format!("{RECORD} --seconds 0")).refused(2, &["--seconds 0", "above 0"]);
    let nowhere = RECORD.replace("session.mcap", "no/such/dir.mcap");
    clip.tetrad(&nowhere).refused(2, &["cannot write no/such/dir.mcap"]);
    clip.tetrad(RECORD).done();
    let own = "record --left session.mcap --right session.mcap --scene scene.json --out session.mcap";
    clip.tetrad(own).refused(2, &["--out session.mcap", "give another file"]);
    clip.tetrad("replay session.mcap --out out").done();
}

#[test]
fn a_scene_is_recorded_for_as_long_as_asked() {
    let clip = Clip::of("still", 1);
    let record = "record --left sim:still --right sim:still --scene scene.json --seconds 0.5 --out s.mcap";
    tetrad(&clip.path(""), record).done();
    let ran = clip.tetrad("replay s.mcap --out out").done();
    let frames = (clip.scene.fps * 0.5).ceil() as usize;
    assert!(ran.stdout.contains(&format!(" {frames} identical")), "{ran:#?}");
}
