//! The stereo view back: the newest picture of each of the slave's cameras, and how old it is.

use crate::console::Desk;
use crate::console::desk::Shown;
use crate::console::snapshot::PictureView;
use crate::link::{Carrier, Picture, Received};
use crate::output::{CsvFile, OutputError};
use crate::station::{is_stale, picture_age_us};
use std::path::{Path, PathBuf};

/// The slave's cameras: the first is the left eye.
pub(super) const EYES: [&str; 2] = ["left", "right"];

/// Pictures are written at most so often, microseconds.
const WRITE_US: u64 = 1_000_000;

/// One eye.
#[derive(Default)]
struct Eye {
    newest: Option<Received<Picture>>,
    count: u64,
    written_us: Option<u64>,
    /// Whether the newest has been written.
    is_written: bool,
    stale: bool,
}

/// Both.
#[derive(Default)]
pub(super) struct Pictures {
    eyes: [Eye; EYES.len()],
    dir: Option<PathBuf>,
    /// Where they are looked at, and the view of the first.
    desk: Option<(Desk, usize)>,
    /// How many cameras the slave has announced.
    announced: Option<usize>,
}

impl Pictures {
    /// Pictures that go to a directory, or nowhere.
    pub(super) fn new(dir: Option<&Path>) -> Self {
        Self { eyes: Default::default(), dir: dir.map(Path::to_owned), desk: None, announced: None }
    }

    /// They are looked at too, from that view on.
    pub(super) fn show(&mut self, desk: Desk, first: usize) {
        self.desk = Some((desk, first));
    }

    /// The slave says how many cameras it has.
    pub(super) fn announced(&mut self, cameras: u8) {
        let cameras = usize::from(cameras).min(EYES.len());
        self.announced = Some(cameras);
        // what another slave of that name has shown is nothing to wait for
        self.eyes.iter_mut().skip(cameras).for_each(Eye::forget);
    }

    /// Takes what came; a line for each eye that has become stale or fresh again.
    pub(super) fn take(&mut self, slave: &impl Carrier, now_us: u64) -> Vec<String> {
        let mut lines = Vec::new();
        for (camera, (eye, name)) in (0..).zip(self.eyes.iter_mut().zip(EYES)) {
            if let Some(picture) = slave.picture(camera) {
                if let Some((desk, first)) = &self.desk {
                    desk.show(first + usize::from(camera), shown(&picture));
                }
                eye.newest = Some(picture);
                eye.count += 1;
                eye.is_written = false;
            }
            let age_us = eye.newest.as_ref().map(|picture| picture_age_us(picture, now_us));
            let stale = eye.newest.as_ref().is_some_and(|picture| is_stale(picture, now_us));
            if stale != std::mem::replace(&mut eye.stale, stale) {
                lines.push(match age_us.filter(|_| stale) {
                    Some(age_us) => {
                        format!("the {name} picture is stale: it is of {} ms ago", age_us / 1_000)
                    }
                    None => format!("the {name} picture is fresh again"),
                });
            }
            if let Some(dir) = &self.dir
                && !eye.is_written
                && eye.written_us.is_none_or(|at_us| now_us.saturating_sub(at_us) >= WRITE_US)
            {
                // a picture that is not written is no reason to end: the next one may be
                let _ = eye.write(dir, name);
                eye.written_us = Some(now_us);
            }
        }
        lines
    }

    /// How old each eye's picture is, for the live line.
    pub(super) fn ages(&self, now_us: u64) -> Option<String> {
        let age = |(eye, name): (&Eye, &str)| {
            let picture = eye.newest.as_ref()?;
            let stale = if eye.stale { " STALE" } else { "" };
            Some(format!("{name} {} ms{stale}", picture_age_us(picture, now_us) / 1_000))
        };
        let ages: Vec<String> = self.eyes.iter().zip(EYES).filter_map(age).collect();
        (!ages.is_empty()).then(|| format!("pictures {}", ages.join(", ")))
    }

