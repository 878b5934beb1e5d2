//! `tetrad learn --source node:serial:DEVICE`: a smart camera learns where it is told to, and what it learnt is
//! kept here.

use super::{LearnArgs, seeds, write};
use crate::cli::{note, session};
use crate::colours::{BallColours, Colours, Origin};
use crate::exit::Failure;
use crate::settings::smart_camera::SerialPlace;
use crate::station::SmartCamera;
use tetrad_core::observation::BALLS;

/// Learns at the points given.
pub(super) fn point(args: &LearnArgs, place: &SerialPlace) -> Result<(), Failure> {
    let source = &args.source;
    if args.scan.is_some() || args.frame > 0 {
        let flag = if args.scan.is_some() { "--scan" } else { "--frame" };
        return Err(Failure::bad_arguments(format!("{flag}: {source} sends no pictures"))
            .help("leave it out: a smart camera learns from the next picture that it takes"));
    }
    let seeds = seeds(&args.at)?;
    let mut camera =
        SmartCamera::open(&place.device, place.baud, session()).map_err(|error| error.of(source))?;
    let taught = camera.learn(&seeds).map_err(|error| error.of(source))?;
    camera.take_notices().iter().for_each(note);
    let mut balls = [None; BALLS];
    for (slot, (learnt, at)) in balls.iter_mut().zip(taught.into_iter().zip(seeds)) {
        *slot = learnt.map(|learnt| BallColours { learnt, at });
    }
    write(&args.out, &Colours { balls, origin: Some(Origin { source: source.clone(), frame: 0 }) })
}
