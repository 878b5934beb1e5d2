//! What a run came to, in lines.

use super::cameras::Cameras;
use super::pictures::Pictures;
use super::slave::SlaveLine;
use crate::link::{Link, Peer};
use crate::station::Operator;

/// The program's memory, kB: at its start, when it was warm, at its end.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Memory {
    pub(super) start: Option<u64>,
    pub(super) warm: Option<u64>,
    pub(super) end: Option<u64>,
}

/// Everything that is told at the end.
pub(super) fn lines(
    station: &Operator,
    cameras: &Cameras,
    slave: &SlaveLine,
    link: Option<&Link>,
    pictures: &Pictures,
    memory: Memory,
) -> Vec<String> {
    let mut lines: Vec<String> = station.delays().table().lines().map(str::to_owned).collect();
    let counts = station.pairing().counts();
    lines.push(format!(
        "instants        {} with all cameras, {} without one or more, {} changes of the reference",
        counts.complete, counts.partial, counts.changes
    ));
    for (at, camera) in cameras.0.iter().enumerate() {
        let rate = station.pairing().measured_period_us(at);
        let rate = rate.map_or_else(String::new, |us| format!(", {:.1} a second", 1e6 / us));
        lines.push(format!("{:<15} {} observations{rate}{}", camera.name, camera.count, camera.losses()));
    }
    for (what, count) in [("without a known time", station.unplaced()), ("out of order", counts.old)] {
        if count > 0 {
            lines.push(format!("left out        {count} observations {what}"));
        }
    }
    if let Some(peer) = slave.as_peer() {
        let counts = peer.stats().received.arm_state;
        lines.push(format!(
            "{:<15} {} arm states, {:.1} % lost, {} late",
            peer.name().as_str(),
            counts.taken,
            counts.loss() * 100.0,
            counts.late
        ));
    }
    lines.extend(link.into_iter().flat_map(Link::peers).map(|peer| connection(&peer)));
    for (eye, count) in pictures.counts().into_iter().filter(|(_, count)| *count > 0) {
        lines.push(format!("pictures        {count} of the {eye} eye"));
    }
    let kb = |kb: Option<u64>| kb.map_or_else(|| "?".to_owned(), |kb| kb.to_string());
    let Memory { start, warm, end } = memory;
    // a run that was ended before is not told of
    let warm = warm.map_or_else(String::new, |warm| format!("{warm} kB warm, "));
    lines.push(format!("memory          {} kB at the start, {warm}{} kB at the end", kb(start), kb(end)));
    lines
}

fn connection(peer: &Peer) -> String {
    let stats = peer.stats();
    let trip = stats
        .round_trip_us
        .map_or_else(String::new, |us| format!(", there and back {:.2} ms", us as f64 / 1e3));
    let clock = stats.clock.map_or_else(String::new, |clock| {
        format!(", clock {:+.3} ms to {:.3} ms", clock.offset_us as f64 / 1e3, clock.error_us as f64 / 1e3)
    });
    format!(
        "link to {:<7} connected {} times, {} packets sent, {} overtaken, {} of {} lost on the way{trip}{clock}",
        peer.name().as_str(),
        stats.connected,
        stats.sent.sent,
        stats.sent.overtaken,
        stats.lost_packets,
        stats.sent_packets
    )
}