    /// What the console shows of them: of those that the slave has.
    pub(super) fn views(&self, now_us: u64) -> Vec<PictureView> {
        let first = self.desk.as_ref().map_or(0, |(_, first)| *first);
        let view = |(at, (eye, name)): (usize, (&Eye, &'static str))| PictureView {
            name,
            view: first + at,
            age_us: eye.newest.as_ref().map(|picture| picture_age_us(picture, now_us)),
            stale: eye.stale,
            count: eye.count,
        };
        let cameras = self.announced.unwrap_or(EYES.len());
        self.eyes.iter().zip(EYES).enumerate().take(cameras).map(view).collect()
    }

    /// How many came of each eye.
    pub(super) fn counts(&self) -> Vec<(&'static str, u64)> {
        EYES.into_iter().zip(&self.eyes).map(|(name, eye)| (name, eye.count)).collect()
    }

    /// Writes the newest, and pictures.csv, which says of each how old it is now.
    pub(super) fn end(&mut self, now_us: u64) -> Result<(), OutputError> {
        let Some(dir) = &self.dir else { return Ok(()) };
        let mut csv = CsvFile::create(dir, "pictures.csv", "eye,sequence,width,height,age_ms,stale")?;
        for (eye, name) in self.eyes.iter_mut().zip(EYES) {
            let Some(picture) = &eye.newest else { continue };
            let (age_us, stale) = (picture_age_us(picture, now_us), is_stale(picture, now_us));
            let Picture { sequence, width, height, .. } = picture.what;
            csv.row(|row| {
                row.field(name).field(sequence).field(width).field(height);
                row.field(age_us / 1_000).field(stale);
            })?;
            eye.write(dir, name)?;
        }
        Ok(())
    }
}

/// A picture that came, to be looked at.
pub(super) fn shown(picture: &Received<Picture>) -> Shown {
    let Picture { sequence, width, height, jpeg, .. } = &picture.what;
    Shown {
        sequence: *sequence,
        taken_us: picture.captured_us.unwrap_or(picture.received_us),
        width: *width,
        height: *height,
        balls: Vec::new(),
        jpeg: jpeg.as_slice().into(),
    }
}

impl Eye {
    fn forget(&mut self) {
        self.newest = None;
        self.stale = false;
    }

    /// Whoever looks at the file sees the one before or this one, never half of it.
    fn write(&mut self, dir: &Path, name: &str) -> Result<(), OutputError> {
        let Some(picture) = &self.newest else { return Ok(()) };
        let path = dir.join(format!("{name}.jpg"));
        let part = dir.join(format!("{name}.jpg.part"));
        let written = std::fs::write(&part, &picture.what.jpeg).and_then(|()| std::fs::rename(&part, &path));
        self.is_written = true;
        written.map_err(|cause| OutputError { path, cause })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::{Doorbell, local};
    use crate::robot::clock::Clock;

    #[test]
    fn the_newest_is_kept_written_and_marked_when_it_is_stale() {
        let dir = tempfile::tempdir().unwrap();
        let clock = Clock::given();
        let [slave, operator] = local::pair(&clock, [Doorbell::default(), Doorbell::default()], [1, 2]);
        let mut pictures = Pictures::new(Some(dir.path()));
        let picture = |sequence, jpeg: &[u8]| Picture {
            camera: 1,
            session: 1,
            sequence,
            capture_us: u64::from(sequence) * 690_000 - 689_995,
            width: 4,
            height: 3,
            jpeg: jpeg.to_vec(),
        };
        clock.set(10);
        slave.send_picture(picture(1, b"one"));
        assert_eq!(pictures.take(&operator, 10), Vec::<String>::new());
        assert_eq!(pictures.ages(3_005).unwrap(), "pictures right 3 ms");
        let told = pictures.take(&operator, 600_010);
        assert_eq!(told, ["the right picture is stale: it is of 600 ms ago"]);
        assert!(pictures.ages(600_010).unwrap().ends_with("STALE"));
        clock.set(700_000);
        slave.send_picture(picture(2, b"two"));
        assert_eq!(pictures.take(&operator, 700_000), ["the right picture is fresh again"]);
        let file = dir.path().join("right.jpg");
        assert_eq!(std::fs::read(&file).unwrap(), b"one", "at most one a second");
        pictures.end(2_000_000).unwrap();
        assert_eq!(std::fs::read(&file).unwrap(), b"two");
        let csv = std::fs::read_to_string(dir.path().join("pictures.csv")).unwrap();
        assert_eq!(csv.lines().nth(1), Some("right,2,4,3,1309,true"));
    }

    #[test]
    fn as_many_eyes_are_told_as_the_slave_has_cameras() {
        let names = |pictures: &Pictures| -> Vec<&str> {
            pictures.views(0).into_iter().map(|view| view.name).collect()
        };
        let mut pictures = Pictures::new(None);
        assert_eq!(names(&pictures), ["left", "right"], "nobody knows yet");
        for (cameras, told) in [(1, &EYES[..1]), (0, &EYES[..0]), (2, &EYES[..]), (9, &EYES[..])] {
            pictures.announced(cameras);
            assert_eq!(names(&pictures), told, "{cameras}");
        }
    }
}
