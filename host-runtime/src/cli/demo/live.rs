//! The demo in real time: the operator's own run, with two simulated cameras and a simulated arm, and the
//! buttons in the console.

use super::{CAMERAS, DemoArgs};
use crate::cli::interrupt::Interrupt;
use crate::cli::operator::{HoldToRun, Order, longest};
use crate::cli::{make_results_dir, note, say, tell_aside};
use crate::exit::Failure;
use crate::settings::arm::ArmSettings;
use crate::settings::station::{
    CameraStart, ConsoleSettings, HandCamera, HandCameraSettings, LocalCamera, OperatorSettings, SceneCamera,
    SceneCameraSettings, SlavePlace, SlaveSettings,
};
use crate::source::Options;
use tetrad_fixtures::Scene;

/// The slave's eyes: pictures a second, and the quality of their JPEG.
const EYE_FPS: f64 = 15.0;
const EYE_QUALITY: u8 = 80;

/// Runs it.
pub(super) fn run(args: &DemoArgs) -> Result<(), Failure> {
    let scene = super::scene(&args.scene)?;
    make_results_dir(&args.out)?;
    let (operator, slave) = stations(args, &scene);
    // without a recording of its own the page shows those that lie where the results go
    let sessions = args.record.is_none().then(|| args.out.clone());
    let console = ConsoleSettings { sessions, ..ConsoleSettings::demo() };
    let order = Order {
        station: None,
        operator: &operator,
        slave: &slave,
        network: None,
        console: Some(&console),
        hold: HoldToRun::Console,
        longest: longest(args.seconds)?,
        out: Some(&args.out),
        record: args.record.as_deref(),
    };
    note("rendering what the cameras will see ...");
    let interrupt = Interrupt::listen()?;
    tell_aside()?;
    order.carry_out(&interrupt, |console| {
        let url = console.url();
        say(format_args!("console         {url}"));
        note("open it, take control, reset, and hold the space bar to move the arm; Ctrl-C ends");
    })?;
    say(format_args!("results         {}", args.out.display()));
    Ok(())
}

/// An operator with both cameras of the scene, and a slave at the same computer.
pub(super) fn stations(args: &DemoArgs, scene: &Scene) -> (OperatorSettings, SlaveSettings) {
    let source = format!("sim:{}", scene.name);
    let cameras = CAMERAS.map(|view| HandCameraSettings {
        source: source.clone(),
        place: HandCamera::Local(Box::new(LocalCamera {
            source: source.clone(),
            options: Options { view, ..Options::default() },
            start: CameraStart::OfScene,
            focal_px: None,
            mode: args.mode,
        })),
        colours: Some(args.out.join(format!("colours-{}.toml", view.name()))),
        focal_px: None,
    });
    let operator = OperatorSettings {
        arm_m: scene.arm_m as f32,
        cameras: cameras.into(),
        slave: SlavePlace::Here,
        filter: args.filter.config(),
    };
    let eyes = CAMERAS.map(|view| SceneCameraSettings {
        place: SceneCamera::SimulatedArm,
        options: Options { view, fps: Some(EYE_FPS), ..Options::default() },
        fps: EYE_FPS,
        quality: EYE_QUALITY,
    });
    let slave = SlaveSettings { arm: ArmSettings::default(), operator: None, cameras: eyes.into() };
    (operator, slave)
}

#[cfg(test)]
mod tests;
