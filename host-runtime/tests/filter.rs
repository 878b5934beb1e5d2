//! filtered.csv: the pose as the filter gives it, and the flags that set it.

mod common;

use common::{Clip, csv, json, tetrad, write_png};
use std::ops::Range;

const FRAMES: usize = 40;

/// A hand in motion, its lenses covered in some frames.
fn clip(dark: Range<usize>) -> Clip {
    let clip = Clip::of("linear-0.25-30fps", FRAMES);
    let size = (u32::from(clip.scene.width), u32::from(clip.scene.height));
    let black = vec![0; 3 * (size.0 * size.1) as usize];
    for frame in dark {
        for view in ["left", "right"] {
            write_png(&clip.frame(view, frame), size, png::ColorType::Rgb, png::BitDepth::Eight, &black);
        }
    }
    clip
}

/// Rows of pose.csv and filtered.csv after the header, side by side.
fn poses(clip: &Clip, flags: &str) -> Vec<(Vec<String>, Vec<String>)> {
    clip.tetrad(&format!("track --left left --right right --scene scene.json --out out {flags}")).done();
    let [pose, filtered] = ["out/pose.csv", "out/filtered.csv"].map(|name| csv(&clip.path(name)));
    assert_eq!(pose[0], filtered[0], "the same columns");
    assert_eq!(pose.len(), filtered.len());
    pose.into_iter().zip(filtered).skip(1).collect()
}

fn is_measured(row: &[String]) -> bool {
    ["both", "three", "one"].contains(&row[14].as_str())
}

#[test]
fn with_smoothing_off_and_no_lead_what_is_measured_is_given_unchanged() {
    let clip = clip(20..27);
    let rows = poses(&clip, "--smoothing off");
    let (measured, unseen): (Vec<_>, Vec<_>) = rows.iter().partition(|(pose, _)| is_measured(pose));
    assert!(measured.len() > FRAMES / 2 && unseen.len() > 5, "{} and {}", measured.len(), unseen.len());
    for (pose, filtered) in measured {
        assert_eq!(pose, filtered);
    }
    for (pose, filtered) in unseen {
        assert_eq!(pose[14], filtered[14]);
        assert_eq!(filtered[2].is_empty(), pose[14] == "lost", "carried on until it is lost: {filtered:?}");
    }
    let pose_us = &json(&clip.path("out/summary.json"))["pose_us"];
    assert!(pose_us["p50"].as_f64().unwrap() > 0.0, "{pose_us}");
}

#[test]
fn smoothing_and_lead_change_what_is_given() {
    let clip = clip(0..0);
    let x = |flags| -> Vec<String> {
        poses(&clip, flags).into_iter().map(|(_, filtered)| filtered[2].clone()).collect()
    };
    let off = x("--smoothing off");
    let differ = |others: &[String]| off.iter().zip(others).filter(|(a, b)| a != b).count();
    for flags in
        ["", "--smoothing off --lead-ms 50", "--smoothing off --lead-ms 50 --prediction acceleration"]
    {
        assert!(differ(&x(flags)) > FRAMES / 2, "{flags}");
    }
    let dir = clip.dir.path();
    tetrad(dir, "demo --headless --lead-ms 201").refused(2, &["--lead-ms", "200"]);
    tetrad(dir, "demo --headless --smoothing kalman").refused(2, &["--smoothing", "one-euro"]);
}
