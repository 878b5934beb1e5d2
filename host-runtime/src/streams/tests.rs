use super::*;
use crate::source::{Gap, Labels, SourceInfo};
use tetrad_core::vision::frame::{FrameView, PixelFormat};

/// One black pixel at each of some times; at `broken` it fails.
struct Times {
    info: SourceInfo,
    times: Vec<f64>,
    at: usize,
    broken: Option<usize>,
    gap_at: Option<usize>,
    first: u64,
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
        Ok(Some(Frame { view, index, number: self.first + index, t_s, gap }))
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
        labels: Labels::Order,
    };
    let times = times.to_vec();
    Stream { name, source: Box::new(Times { info, times, at: 0, broken, gap_at: None, first: 0 }) }
}

/// Four frames, with a gap before one of them.
fn gap_before(name: &'static str, index: usize) -> Stream {
    let info = stream(name, &[], false, None).source.info().clone();
    let source = Times { info, times: vec![0.0; 4], at: 0, broken: None, gap_at: Some(index), first: 0 };
    Stream { name, source: Box::new(source) }
}

/// Frames at these times, numbered from `first` on.
fn labelled(name: &'static str, first: u64, times: &[f64], labels: Labels) -> Stream {
    let info = SourceInfo { labels, ..stream(name, &[], false, None).source.info().clone() };
    let times = times.to_vec();
    let source = Times { info, times, at: 0, broken: None, gap_at: None, first };
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
fn equal_lengths_with_other_numbers_are_refused_and_both_named() {
    let both = |left, right| {
        let stream = |name, first| labelled(name, first, &[0.0, 0.1], Labels::Numbers);
        run(stream("left", left), Some(stream("right", right)), 9)
    };
    assert_eq!(both(3, 3).1.unwrap(), End::Exhausted);
    for (left, right, lacks) in
        [(0, 1, "the right source lacks picture 0"), (5, 2, "the left source lacks picture 2")]
    {
        let (seen, end) = both(left, right);
        let error = end.unwrap_err();
        let message = error.to_string();
        assert_eq!(seen.len(), 0);
        assert!(
            message.contains(&format!("left frame {left} does not belong to right frame {right}")),
            "{message}"
        );
        assert!(message.contains(lacks), "{message}");
        assert_eq!(Failure::from(error).exit, Exit::BadArguments);
    }
}

#[test]
fn recorded_times_decide_whatever_the_numbers() {
    let labels = Labels::Times { step_s: 0.1 };
    let left = || labelled("left", 0, &[0.0, 0.1, 0.2], labels);
    let right = labelled("right", 100, &[0.04, 0.14, 0.24], labels);
    assert_eq!(run(left(), Some(right), 9).1.unwrap(), End::Exhausted);

    let (seen, end) = run(left(), Some(labelled("right", 0, &[0.0, 0.2, 0.3], labels)), 9);
    let error = end.unwrap_err();
    let message = error.to_string();
    assert_eq!(seen.len(), 1);
    assert!(message.contains("left frame 1 was taken at 0.1 s and right frame 1 at 0.2 s"), "{message}");
    assert!(message.contains("1 pairs before them"), "{message}");
    assert_eq!(Failure::from(error).exit, Exit::Failed);
}

#[test]
fn sources_of_unequal_length_are_cut_at_the_end_only_where_the_beginning_is_known() {
    let message = |labels| {
        let right = labelled("right", 0, &[0.0; 3], labels);
        run(labelled("left", 0, &[0.0; 2], labels), Some(right), 9).1.unwrap_err().to_string()
    };
    assert!(message(Labels::Order).contains("right only if both sources begin together"));
    assert!(
        message(Labels::Numbers)
            .ends_with("tracked. Cut the end of the longer one to the length of the shorter")
    );
}

#[test]
fn the_callback_stops_it() {
    let (seen, end) = run(stream("left", &[0.0; 9], false, None), None, 2);
    assert_eq!((seen.len(), end.unwrap()), (2, End::Stopped));
}
