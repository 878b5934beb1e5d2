//! What is set up of one camera and not used yet: a still picture, and what was learnt.

use crate::colours::{BallColours, Colours, Origin};
use crate::learning::{self, Disc, Judged, judge};
use crate::scene_file::Seeds;
use crate::station::camera::{Still, Taught};
use std::sync::Arc;
use tetrad_core::config::{LearnConfig, ProposeConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::frame::FrameView;
use tetrad_core::vision::learn::propose::propose;

/// How a ball came to be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum How {
    InUse,
    Found,
    Pointed,
    Loaded,
}

impl How {
    pub(super) const fn words(self) -> &'static str {
        match self {
            Self::InUse => "in use",
            Self::Found => "found",
            Self::Pointed => "pointed at",
            Self::Loaded => "from a file",
        }
    }
}

/// What is known of one ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lesson {
    pub(super) colours: BallColours,
    pub(super) how: How,
    /// In the still picture; `None` without one.
    pub(super) judged: Option<Judged>,
}

impl Lesson {
    const fn new(colours: BallColours, how: How) -> Self {
        Self { colours, how, judged: None }
    }
}

/// A picture that stands still.
#[derive(Clone, Debug)]
pub(super) struct StillPicture {
    /// Counts the stills of this run.
    pub(super) number: u64,
    pub(super) picture: Arc<Still>,
}

/// See the [module's text](self).
#[derive(Clone, Debug, Default)]
pub(super) struct Draft {
    pub(super) still: Option<StillPicture>,
    pub(super) lessons: [Option<Lesson>; BALLS],
    /// Where they were learnt, for the file.
    pub(super) origin: Option<Origin>,
    /// What came of the last search, in words, where nothing else was learnt or shown since.
    pub(super) searched: Option<Result<String, String>>,
}

impl Draft {
    /// What a camera looks for already.
    pub(super) fn in_use(taught: &Taught) -> Self {
        let lesson = |learnt| Lesson::new(BallColours { learnt, at: None }, How::InUse);
        Self { lessons: taught.map(|learnt| learnt.map(lesson)), ..Self::default() }
    }

    /// The same, looked at in another picture.
    pub(super) fn with_still(mut self, still: StillPicture) -> Self {
        self.still = Some(still);
        self.searched = None;
        self.judge(&Seeds::default());
        self
    }

    /// The balls as a tracker takes them.
    pub(super) fn taught(&self) -> Taught {
        self.lessons.map(|lesson| lesson.map(|lesson| lesson.colours.learnt))
    }

    /// The first ball of which nothing is known.
    pub(super) fn missing(&self) -> Option<Ball> {
        Ball::ALL.into_iter().find(|ball| self.lessons[ball.index()].is_none())
    }

    /// What came of the last search, in words.
    pub(super) fn said(&self) -> String {
        match &self.searched {
            Some(Ok(said) | Err(said)) => said.clone(),
            None => String::new(),
        }
    }

    /// Whether the last search found all four.
    pub(super) fn was_found(&self) -> bool {
        matches!(self.searched, Some(Ok(_)))
    }

    /// Nothing was found in the still picture; what was known before is judged in it, wherever it is there.
    fn was_not_found(&mut self, why: String) {
        self.searched = Some(Err(why));
        self.judge(&Seeds::default());
    }

    /// What is kept in a file.
    pub(super) fn to_colours(&self) -> Colours {
        Colours {
            balls: self.lessons.map(|lesson| lesson.map(|lesson| lesson.colours)),
            origin: self.origin.clone(),
        }
    }

    /// Colours of a file in place of these.
    pub(super) fn load(&mut self, colours: &Colours) {
        self.lessons = colours.balls.map(|ball| ball.map(|ball| Lesson::new(ball, How::Loaded)));
        self.origin.clone_from(&colours.origin);
        self.searched = None;
        self.judge(&Seeds::default());
    }

    /// Learns the ball that is at this place of the still picture.
    ///
    /// # Errors
    /// Why nothing is learnt there, in words; what was known before stays.
    pub(super) fn point(&mut self, ball: Ball, at: ImagePoint, source: &str) -> Result<(), String> {
        let Some(still) = self.still.clone() else { return Ok(()) };
        let frame = still.picture.view().map_err(|error| error.to_string())?;
        let mut seeds = Seeds::default();
        seeds[ball.index()] = Some(at);
        let taught = learning::learn_at(&frame, &seeds, &LearnConfig::default());
        let taught = taught.map_err(|refused| refused.to_string())?;
        let Some(learnt) = &taught[ball.index()] else { return Ok(()) };
        self.lessons[ball.index()] = Some(Lesson::new(learning::as_colours(learnt), How::Pointed));
        self.of(&still, source);
        self.searched = None;
        self.judge_in(&frame, &self.places());
        Ok(())
    }

    /// Where the balls were found before in the still picture, or were pointed at.
    fn places(&self) -> Seeds {
        self.lessons.map(|lesson| {
            let lesson = lesson?;
            match lesson.judged {
                Some(judged) => judged.found.map(|disc: Disc| disc.centre),
                None => lesson.colours.at,
            }
        })
    }

    fn of(&mut self, still: &StillPicture, source: &str) {
        let frame = u64::from(still.picture.packet.sequence);
        self.origin = Some(Origin { source: source.to_owned(), frame });
    }

    fn judge(&mut self, places: &Seeds) {
        // what was judged before was of another picture
        self.lessons.iter_mut().flatten().for_each(|lesson| lesson.judged = None);
        let Some(still) = self.still.clone() else { return };
        if let Ok(frame) = still.picture.view() {
            self.judge_in(&frame, places);
        }
    }

    fn judge_in(&mut self, frame: &FrameView<'_>, places: &Seeds) {
        let judged = judge(frame, &self.taught(), places);
        for (lesson, judged) in self.lessons.iter_mut().zip(judged) {
            if let Some(lesson) = lesson {
                lesson.judged = judged;
            }
        }
    }
}

/// Looks for all four balls in the still pictures of these drafts, which are of cameras that see the same
/// frame; whatever a camera does not show stays as it was known.
pub(super) fn find(drafts: &mut [(Draft, String)]) {
    let stills: Vec<_> = drafts.iter().filter_map(|(draft, _)| draft.still.clone()).collect();
    let views: Vec<_> = stills.iter().filter_map(|still| still.picture.view().ok()).collect();
    if views.len() != drafts.len() {
        for (draft, _) in drafts {
            draft.was_not_found("the pictures cannot be searched".to_owned());
        }
        return;
    }
    let proposal = propose(&views, &ProposeConfig::default());
    for (((draft, source), found), (still, view)) in
        drafts.iter_mut().zip(&proposal.views).zip(stills.iter().zip(&views))
    {
        match &found.balls {
            Ok(balls) => {
                draft.lessons = balls
                    .each_ref()
                    .map(|learnt| Some(Lesson::new(learning::as_colours(learnt), How::Found)));
                draft.of(still, source);
                let places = draft.places();
                draft.judge_in(view, &places);
                draft.searched = Some(Ok(format!(
                    "all four balls found: {:.0} of 100 points, the next best four have {:.0}",
                    found.score * 100.0,
                    found.runner_up * 100.0
                )));
            }
            Err(reason) => draft.was_not_found(reason.to_string()),
        }
    }
}
