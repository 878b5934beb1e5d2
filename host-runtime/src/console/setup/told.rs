//! What the page is told of the set-up.

use super::draft::{Draft, Lesson};
use super::{SetUp, SetUpPlace, colour_words, lock, may_set_up};
use crate::console::desk::Desk;
use serde::Serialize;
use tetrad_core::observation::Ball;
use tetrad_core::vision::frame::Rgb;

/// Everything at one moment.
#[derive(Debug, Serialize)]
pub(super) struct Told {
    cameras: Vec<CameraTold>,
    arm_mm: f64,
    /// The station's file; `None`: the length is kept until the end of the run.
    arm_file: Option<String>,
    /// Why this page may not set up now.
    not_now: Option<String>,
    /// What came of what was asked for.
    said: String,
}

#[derive(Debug, Serialize)]
struct CameraTold {
    name: String,
    /// Its place among the views.
    view: usize,
    here: bool,
    /// Why it cannot be taught here, or what came of the last search.
    said: String,
    /// Whether that search has failed.
    failed: bool,
    file: Option<String>,
    still: Option<StillTold>,
    /// Whether it is tracked with just this.
    in_use: bool,
    balls: Vec<BallTold>,
}

#[derive(Debug, Serialize)]
struct StillTold {
    number: u64,
    width: u16,
    height: u16,
}

#[derive(Debug, Serialize)]
struct BallTold {
    name: &'static str,
    /// How it is known; `None`: it is not.
    how: Option<&'static str>,
    reference: Option<ColourTold>,
    typical: Option<ColourTold>,
    background: Option<ColourTold>,
    diameter: Option<f32>,
    /// Where the tracker finds it in the still picture.
    found: Option<FoundTold>,
    /// In the still picture, in words.
    clash: Option<String>,
    clash_permille: Option<u16>,
}

#[derive(Debug, Serialize)]
struct ColourTold {
    rgb: [u8; 3],
    name: String,
}

#[derive(Debug, Serialize)]
struct FoundTold {
    u: f32,
    v: f32,
    diameter: f32,
}

impl Told {
    pub(super) fn of(set_up: &SetUp, desk: &Desk, page: Option<u64>, said: String) -> Self {
        let drafts = lock(&set_up.drafts);
        let cameras = set_up.cameras.iter().zip(drafts.iter()).enumerate();
        let cameras = cameras.map(|(view, (camera, draft))| {
            let (here, said, file, in_use) = match &camera.place {
                SetUpPlace::Here { handle, file, .. } => {
                    let file = file.as_ref().map(|file| file.display().to_string());
                    (true, draft.said(), file, handle.taught() == draft.taught())
                }
                SetUpPlace::Elsewhere(why) => (false, (*why).to_owned(), None, false),
            };
            let still = draft.still.as_ref().map(|still| {
                let (width, height) = still.picture.size();
                StillTold { number: still.number, width, height }
            });
            let balls = if here { balls(draft) } else { Vec::new() };
            let failed = matches!(draft.searched, Some(Err(_)));
            CameraTold { name: camera.name.clone(), view, here, said, failed, file, still, in_use, balls }
        });
        let cameras = cameras.collect();
        drop(drafts);
        Self {
            cameras,
            arm_mm: (f64::from(set_up.arm_m()) * 1e5).round() / 100.0,
            arm_file: set_up.file.as_ref().map(|file| file.display().to_string()),
            not_now: may_set_up(desk, page).err().map(|why| why.to_string()),
            said,
        }
    }
}

fn balls(draft: &Draft) -> Vec<BallTold> {
    Ball::ALL.into_iter().zip(&draft.lessons).map(|(ball, lesson)| told(ball, lesson.as_ref())).collect()
}

fn told(ball: Ball, lesson: Option<&Lesson>) -> BallTold {
    let reference = lesson.map(|lesson| lesson.colours.learnt.reference);
    let judged = lesson.and_then(|lesson| lesson.judged);
    BallTold {
        name: ball.name(),
        how: lesson.map(|lesson| lesson.how.words()),
        reference: reference.map(|of| colour(of.reference)),
        typical: reference.map(|of| colour(of.typical)),
        background: reference.map(|of| colour(of.background)),
        diameter: lesson.map(|lesson| lesson.colours.learnt.diameter),
        found: judged.and_then(|judged| judged.found).map(|disc| FoundTold {
            u: disc.centre.u,
            v: disc.centre.v,
            diameter: disc.diameter,
        }),
        clash: judged.map(|judged| match judged.found {
            Some(_) => judged.words(),
            None => format!("NOT FOUND in this picture; {}", judged.words()),
        }),
        clash_permille: judged.map(|judged| judged.clash_permille),
    }
}

fn colour(Rgb { r, g, b }: Rgb) -> ColourTold {
    ColourTold { rgb: [r, g, b], name: colour_words::name(Rgb { r, g, b }) }
}
