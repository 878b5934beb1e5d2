//! The whole chain in one process: two pictures in memory, trackers, hand, a packet over the link's
//! in-process carrier, the slave's law and limits, and a set-point at the port of a simulated arm.

use crate::clip::{CAMERAS, Clip, FRAME_US};
use divan::{Bencher, black_box, counter::ItemsCount};
use tetrad::link::Carrier as _;
use tetrad::link::faulty::{Faults, FaultyEnd, pair};
use tetrad::pipeline::{CameraStart, Pipeline, PipelineConfig};
use tetrad::robot::clock::Clock;
use tetrad::robot::simulated::{SimulatedArm, SimulatedOptions};
use tetrad::station::{MotionSender, SlaveStation};
use tetrad_core::arm::teleop::State;
use tetrad_core::config::SlaveConfig;
use tetrad_core::hand::affine::Arms;
use tetrad_core::vision::frame::PixelFormat;
use tetrad_core::wire::Packet;

const SESSION: u32 = 1;

/// How long the arm gets to be switched on, microseconds.
const SWITCH_ON_US: u64 = 3_000_000;

struct Chain {
    clip: Clip,
    pipeline: Pipeline,
    sender: MotionSender,
    ends: [FaultyEnd; 2],
    slave: SlaveStation,
    clock: Clock,
    cycle_us: u64,
    due_us: u64,
    step: usize,
    state: State,
}

impl Chain {
    fn new(config: PipelineConfig) -> Self {
        let clip = Clip::new(PixelFormat::Rgb888);
        let starts: Vec<CameraStart> = (0..CAMERAS)
            .map(|camera| CameraStart {
                balls: clip.learnt(camera).map(Some),
                places: clip.places(camera).map(Some),
                focal_px: None,
            })
            .collect();
        let arms = Arms::equal(clip.scene.arm_m as f32).expect("the scene's arms");
        let pipeline = Pipeline::new(&starts, config, Some(arms)).expect("a pipeline");
        let clock = Clock::given();
        let ends = pair(1, [Faults::default(); 2], &clock);
        ends[1].begin(SESSION).expect("the first session");
        let settings = SlaveConfig::default();
        let arm = SimulatedArm::with_clock(&settings.puma, &SimulatedOptions::default(), clock.clone());
        let slave = SlaveStation::new(&settings, Box::new(arm.expect("an arm"))).expect("a slave");
        let cycle_us = u64::from(settings.governor.cycle_us);
        let sender = MotionSender::new(SESSION);
        let state = State::Stopped;
        let mut chain =
            Self { clip, pipeline, sender, ends, slave, clock, cycle_us, due_us: 1, step: 0, state };
        let mut asked = false;
        while chain.due_us < SWITCH_ON_US {
            chain.cycle(false);
            if chain.state == State::Stopped {
                // it is being switched on, until it is
                let _ = chain.slave.reset(chain.clock.now_us(), !std::mem::replace(&mut asked, true));
            }
        }
        for _ in 0..30 {
            chain.frame();
        }
        assert_eq!(chain.state, State::Engaged, "the arm follows");
        chain
    }

    /// One stereo picture, and the arm's cycles until the next.
    fn frame(&mut self) {
        let t_us = SWITCH_ON_US + self.step as u64 * FRAME_US;
        let frames = [0, 1].map(|camera| (self.clip.view(camera, self.step), t_us));
        let step = self.pipeline.step(black_box(&frames));
        self.step += 1;
        if let Some(packet) = self.sender.packet(&step, t_us, true) {
            self.ends[0].send(&Packet::Motion(packet)).expect("a packet of numbers");
        }
        while self.due_us < t_us + FRAME_US {
            self.cycle(self.step > 5);
        }
    }

    fn cycle(&mut self, pressed: bool) {
        self.due_us += self.cycle_us;
        self.clock.set(self.due_us);
        if let Some(motion) = self.ends[1].motion() {
            // what is refused shows in the state
            let _ = self.slave.take(&motion.what, motion.received_us);
        }
        self.slave.hold_to_run(pressed, self.due_us);
        let cycle = self.slave.cycle(self.due_us);
        self.state = cycle.step.decision.status.state();
        black_box(&cycle);
    }
}

/// One stereo picture and three to four cycles of the arm.
#[divan::bench(args = ["paper", "refined"], sample_size = 20)]
fn stereo_frame(bencher: Bencher<'_, '_>, mode: &str) {
    let config = if mode == "paper" { PipelineConfig::paper() } else { PipelineConfig::refined() };
    let mut chain = Chain::new(config);
    bencher.counter(ItemsCount::new(1_usize)).bench_local(|| chain.frame());
    assert_eq!(chain.state, State::Engaged, "it followed to the end");
}
