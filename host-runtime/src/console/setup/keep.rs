//! The colours into and out of files.

use super::draft::Draft;
use super::refused::Refused;
use super::routes::{Answer, Asked, OfCamera, query, read, set_up, told};
use super::{aside, files, may_set_up};
use crate::colours::Colours;
use crate::console::app::State;
use axum::extract::State as Of;
use axum::http::{Uri, header};
use axum::response::{IntoResponse as _, Response};
use serde::Deserialize;
use std::path::PathBuf;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Uploaded {
    page: Option<u64>,
    camera: usize,
    /// What the file is called, for messages.
    file: String,
    text: String,
}

/// The colours into the stations' files.
pub(super) async fn save(Of(state): Of<State>, body: String) -> Answer {
    let asked: Asked = read(&body)?;
    let set_up = set_up(&state)?;
    may_set_up(&state.desk, asked.page)?;
    let permit = set_up.work().await?;
    let mut files: Vec<(PathBuf, Colours)> = Vec::new();
    for camera in set_up.meant(asked.camera)? {
        let draft = set_up.draft(camera.index);
        if let Some(ball) = draft.missing() {
            return Err(Refused::Unknown(camera.name.to_owned(), ball));
        }
        files.push((files::kept(&camera)?.to_owned(), draft.to_colours()));
    }
    let names: Vec<_> = files.iter().map(|(file, _)| file.display().to_string()).collect();
    let work = move || files.iter().try_for_each(|(file, colours)| files::save(file, colours));
    let (saved, _permit) = aside(permit, work).await?;
    saved?;
    told(&state, set_up, asked.page, format!("saved: {}", names.join(", ")))
}

/// The colours out of the stations' files.
pub(super) async fn load(Of(state): Of<State>, body: String) -> Answer {
    let asked: Asked = read(&body)?;
    let set_up = set_up(&state)?;
    may_set_up(&state.desk, asked.page)?;
    let permit = set_up.work().await?;
    let cameras = set_up.meant(asked.camera)?;
    let files =
        cameras.iter().map(|camera| Ok((files::kept(camera)?.to_owned(), set_up.draft(camera.index))));
    let files = files.collect::<Result<Vec<_>, Refused>>()?;
    let work = move || {
        let load = |(file, mut draft): (PathBuf, Draft)| {
            draft.load(&files::load(&file)?);
            Ok(draft)
        };
        files.into_iter().map(load).collect::<Result<Vec<_>, Refused>>()
    };
    let (drafts, _permit) = aside(permit, work).await?;
    for (camera, draft) in cameras.iter().zip(drafts?) {
        set_up.put(camera.index, draft);
    }
    told(&state, set_up, asked.page, "loaded; not in use yet")
}

/// The colours of one camera as a file.
pub(super) async fn download(Of(state): Of<State>, uri: Uri) -> Result<Response, Refused> {
    let of: OfCamera = query(&uri)?;
    let set_up = set_up(&state)?;
    let camera = set_up.local(of.camera)?;
    let draft = set_up.draft(camera.index);
    if let Some(ball) = draft.missing() {
        return Err(Refused::Unknown(camera.name.to_owned(), ball));
    }
    let attachment = format!("attachment; filename=\"colours-{}.toml\"", camera.index + 1);
    let headers =
        [(header::CONTENT_TYPE, "application/toml"), (header::CONTENT_DISPOSITION, attachment.as_str())];
    Ok((headers, draft.to_colours().to_toml()).into_response())
}

/// A file of colours for one camera.
pub(super) async fn upload(Of(state): Of<State>, body: String) -> Answer {
    let uploaded: Uploaded = read(&body)?;
    let set_up = set_up(&state)?;
    may_set_up(&state.desk, uploaded.page)?;
    let permit = set_up.work().await?;
    let camera = set_up.local(uploaded.camera)?;
    let colours = files::colours(&uploaded.text, &uploaded.file)?;
    let mut draft = set_up.draft(camera.index);
    let work = move || {
        draft.load(&colours);
        draft
    };
    let (draft, _permit) = aside(permit, work).await?;
    set_up.put(camera.index, draft);
    told(
        &state,
        set_up,
        uploaded.page,
        format!("{}: loaded from {}; not in use yet", camera.name, uploaded.file),
    )
}
