//! Learning and using what was learnt: still pictures, the four balls found or one pointed at, the arms.

use super::draft::{Draft, StillPicture, find};
use super::refused::Refused;
use super::routes::{Answer, Asked, BallName, read, set_up, told};
use super::{Local, SetUp, aside, files, lock, may_set_up};
use crate::camera_start::{Named, fits};
use crate::console::app::State;
use crate::console::control::Control;
use crate::station::camera::{Still, Taught};
use axum::extract::State as Of;
use serde::Deserialize;
use std::sync::Arc;
use std::time::Duration;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::Arms;
use tetrad_core::observation::Ball;
use tokio::sync::oneshot;
use tokio::time::timeout;

/// A camera at work gives its next picture within this time: two at the slowest rate there is.
const STILL_WITHIN: Duration = Duration::from_secs(2);

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Pointed {
    page: Option<u64>,
    camera: usize,
    ball: BallName,
    u: f32,
    v: f32,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entered {
    page: Option<u64>,
    arm_mm: f64,
}

/// Still pictures of now.
pub(super) async fn take_still(Of(state): Of<State>, body: String) -> Answer {
    let asked: Asked = read(&body)?;
    let set_up = set_up(&state)?;
    may_set_up(&state.desk, asked.page)?;
    let permit = set_up.work().await?;
    let cameras = set_up.meant(asked.camera)?;
    let stills = stills(set_up, &cameras).await?;
    let drafts: Vec<_> = cameras.iter().map(|camera| set_up.draft(camera.index)).zip(stills).collect();
    let work = move || drafts.into_iter().map(|(draft, still)| draft.with_still(still)).collect::<Vec<_>>();
    let (drafts, _permit) = aside(permit, work).await?;
    for (camera, draft) in cameras.iter().zip(drafts) {
        set_up.put(camera.index, draft);
    }
    told(&state, set_up, asked.page, "the pictures stand still")
}

/// All four balls, wherever they are.
pub(super) async fn find_balls(Of(state): Of<State>, body: String) -> Answer {
    let asked: Asked = read(&body)?;
    let set_up = set_up(&state)?;
    may_set_up(&state.desk, asked.page)?;
    let permit = set_up.work().await?;
    let cameras = set_up.meant(asked.camera)?;
    let stills = stills(set_up, &cameras).await?;
    let drafts = cameras.iter().zip(stills).map(|(camera, still)| {
        let draft = set_up.draft(camera.index);
        (Draft { still: Some(still), ..draft }, camera.source.to_owned())
    });
    let mut drafts: Vec<_> = drafts.collect();
    let work = move || {
        find(&mut drafts);
        drafts
    };
    let (drafts, _permit) = aside(permit, work).await?;
    let known = drafts.iter().filter(|(draft, _)| draft.was_found()).count();
    for (camera, (draft, _)) in cameras.iter().zip(drafts) {
        set_up.put(camera.index, draft);
    }
    let said = format!("the four balls were found by {known} of {} cameras", cameras.len());
    told(&state, set_up, asked.page, said)
}

/// One ball, at a place of the still picture.
pub(super) async fn point(Of(state): Of<State>, body: String) -> Answer {
    let pointed: Pointed = read(&body)?;
    let set_up = set_up(&state)?;
    may_set_up(&state.desk, pointed.page)?;
    let permit = set_up.work().await?;
    let camera = set_up.local(pointed.camera)?;
    let mut draft = set_up.draft(camera.index);
    let still = draft.still.as_ref().ok_or_else(|| Refused::NoStill(camera.name.to_owned()))?;
    let (ball, at) = (Ball::from(pointed.ball), ImagePoint::new(pointed.u, pointed.v));
    inside(at, still.picture.size())?;
    let source = camera.source.to_owned();
    let work = move || draft.point(ball, at, &source).map(|()| draft);
    let (learnt, _permit) = aside(permit, work).await?;
    let draft = learnt.map_err(|why| Refused::Wrong(format!("{}: {why}", camera.name)))?;
    set_up.put(camera.index, draft);
    told(&state, set_up, pointed.page, format!("{}: the {} ball is learnt", camera.name, ball.name()))
}

/// The cameras look for what was learnt, and the hand is another. The arm stops first.
pub(super) async fn use_it(Of(state): Of<State>, body: String) -> Answer {
    let asked: Asked = read(&body)?;
    let set_up = set_up(&state)?;
    may_set_up(&state.desk, asked.page)?;
    let _permit = set_up.work().await?;
    let cameras = set_up.meant(asked.camera)?;
    let mut orders: Vec<(Local<'_>, Taught)> = Vec::new();
    for camera in cameras {
        let draft = set_up.draft(camera.index);
        if let Some(ball) = draft.missing() {
            return Err(Refused::Unknown(camera.name.to_owned(), ball));
        }
        let balls = draft.taught();
        let named = Named { name: camera.name, source: camera.source };
        fits(named, &balls, camera.handle.size()).map_err(|error| Refused::Wrong(error.to_string()))?;
        let wrong = |error| Refused::Wrong(format!("{}: {error}", camera.name));
        camera.handle.check(&balls).map_err(wrong)?;
        orders.push((camera, balls));
    }
    let arms = arms(set_up.arm_m())?;
    stop_first(&state, asked.page)?;
    for (camera, balls) in &orders {
        // it was checked above
        let wrong = |error| Refused::Wrong(format!("{}: {error}", camera.name));
        camera.handle.teach(balls).map_err(wrong)?;
    }
    set_up.begin_anew(arms);
    let mut said = vec!["in use; the arm is stopped: reset before you drive".to_owned()];
    // the next picture is one that was looked at as it was taught
    let pictures: Vec<_> = orders.iter().map(|(camera, _)| (camera.name, next(camera))).collect();
    for (name, picture) in pictures {
        if picture.await.is_err() {
            said.push(format!("{name} gives no picture: it is taught once it does"));
        }
    }
    told(&state, set_up, asked.page, said.join("; "))
}

/// The arms' length, used at once, and kept in the station's file where it can be.
pub(super) async fn arm(Of(state): Of<State>, body: String) -> Answer {
    let entered: Entered = read(&body)?;
    let set_up = set_up(&state)?;
    may_set_up(&state.desk, entered.page)?;
    let permit = set_up.work().await?;
    let mm = entered.arm_mm;
    let arm_m = files::arm_m(mm)?;
    let arms = arms(arm_m)?;
    let file = set_up.file.clone();
    // before it is kept: a length that is refused is none of the next run either
    stop_first(&state, entered.page)?;
    let work = move || file.map(|file| files::save_arm(&file, mm));
    let (kept, _permit) = aside(permit, work).await?;
    // the arm stands for it, and whoever changes the frame goes on with it, whether a file keeps its length or not
    *lock(&set_up.arm_m) = arm_m;
    set_up.begin_anew(arms);
    let until = match kept {
        Some(Ok(())) => "and kept in the station's file".to_owned(),
        Some(Err(why)) => format!("until the end of this run; not kept: {why}"),
        None => "until the end of this run: no file keeps it".to_owned(),
    };
    told(
        &state,
        set_up,
        entered.page,
        format!("arms of {mm} mm, {until}; the arm is stopped: reset before you drive"),
    )
}

/// Stops the arm for this page, unless it may not be: looked at once more, and decided under the lock of the
/// buttons, so that no press comes between.
fn stop_first(state: &State, page: Option<u64>) -> Result<(), Refused> {
    may_set_up(&state.desk, page)?;
    state.desk.with_control(|control: &mut Control, now_us| {
        if control.buttons(now_us).pressed {
            return Err(Refused::Engaged);
        }
        control.stop();
        Ok(())
    })
}

fn arms(arm_m: f32) -> Result<Arms, Refused> {
    Arms::equal(arm_m).map_err(|error| Refused::Wrong(format!("[operator] arm_mm: {error}")))
}

/// A still picture of each of these cameras, taken as nearly at once as they come.
async fn stills(set_up: &SetUp, cameras: &[Local<'_>]) -> Result<Vec<StillPicture>, Refused> {
    let asked: Vec<_> = cameras.iter().map(next).collect();
    let mut stills = Vec::new();
    for picture in asked {
        stills.push(StillPicture { number: set_up.next_still(), picture: picture.await? });
    }
    Ok(stills)
}

/// Asks for the next picture of a camera now, and waits for it where it is awaited.
pub(super) fn next(camera: &Local<'_>) -> impl Future<Output = Result<Arc<Still>, Refused>> + Send + use<> {
    let (send, receive) = oneshot::channel();
    // whoever has gone meanwhile wants no picture
    camera.handle.grab(Box::new(move |still| drop(send.send(still))));
    let name = camera.name.to_owned();
    async move {
        match timeout(STILL_WITHIN, receive).await {
            Ok(Ok(still)) => Ok(still),
            Ok(Err(_)) | Err(_) => Err(Refused::NoPicture(name)),
        }
    }
}

pub(super) fn inside(at: ImagePoint, (width, height): (u16, u16)) -> Result<(), Refused> {
    let within = |x: f32, side: u16| (-0.5..f32::from(side) - 0.5).contains(&x);
    if within(at.u, width) && within(at.v, height) {
        Ok(())
    } else {
        Err(Refused::Outside(at.u, at.v, width, height))
    }
}
