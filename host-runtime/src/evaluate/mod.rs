//! Section 5 of the paper, run again on simulated scenes whose truth is known: `paper` and `refined`
//! on the same pictures.
//!
//! ```text
//! plan -> cases (scene, variants) -> run: render, track -> traces -> one section an experiment -> report
//! ```
//!
//! [`run`] tracks one scene and hands on every frame, [`trace`] keeps what errors are made of, `pool`
//! runs the cases of all experiments on all cores. Each experiment is a file with two functions: which
//! cases it needs, and what it makes of their traces. The same seed gives the same tables to the byte,
//! but for those of times.

mod backdrops;
mod conditions;
mod delays;
mod drift;
mod dynamic;
mod headline;
mod paths;
mod pool;
pub mod run;
mod scans;
mod scenes;
pub mod sensor;
mod smoothing;
mod static_centre;
mod statistics;
pub mod trace;
mod uncertainty;

use crate::report::{Report, Section};
use headline::Headline;
pub use headline::broken_promises;
use run::RunError;
use trace::{Case, Trace};

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Another seed is other noise.
    pub seed: u64,
    /// Fewer frames and cases, for a look.
    pub quick: bool,
    /// Of no scene more frames than that: for tests, whose figures nobody reads.
    pub most_frames: Option<usize>,
}

impl Plan {
    /// The plan of a seed.
    #[must_use]
    pub const fn new(seed: u64, quick: bool) -> Self {
        Self { seed, quick, most_frames: None }
    }
}

impl Plan {
    /// One of two, the second when quick.
    fn pick<T>(self, full: T, quick: T) -> T {
        if self.quick { quick } else { full }
    }
}

/// What each variant of a case came to.
struct Traced {
    case: Case,
    traces: Vec<Trace>,
}

/// What an experiment came to.
struct Outcome {
    section: Section,
    headlines: Vec<Headline>,
}

/// Which cases an experiment needs, and what it makes of their traces.
struct Experiment {
    cases: fn(Plan) -> Vec<Case>,
    outcome: fn(Plan, &[Traced]) -> Result<Outcome, RunError>,
}

/// In the order of the page.
const EXPERIMENTS: [Experiment; 10] = [
    Experiment { cases: scans::cases, outcome: scans::outcome },
    Experiment {
        cases: static_centre::cases,
        outcome: |plan, traced| Ok(static_centre::outcome(plan, traced)),
    },
    Experiment { cases: dynamic::cases, outcome: |plan, traced| Ok(dynamic::outcome(plan, traced)) },
    Experiment { cases: paths::cases, outcome: |plan, traced| Ok(paths::outcome(plan, traced)) },
    Experiment { cases: drift::cases, outcome: |plan, traced| Ok(drift::outcome(plan, traced)) },
    Experiment { cases: conditions::cases, outcome: |plan, traced| Ok(conditions::outcome(plan, traced)) },
    Experiment { cases: backdrops::cases, outcome: |plan, traced| Ok(backdrops::outcome(plan, traced)) },
    Experiment { cases: uncertainty::cases, outcome: |plan, traced| Ok(uncertainty::outcome(plan, traced)) },
    Experiment { cases: smoothing::cases, outcome: |plan, traced| Ok(smoothing::outcome(plan, traced)) },
    Experiment { cases: delays::cases, outcome: |plan, traced| Ok(delays::outcome(plan, traced)) },
];

/// All cases of all experiments, ready to run.
pub struct Evaluation {
    plan: Plan,
    cases: Vec<Vec<Case>>,
}

impl Evaluation {
    /// The cases of a plan.
    #[must_use]
    pub fn new(plan: Plan) -> Self {
        let mut cases: Vec<Vec<Case>> =
            EXPERIMENTS.iter().map(|experiment| (experiment.cases)(plan)).collect();
        for case in cases.iter_mut().flatten() {
            case.frames = plan.most_frames.map_or(case.frames, |most| case.frames.min(most));
        }
        Self { plan, cases }
    }

    /// How many frames will be told of.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.cases.iter().flatten().map(|case| case.frames as u64).sum()
    }

    /// Runs everything; `each` is told of every frame, from several threads.
    ///
    /// # Errors
    /// [`RunError`] naming the scene that could not be tracked.
    pub fn run(self, each: &(impl Fn() + Sync)) -> Result<Report, RunError> {
        let Self { plan, cases } = self;
        let counts: Vec<usize> = cases.iter().map(Vec::len).collect();
        let mut traced = pool::run(cases.into_iter().flatten().collect(), each)?.into_iter();
        let mut sections = Vec::new();
        let mut headlines = Vec::new();
        for (experiment, count) in EXPERIMENTS.iter().zip(counts) {
            let own: Vec<Traced> = traced.by_ref().take(count).collect();
            let outcome = (experiment.outcome)(plan, &own)?;
            sections.push(outcome.section);
            headlines.extend(outcome.headlines);
        }
        Ok(Report {
            title: "Tetrad: section 5 of the paper, run again".to_owned(),
            lead: lead(plan),
            about: about(),
            headlines: headline::table(&headlines),
            sections,
        })
    }
}

fn lead(plan: Plan) -> String {
    let quick = if plan.quick { " --quick" } else { "" };
    format!(
        "\u{201c}A 3D Vision-Based Man-Machine Interface for Telerobotics\u{201d} (Al-Mouhamed, Toker, Al-Harthy), \
         on simulated scenes with exact truth. Seed {0}; again: tetrad evaluate --seed {0}{quick} --out DIR",
        plan.seed
    )
}

fn about() -> Vec<String> {
    vec![
        "\u{201c}refined\u{201d} is Tetrad's own method, \u{201c}paper mode\u{201d} the paper's as built here; both \
         track the same pictures: 640x480 pixels, two cameras about 1 m from the hand, balls of 20 mm on arms \
         of 80 mm, noise of 2 grey levels, before a light and smooth backdrop, unless a section says otherwise. \u{201c}At most\u{201d} is the \
         largest error of all. A share measured is told where it is below 100 %, of several runs the \
         lowest; a figure that is missing keeps no promise."
            .to_owned(),
        "Simulated pictures are kinder than real ones: pinhole cameras without distortion, a pixel's value \
         proportional to its light, no colour filter array and no compression, both cameras at the same \
         instant. What a soft lens, a colour filter array and a tone curve cost is measured below. The \
         paper's own figures are of real cameras and of the path of a robot."
            .to_owned(),
    ]
}
