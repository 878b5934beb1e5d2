//! The stages of one camera by themselves, on the red ball of one frame.

use crate::clip::Clip;
use divan::{Bencher, black_box, counter::ItemsCount};
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::observation::Ball;
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::centre::row_edge_centre;
use tetrad_core::vision::colour::{Matcher, Primary};
use tetrad_core::vision::edges::{RowEdges, SpiralLimits};
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::vision::learn::learn;
use tetrad_core::vision::rim::{RimMemory, Sought, find_rim};
use tetrad_core::vision::search::{Region, UniformSearch};

/// The red ball in the left camera's first frame.
struct Target {
    clip: Clip,
    learnt: LearntBall,
    matcher: Matcher,
    /// Its centre, px.
    at: (i32, i32),
}

impl Target {
    fn new(format: PixelFormat) -> Self {
        let clip = Clip::new(format);
        let learnt = clip.learnt(0)[Ball::Red.index()];
        let place = clip.places(0)[Ball::Red.index()];
        let matcher = Matcher::new(&learnt.reference, TrackerConfig::default().colour.alpha_256)
            .expect("a learnt ball has contrast");
        Self { clip, learnt, matcher, at: (place.u.round() as i32, place.v.round() as i32) }
    }

    fn frame(&self) -> FrameView<'_> {
        self.clip.view(0, 0)
    }

    /// The window of tracking mode around the ball.
    fn window(&self) -> Region {
        let side = TrackerConfig::default().search.window_diameters * self.learnt.diameter;
        Region::square(self.at.0 as f32, self.at.1 as f32, side, self.frame().width(), self.frame().height())
            .expect("the ball is in the picture")
    }

    /// Each pixel of the window, row by row.
    fn pixels(&self) -> Vec<(i32, i32)> {
        let Region { x0, y0, x1, y1 } = self.window();
        (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))).collect()
    }

    fn limits(&self) -> SpiralLimits {
        let search = TrackerConfig::default().search;
        SpiralLimits {
            side: search.spiral_diameters * self.learnt.diameter,
            min_match_256: search.min_match_256,
        }
    }
}

/// Each pixel of a ball's window, read and made RGB.
#[divan::bench(args = PixelFormat::ALL)]
fn frame_read(bencher: Bencher<'_, '_>, format: PixelFormat) {
    let target = Target::new(format);
    let (frame, pixels) = (target.frame(), target.pixels());
    bencher.counter(ItemsCount::new(pixels.len())).bench_local(|| {
        pixels.iter().filter_map(|&(x, y)| black_box(&frame).pixel(x, y)).map(|p| u32::from(p.g)).sum::<u32>()
    });
}

/// Eq. 1 on the same pixels, read beforehand.
#[divan::bench]
fn colour_match(bencher: Bencher<'_, '_>) {
    let target = Target::new(PixelFormat::Rgb888);
    let colours: Vec<_> =
        target.pixels().into_iter().filter_map(|(x, y)| target.frame().pixel(x, y)).collect();
    bencher
        .counter(ItemsCount::new(colours.len()))
        .bench_local(|| colours.iter().filter(|&&colour| black_box(&target.matcher).accepts(colour)).count());
}

/// The uniform search of section 3.2, up to the first pixel of the ball: in its window.
#[divan::bench]
fn search_window(bencher: Bencher<'_, '_>) {
    let target = Target::new(PixelFormat::Rgb888);
    let region = target.window();
    bencher.bench_local(|| first_match(&target, black_box(region)));
}

/// The same in the whole picture.
#[divan::bench]
fn search_picture(bencher: Bencher<'_, '_>) {
    let target = Target::new(PixelFormat::Rgb888);
    let region = Region::whole(target.frame().width(), target.frame().height());
    bencher.bench_local(|| first_match(&target, black_box(region)));
}

fn first_match(target: &Target, region: Region) -> Option<(i32, i32)> {
    let frame = target.frame();
    let matches = |&(x, y): &(i32, i32)| frame.pixel(x, y).is_some_and(|p| target.matcher.accepts(p));
    UniformSearch::new(region, target.learnt.diameter).find(matches)
}

/// The spiral and the edges of its rows, section 3.2 and 3.3.
#[divan::bench(args = PixelFormat::ALL)]
fn spiral_edges(bencher: Bencher<'_, '_>, format: PixelFormat) {
    let target = Target::new(format);
    let (frame, limits, mut edges) = (target.frame(), target.limits(), RowEdges::new());
    bencher.bench_local(|| {
        let mut tested = 0;
        let found = edges.collect(&frame, &target.matcher, black_box(target.at), limits, &mut tested);
        assert_eq!(found, Ok(()));
        tested
    });
}

/// Centre and diameter from the rows, eq. 2.
#[divan::bench]
fn row_edge(bencher: Bencher<'_, '_>) {
    let target = Target::new(PixelFormat::Rgb888);
    let (frame, mut edges) = (target.frame(), RowEdges::new());
    let found = edges.collect(&frame, &target.matcher, target.at, target.limits(), &mut 0);
    assert_eq!(found, Ok(()));
    bencher.bench_local(|| row_edge_centre(&frame, black_box(&edges)));
}

/// The refined centre of a ball that was not seen before.
#[divan::bench(args = PixelFormat::ALL)]
fn rim_first(bencher: Bencher<'_, '_>, format: PixelFormat) {
    rim(bencher, format, false);
}

/// The same with what is remembered of the frame before.
#[divan::bench(args = PixelFormat::ALL)]
fn rim_again(bencher: Bencher<'_, '_>, format: PixelFormat) {
    rim(bencher, format, true);
}

fn rim(bencher: Bencher<'_, '_>, format: PixelFormat, again: bool) {
    let target = Target::new(format);
    let (frame, config, mut edges) = (target.frame(), TrackerConfig::default().centre, RowEdges::new());
    let found = edges.collect(&frame, &target.matcher, target.at, target.limits(), &mut 0);
    assert_eq!(found, Ok(()));
    let blob = row_edge_centre(&frame, &edges).expect("a ball has a centre");
    let LearntBall { diameter, aspect, .. } = target.learnt;
    let first = Sought {
        blob: &blob,
        matcher: &target.matcher,
        memory: None,
        expected: None,
        diameter,
        aspect,
        speed: 0.0,
    };
    let rim = find_rim(&frame, &first, &config, &mut 0).expect("a ball has a rim");
    let memory = RimMemory::after(None, &rim, &blob, &config);
    let sought = Sought { memory: again.then_some(&memory), ..first };
    bencher.bench_local(|| find_rim(&frame, black_box(&sought), &config, &mut 0).is_ok());
}

/// Teaching a ball, section 3.1.
#[divan::bench]
fn learning(bencher: Bencher<'_, '_>) {
    let target = Target::new(PixelFormat::Rgb888);
    let (frame, at) = (target.frame(), target.clip.places(0)[Ball::Red.index()]);
    bencher.bench_local(|| learn(&frame, Primary::of(Ball::Red), black_box(at), &LearnConfig::default()));
}
