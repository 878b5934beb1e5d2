//! The cameras that see the hand, wherever they are.

use crate::console::snapshot::{BallView, CameraView};
use crate::console::{Desk, SetUpCamera, SetUpPlace, onlooker};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::link::{Carrier as _, Doorbell, Link, Peer, Picture, Received};
use crate::robot::clock::Clock;
use crate::session::StationTape;
use crate::settings::station::{HandCamera, HandCameraSettings};
use crate::station::pairing::Pairing;
use crate::station::{CameraStation, CameraThread, Label, SerialNode, Told};
use anyhow::Context as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use tetrad_core::observation::BALLS;
use tetrad_core::wire::ObservationPacket;

/// A camera station has one camera.
const CAMERA: u8 = 0;

/// A station whose observations have come for so long, and no picture with them, sends none, microseconds.
const PICTURED_US: u64 = 2_000_000;

/// One camera.
pub(super) struct HandEye {
    /// As the file calls it.
    pub(super) name: String,
    place: Place,
    /// When its first observations came.
    first_us: Option<u64>,
    /// When its last observations came.
    pub(super) heard_us: Option<u64>,
    /// How many came.
    pub(super) count: u64,
    /// The last of them.
    last: Option<ObservationPacket>,
}

enum Place {
    Station(Peer),
    /// How often it shows a ball too: every so many pictures, 0 for never.
    Serial(SerialNode, u16),
    Here(CameraThread),
    /// It is here, and its thread has not begun.
    Opened(Box<CameraStation>),
    /// It was here, and its thread has ended.
    Over,
}

/// All of them, in their order.
pub(super) struct Cameras(pub(super) Vec<HandEye>);

impl Cameras {
    /// Opens those that are here; their threads [begin](Self::begin) later. `shown`: somebody may look at them.
    pub(super) fn open(
        settings: &[HandCameraSettings],
        link: Option<&Link>,
        session: u32,
        clock: &Clock,
        bell: &Doorbell,
        shown: bool,
    ) -> Result<Self, Failure> {
        let mut eyes = Vec::new();
        for (camera, number) in settings.iter().zip(0..) {
            let bell = bell.clone();
            let ring = move || bell.ring();
            let place = match &camera.place {
                HandCamera::Station(name) => {
                    // the file was checked: its cameras are among its peers
                    let peer = link.and_then(|link| link.peer(name));
                    Place::Station(
                        peer.ok_or_else(|| {
                            Failure::bad_arguments(format!("no [[peer]] is called `{name}`"))
                        })?,
                    )
                }
                HandCamera::Serial { device, baud, colours, preview_every } => {
                    let told = Told {
                        session,
                        taught: colours.as_ref().map_or([None; BALLS], |colours| colours.learnt_balls()),
                        preview_every: if shown { *preview_every } else { 0 },
                    };
                    let node = SerialNode::start(device, *baud, clock.clone(), told, ring);
                    let node = node.context("a camera's thread cannot be started").or_exit(Exit::Failed)?;
                    Place::Serial(node, *preview_every)
                }
                HandCamera::Local(local) => {
                    let label = Label { camera: number, session };
                    Place::Opened(Box::new(CameraStation::open(local, label, clock.clone())?))
                }
            };
            eyes.push(HandEye {
                name: name(camera),
                place,
                first_us: None,
                heard_us: None,
                count: 0,
                last: None,
            });
        }
        Ok(Self(eyes))
    }

    /// What the console sets up of them.
    pub(super) fn to_set_up(&self, settings: &[HandCameraSettings]) -> Vec<SetUpCamera> {
        let camera = |(eye, settings): (&HandEye, &HandCameraSettings)| {
            let place = match &eye.place {
                Place::Here(thread) => SetUpPlace::Here {
                    handle: thread.handle().clone(),
                    source: settings.source.clone(),
                    file: settings.colours.clone(),
                },
                Place::Station(_) => SetUpPlace::Elsewhere(
                    "this camera is at another computer, which learns its balls itself: run `tetrad learn` there, \
                     and start its station again",
                ),
                Place::Serial(..) => SetUpPlace::Elsewhere(
                    "this is a smart camera, which learns its balls itself: end this program, run `tetrad learn` \
                     with its port, name the file as its colours here, and start again",
                ),
                Place::Opened(_) | Place::Over => SetUpPlace::Elsewhere("this recording is over"),
            };
            SetUpCamera { name: eye.name.clone(), place }
        };
        self.0.iter().zip(settings).map(camera).collect()
    }

    /// Pictures that camera stations and smart cameras send to be looked at, each with its camera's place.
    pub(super) fn pictures(&self) -> impl Iterator<Item = (usize, Received<Picture>)> {
        self.0.iter().enumerate().filter_map(|(at, eye)| match &eye.place {
            Place::Station(peer) => Some((at, peer.picture(CAMERA)?)),
            Place::Serial(node, _) => Some((at, node.picture()?)),
            Place::Here(_) | Place::Opened(_) | Place::Over => None,
        })
    }

    /// What the console shows of them.
    pub(super) fn views(&self, pairing: &Pairing, desk: &Desk, now_us: u64) -> Vec<CameraView> {
        let view = |(at, eye): (usize, &HandEye)| CameraView {
            name: eye.name.clone(),
            view: (!matches!(eye.place, Place::Serial(_, 0))).then_some(at),
            no_picture: eye.no_picture(desk.shown(at).is_some(), now_us),
            age_us: eye.heard_us.map(|heard_us| now_us.saturating_sub(heard_us)),
            rate: pairing.measured_period_us(at).map(|us| 1e6 / us),
            width: eye.last.map_or(0, |last| last.width),
            height: eye.last.map_or(0, |last| last.height),
            balls: eye.last.map_or_else(Vec::new, |last| BallView::all(&last.balls)),
        };
        self.0.iter().enumerate().map(view).collect()
    }

