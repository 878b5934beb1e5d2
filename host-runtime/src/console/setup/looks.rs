//! What is looked at of a camera: its still picture, what would be mistaken in it, a row.

use super::refused::Refused;
use super::routes::{BallName, OfCamera, query, set_up};
use super::teach::{inside, next};
use super::{aside, scan};
use crate::console::app::State;
use crate::learning::mistaken;
use crate::station::camera::Still;
use crate::station::encode_jpeg;
use axum::Json;
use axum::body::Body;
use axum::extract::State as Of;
use axum::http::{HeaderValue, Uri, header};
use axum::response::{IntoResponse as _, Response};
use serde::Deserialize;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::Ball;
use tetrad_core::vision::frame::FrameView;

/// Quality of the still pictures' JPEG: they are looked at closely.
const QUALITY: u8 = 92;

#[derive(Debug, Deserialize)]
struct OfBall {
    camera: usize,
    ball: BallName,
}

#[derive(Debug, Deserialize)]
struct OfRow {
    camera: usize,
    ball: BallName,
    u: f32,
    v: f32,
    /// Of the camera's next picture, not of the still one.
    #[serde(default)]
    live: bool,
}

/// The still picture of a camera.
pub(super) async fn still_picture(Of(state): Of<State>, uri: Uri) -> Result<Response, Refused> {
    let of: OfCamera = query(&uri)?;
    let set_up = set_up(&state)?;
    let camera = set_up.local(of.camera)?;
    let still = set_up.draft(camera.index).still.ok_or_else(|| Refused::NoStill(camera.name.to_owned()))?;
    let permit = set_up.work().await?;
    let (jpeg, _permit) = aside(permit, move || jpeg(&still.picture)).await?;
    Ok(picture("image/jpeg", jpeg?))
}

/// What would be mistaken for a ball in the still picture.
pub(super) async fn mistaken_picture(Of(state): Of<State>, uri: Uri) -> Result<Response, Refused> {
    let of: OfBall = query(&uri)?;
    let set_up = set_up(&state)?;
    let camera = set_up.local(of.camera)?;
    let draft = set_up.draft(camera.index);
    let still = draft.still.ok_or_else(|| Refused::NoStill(camera.name.to_owned()))?;
    let ball = Ball::from(of.ball);
    let lesson = draft.lessons[ball.index()].ok_or_else(|| Refused::Unknown(camera.name.to_owned(), ball))?;
    let permit = set_up.work().await?;
    let work = move || {
        let frame = view(&still.picture)?;
        let found = lesson.judged.and_then(|judged| judged.found);
        png(&mistaken(&frame, &lesson.colours.learnt, found), still.picture.size())
    };
    let (png, _permit) = aside(permit, work).await?;
    Ok(picture("image/png", png?))
}

/// The row under the pointer.
pub(super) async fn scan_row(Of(state): Of<State>, uri: Uri) -> Result<Response, Refused> {
    let of: OfRow = query(&uri)?;
    let set_up = set_up(&state)?;
    let camera = set_up.local(of.camera)?;
    let permit = set_up.scan()?;
    let draft = set_up.draft(camera.index);
    let (ball, at) = (Ball::from(of.ball), ImagePoint::new(of.u, of.v));
    let learnt = draft.lessons[ball.index()].map(|lesson| lesson.colours.learnt);
    let learnt = learnt.or_else(|| camera.handle.taught()[ball.index()]);
    let learnt = learnt.ok_or_else(|| Refused::Unknown(camera.name.to_owned(), ball))?;
    let still = match draft.still.filter(|_| !of.live) {
        Some(still) => still.picture,
        None => next(&camera).await?,
    };
    inside(at, still.size())?;
    let (told, _permit) = aside(permit, move || scan::scan(&view(&still)?, ball, &learnt, at)).await?;
    Ok(Json(told?).into_response())
}

fn view(still: &Still) -> Result<FrameView<'_>, Refused> {
    still.view().map_err(|error| Refused::Failed(format!("the picture cannot be read: {error}")))
}

fn jpeg(still: &Still) -> Result<Vec<u8>, Refused> {
    let mut jpeg = Vec::new();
    encode_jpeg(&mut jpeg, &view(still)?, QUALITY)
        .map_err(|error| Refused::Failed(format!("the picture cannot be encoded: {error}")))?;
    Ok(jpeg)
}

fn png(rgb: &[u8], (width, height): (u16, u16)) -> Result<Vec<u8>, Refused> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width.into(), height.into());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().map_err(|error| unencoded(&error))?;
    writer.write_image_data(rgb).map_err(|error| unencoded(&error))?;
    writer.finish().map_err(|error| unencoded(&error))?;
    Ok(file)
}

fn unencoded(error: &png::EncodingError) -> Refused {
    Refused::Failed(format!("the picture cannot be encoded: {error}"))
}

fn picture(kind: &'static str, bytes: Vec<u8>) -> Response {
    ([(header::CONTENT_TYPE, HeaderValue::from_static(kind))], Body::from(bytes)).into_response()
}
