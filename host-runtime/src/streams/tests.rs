use super::*;
use crate::source::{Gap, SourceInfo};
use tetrad_core::vision::frame::{FrameView, PixelFormat};

/// One black pixel at each of some times; at `broken` it fails.
struct Times {
    info: SourceInfo,
    times: Vec<f64>,
    at: usize,
    broken: Option<usize>,
    gap_at: Option<usize>,
}

impl Source for Times {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next(&mut self) -> Result<Option<Frame<'_>>, SourceError> {
        if self.broken == Some(self.at) {
            return Err(SourceError::BadArgument { spec: "times".into(), reason: "broken".into() });
        }
        let Some(&t_s) = self.times.get(self.at) else { return Ok(None) };
        let index = self.at as u64;
        let gap = if self.gap_at == Some(self.at) { Gap::Missed(2) } else { Gap::None };
        self.at += 1;
        let view = FrameView::packed(&[0, 0, 0], 1, 1, PixelFormat::Rgb888).unwrap();
        Ok(Some(Frame { view, index, number: index, t_s, gap }))
    }
}

fn stream(name: &'static str, times: &[f64], live: bool, broken: Option<usize>) -> Stream {
    let info = SourceInfo {
        name: name.into(),
        width: 1,
        height: 1,
        format: PixelFormat::Rgb888,
        fps: Some(10.0),
        frames: None,
        live,
    };
    let times = times.to_vec();
    Stream { name, source: Box::new(Times { info, times, at: 0, broken, gap_at: None }) }
}

/// Four frames, with a gap before one of them.
fn gap_before(name: &'static str, index: usize) -> Stream {
    let info = stream(name, &[], false, None).source.info().clone();
    let source = Times { info, times: vec![0.0; 4], at: 0, broken: None, gap_at: Some(index) };
    Stream { name, source: Box::new(source) }
}

/// The times of the frames that came together, and how it ended.
fn run(left: Stream, right: Option<Stream>, most: usize) -> (Vec<Vec<f64>>, Result<End, StreamError>) {
    let mut seen = Vec::new();
    let end = Streams::new(left, right).run(|frames| {
        seen.push(frames.iter().map(|frame| frame.t_s).collect());
        Ok(if seen.len() == most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    });
    (seen, end)
}

#[test]
fn recordings_pair_by_index_whatever_their_times() {
    let right = stream("right", &[5.0, 6.0], false, None);
    let (seen, end) = run(stream("left", &[0.0, 0.1], false, None), Some(right), 9);
    assert_eq!(seen, [[0.0, 5.0], [0.1, 6.0]]);
    assert_eq!(end.unwrap(), End::Exhausted);
}

#[test]
fn live_cameras_pair_by_time() {
    let left = stream("left", &[0.0, 0.1, 0.2, 0.3, 0.4], true, None);
    let right = stream("right", &[0.22, 0.32, 0.47, 0.6], true, None);
    let (seen, _) = run(left, Some(right), 9);
    assert_eq!(seen, [[0.2, 0.22], [0.3, 0.32]]);
}

#[test]
fn unequal_lengths_are_counted_to_the_end() {
    let right = stream("right", &[0.0; 7], false, None);
    let (seen, end) = run(stream("left", &[0.0; 3], false, None), Some(right), 99);
    assert_eq!(seen.len(), 3);
    let message = end.unwrap_err().to_string();
    assert!(message.contains("left has 3 frames and right has 7;"), "{message}");
    assert!(message.contains("the 3 both have"), "{message}");

    let right = stream("right", &[0.0; 2], false, None);
    let (_, end) = run(stream("left", &[0.0; 9], false, Some(5)), Some(right), 99);
    let message = end.unwrap_err().to_string();
    assert!(message.contains("left has at least 5 frames and right has 2;"), "{message}");
}

#[test]
fn a_source_without_frames_or_with_a_bad_one_is_named() {
    let (_, end) = run(stream("left", &[], false, None), None, 9);
    assert!(end.unwrap_err().to_string().contains("left source"));
    let (_, end) = run(stream("left", &[0.0], false, None), Some(stream("right", &[], false, None)), 9);
    assert!(end.unwrap_err().to_string().contains("right source"));
    let bad = stream("right", &[0.0; 4], false, Some(2));
    let (seen, end) = run(stream("left", &[0.0; 4], false, None), Some(bad), 9);
    assert_eq!(seen.len(), 2);
    assert_eq!(end.unwrap_err().to_string(), "the right source failed after 2 frames");
}

#[test]
fn a_gap_in_one_recording_ends_it_and_in_both_does_not() {
    let (seen, end) = run(gap_before("left", 2), Some(gap_before("right", 2)), 9);
    assert_eq!((seen.len(), end.unwrap()), (4, End::Exhausted));
    for (left, right, name) in [(2, 9, "left"), (9, 2, "right")] {
        let (seen, end) = run(gap_before("left", left), Some(gap_before("right", right)), 9);
        let message = end.unwrap_err().to_string();
        assert_eq!(seen.len(), 2);
        assert!(message.contains(&format!("before frame 2 of the {name} source")), "{message}");
        assert!(message.contains("2 pairs"), "{message}");
    }
}

#[test]
fn the_callback_stops_it() {
    let (seen, end) = run(stream("left", &[0.0; 9], false, None), None, 2);
    assert_eq!((seen.len(), end.unwrap()), (2, End::Stopped));
}