    /// Those that are here and have not begun, by their place in the list.
    pub(super) fn opened(&self) -> impl Iterator<Item = (usize, &CameraStation)> {
        self.0.iter().enumerate().filter_map(|(at, eye)| match &eye.place {
            Place::Opened(station) => Some((at, station.as_ref())),
            _ => None,
        })
    }

    /// Starts the threads of those that are here; `desk` and `tape`, where there are any, see their pictures.
    pub(super) fn begin(
        &mut self,
        bell: &Doorbell,
        desk: Option<&Desk>,
        tape: Option<&StationTape>,
    ) -> Result<(), Failure> {
        for (at, eye) in self.0.iter_mut().enumerate() {
            eye.place = match std::mem::replace(&mut eye.place, Place::Over) {
                Place::Opened(station) => {
                    let shown = desk.map(|desk| onlooker(desk, at)).transpose();
                    let shown =
                        shown.context("a preview's thread cannot be started").or_exit(Exit::Failed)?;
                    let kept = tape.map(|tape| tape.onlooker(at));
                    let bell = bell.clone();
                    let onlookers = kept.into_iter().chain(shown).collect();
                    let thread = CameraThread::start(*station, move || bell.ring(), onlookers);
                    Place::Here(thread.context("a camera's thread cannot be started").or_exit(Exit::Failed)?)
                }
                other => other,
            };
        }
        Ok(())
    }

    /// What there is to tell of those that are here.
    pub(super) fn notices(&self) -> Vec<String> {
        self.0
            .iter()
            .flat_map(|eye| match &eye.place {
                Place::Serial(node, _) => node.take_notices(),
                Place::Here(thread) => thread.take_notices(),
                Place::Station(_) | Place::Opened(_) | Place::Over => Vec::new(),
            })
            .collect()
    }

    /// Whether a recording has ended; a camera here that cannot go on is an error.
    pub(super) fn over(&mut self) -> Result<Option<String>, Failure> {
        let ended = |eye: &&mut HandEye| matches!(&eye.place, Place::Here(thread) if thread.is_over());
        let Some(eye) = self.0.iter_mut().find(ended) else { return Ok(None) };
        let Place::Here(thread) = std::mem::replace(&mut eye.place, Place::Over) else { return Ok(None) };
        let name = &eye.name;
        let (_, ended) = catch_unwind(AssertUnwindSafe(|| thread.end())).map_err(|_| {
            Failure::new(
                Exit::Failed,
                anyhow::anyhow!("the thread of {name} has panicked; its message stands above"),
            )
        })?;
        ended?;
        Ok(Some(format!("{name} has no more pictures")))
    }
}

/// What a camera is called.
pub(super) fn name(camera: &HandCameraSettings) -> String {
    match &camera.place {
        HandCamera::Local(local) => format!("{} {}", camera.source, local.options.view.name()),
        HandCamera::Station(_) | HandCamera::Serial { .. } => camera.source.clone(),
    }
}

impl HandEye {
    /// The newest observations, if they were not taken yet.
    pub(super) fn observation(&mut self) -> Option<Received<ObservationPacket>> {
        let observation = match &self.place {
            Place::Station(peer) => peer.observation(CAMERA),
            Place::Serial(node, _) => node.observation(),
            Place::Here(thread) => thread.observation(),
            Place::Opened(_) | Place::Over => None,
        };
        if let Some(observation) = &observation {
            self.heard_us = Some(observation.received_us);
            self.first_us.get_or_insert(observation.received_us);
            self.count += 1;
            self.last = Some(observation.what);
        }
        observation
    }

    /// Why nothing of it can be looked at.
    fn no_picture(&self, pictured: bool, now_us: u64) -> Option<&'static str> {
        match &self.place {
            Place::Station(_) => no_preview(
                self.first_us,
                pictured,
                now_us,
                "no preview: [camera] preview_fps is 0 at that station",
            ),
            Place::Serial(_, 0) => Some("no preview: preview_every is 0"),
            Place::Serial(..) => no_preview(
                self.first_us,
                pictured,
                now_us,
                "no preview so far: a smart camera shows its balls alone",
            ),
            Place::Over if !pictured => Some("this recording is over"),
            Place::Here(_) | Place::Opened(_) | Place::Over => None,
        }
    }

    /// What was lost on the way here, in words.
    pub(super) fn losses(&self) -> String {
        let peer = match &self.place {
            Place::Station(peer) => peer,
            Place::Serial(node, _) => {
                let counts = node.counts();
                return format!(
                    ", {} lost, {} damaged, {} other packets",
                    counts.lost, counts.damaged, counts.other
                );
            }
            Place::Here(_) | Place::Opened(_) | Place::Over => return String::new(),
        };
        let counts = peer.stats().received.observations[usize::from(CAMERA)];
        format!(", {:.1} % lost, {} late, {} overtaken", counts.loss() * 100.0, counts.late, counts.overtaken)
    }
}

/// Why there is no picture of a station whose first observations came then.
fn no_preview(first_us: Option<u64>, pictured: bool, now_us: u64, why: &'static str) -> Option<&'static str> {
    let long = now_us.saturating_sub(first_us?) > PICTURED_US;
    (long && !pictured).then_some(why)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_that_stays_black_says_why() {
        let told = |first_us, pictured, now_us| no_preview(first_us, pictured, now_us, "").is_some();
        assert!(!told(None, false, 9 * PICTURED_US), "a station that is not there has said nothing");
        assert!(!told(Some(5), false, PICTURED_US), "the first may be on its way");
        assert!(told(Some(5), false, 2 * PICTURED_US));
        assert!(!told(Some(5), true, 2 * PICTURED_US));
    }
}
