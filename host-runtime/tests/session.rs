//! `tetrad record` and `tetrad replay`: the same bits, and words where it cannot be.

mod common;

use common::{Clip, csv, tetrad};
use std::path::Path;
use std::{fs, io};

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

/// Where the other name of a session is, and what it is made with.
type Link = (&'static str, fn(&Path, &Path) -> io::Result<()>);

/// A copy has another content by and by, a link has the same.
fn links() -> Vec<Link> {
    let mut links: Vec<Link> = vec![("hard.mcap", |from, to| fs::hard_link(from, to))];
    #[cfg(unix)]
    links.push(("soft.mcap", |from, to| std::os::unix::fs::symlink(from, to)));
    links
}

#[test]
fn what_is_made_of_a_session_is_not_written_over_it_by_whatever_name() {
    let clip = Clip::of("still", 2);
    clip.tetrad(RECORD).done();
    let whole = fs::read(clip.path("session.mcap")).unwrap();
    let mut names = vec!["session.mcap", "./session.mcap", "left/../session.mcap"];
    for (name, link) in links() {
        link(&clip.path("session.mcap"), &clip.path(name)).unwrap();
        names.push(name);
    }
    for name in &names {
        let both = ["session.mcap", name, "same file", "give another file"];
        let refused = |arguments: String, flag: &str| {
            clip.tetrad(&arguments).refused(2, &[&[flag][..], &both].concat());
            assert!(fs::read(clip.path("session.mcap")).unwrap() == whole, "{arguments}");
        };
        refused(format!("replay --out out --report {name} session.mcap"), "--report");
        refused(format!("replay --out out --report session.mcap {name}"), "--report");
        let record = format!("record --left {name} --scene scene.json --out session.mcap");
        refused(record, "--out");
        refused(format!("learn --source session.mcap --find --yes --out {name}"), "--out");
        let pair = "learn --source session.mcap --right-source session.mcap --find --yes";
        refused(format!("{pair} --out new.toml --out-right {name}"), "--out-right");
        let track = "track --left session.mcap --right session.mcap --scene scene.json --out out";
        refused(format!("{track} --packets {name}"), "--packets");
    }
    assert!(!clip.path("out").exists() && !clip.path("new.toml").exists(), "nothing is begun");
    clip.tetrad("replay session.mcap --out out --report page.html").done();
    assert!(read(&clip, "page.html").contains("The balls"));
}

#[test]
fn a_session_among_the_results_is_not_written_over_either() {
    let clip = Clip::of("still", 2);
    clip.tetrad(RECORD).done();
    let whole = fs::read(clip.path("session.mcap")).unwrap();
    for (folder, name, flags) in [("out", "pose.csv", ""), ("more/recorded", "arm.csv", "--export-csv")] {
        fs::create_dir_all(clip.path(folder)).unwrap();
        fs::hard_link(clip.path("session.mcap"), clip.path(folder).join(name)).unwrap();
        let out = folder.split('/').next().unwrap();
        let first = format!("--out {folder}/{name}");
        let both = [first.as_str(), "the session session.mcap", "same file"];
        clip.tetrad(&format!("replay session.mcap --out {out} {flags}")).refused(2, &both);
    }
    let scene = fs::read(clip.path("scene.json")).unwrap();
    let own = RECORD.replace("session.mcap", "scene.json");
    clip.tetrad(&own).refused(2, &["--out scene.json and --scene scene.json", "same file"]);
    assert!(fs::read(clip.path("scene.json")).unwrap() == scene, "its places are still known");
    assert!(fs::read(clip.path("session.mcap")).unwrap() == whole);
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
