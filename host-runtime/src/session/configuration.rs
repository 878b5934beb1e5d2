//! What a session began with, as it is written, and what its replay makes of it.

use super::picture;
use super::schema::tetrad as msg;
use super::taught;
use crate::balls::BallSet;
use crate::pipeline::{CameraStart, PipelineConfig};
use crate::settings::Mode;
use tetrad_core::config::{FilterConfig, OneEuroConfig, Prediction, Smoothing, TrackerConfig};
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::filter::PoseFilter;
use tetrad_core::vision::frame::PixelFormat;

/// A camera whose pictures are recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Pictures {
    /// Width and height, px.
    pub size: (u16, u16),
    /// How they lie in memory.
    pub format: PixelFormat,
    /// How many come in a second, where that is known.
    pub fps: Option<f64>,
}

/// A camera as a session begins with it.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraBeginning {
    /// As its topics are called.
    pub name: String,
    /// SRC as it was given.
    pub source: String,
    /// `None` where only its observations are.
    pub pictures: Option<Pictures>,
    /// What its tracker starts with; no balls where it is tracked elsewhere.
    pub start: CameraStart,
    /// How centres are computed.
    pub mode: Mode,
    /// Whether its balls are one rigid frame.
    pub rigid: bool,
}

/// Everything a session begins with.
#[derive(Clone, Debug, PartialEq)]
pub struct Beginning {
    /// Pairs of pictures, or stations for themselves.
    pub chain: msg::Chain,
    /// How the pose is computed.
    pub mode: Mode,
    /// The session's zero, microseconds of Unix time.
    pub epoch_us: u64,
    /// The arms' length, where a hand is solved for.
    pub arm_m: Option<f32>,
    /// How the pose is filtered.
    pub filter: FilterConfig,
    /// In their order.
    pub cameras: Vec<CameraBeginning>,
}

impl Beginning {
    /// As it is written.
    #[must_use]
    pub fn message(&self) -> msg::Configuration {
        msg::Configuration {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            chain: self.chain.into(),
            mode: self.mode.name().to_owned(),
            epoch_us: self.epoch_us,
            arm_m: self.arm_m,
            filter: Some(filter_message(&self.filter)),
            cameras: self.cameras.iter().map(camera_message).collect(),
        }
    }

    /// As it was read.
    ///
    /// # Errors
    /// What is missing, or not among what there can be.
    pub fn of(message: &msg::Configuration) -> Result<Self, String> {
        let chain = message.chain();
        if chain == msg::Chain::Unknown {
            return Err("it does not say how it was made".to_owned());
        }
        let filter = message.filter.as_ref().ok_or("it does not say how the pose is filtered")?;
        if message.cameras.is_empty() {
            return Err("it has no camera".to_owned());
        }
        Ok(Self {
            chain,
            mode: mode(&message.mode)?,
            epoch_us: message.epoch_us,
            arm_m: message.arm_m,
            filter: filter_of(filter),
            cameras: message.cameras.iter().map(camera_of).collect::<Result<_, _>>()?,
        })
    }

    /// How everything is computed.
    #[must_use]
    pub fn pipeline(&self) -> PipelineConfig {
        let config = self.mode.pipeline();
        let rigid = self.cameras.first().is_some_and(|camera| camera.rigid);
        PipelineConfig { tracker: TrackerConfig { rigid, ..config.tracker }, ..config }
    }

    /// The feature frame, where there is one.
    ///
    /// # Errors
    /// A length that no arms have.
    pub fn arms(&self) -> Result<Option<Arms>, String> {
        let arms = self.arm_m.map(Arms::equal).transpose();
        arms.map_err(|error| format!("arms of {:?} m: {error}", self.arm_m))
    }

    /// The filter, at rest.
    ///
    /// # Errors
    /// Settings that cannot be worked with.
    pub fn pose_filter(&self) -> Result<PoseFilter, String> {
        PoseFilter::new(self.filter).map_err(|error| format!("the pose filter: {error}"))
    }

    /// The cameras' names, as topics have them.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.cameras.iter().map(|camera| camera.name.clone()).collect()
    }

    /// The balls that are tracked; of stations any may be, for they are taught anew while they run.
    #[must_use]
    pub fn balls(&self) -> BallSet {
        if self.chain == msg::Chain::Stations {
            return BallSet::ALL;
        }
        let known = self.cameras.iter().find_map(|camera| BallSet::known(&camera.start.balls));
        known.unwrap_or(BallSet::ALL)
    }
}

impl CameraBeginning {
    /// How this camera's balls are tracked.
    #[must_use]
    pub fn tracker(&self) -> TrackerConfig {
        TrackerConfig { rigid: self.rigid, ..self.mode.pipeline().tracker }
    }
}

fn mode(name: &str) -> Result<Mode, String> {
    [Mode::Paper, Mode::Refined]
        .into_iter()
        .find(|mode| mode.name() == name)
        .ok_or_else(|| format!("there is no mode `{name}`"))
}

fn camera_message(camera: &CameraBeginning) -> msg::Camera {
    let (width, height) = camera.pictures.as_ref().map_or((0, 0), |pictures| pictures.size);
    msg::Camera {
        name: camera.name.clone(),
        source: camera.source.clone(),
        width: u32::from(width),
        height: u32::from(height),
        encoding: camera
            .pictures
            .as_ref()
            .map_or_else(String::new, |pictures| picture::encoding(pictures.format).to_owned()),
        fps: camera.pictures.as_ref().and_then(|pictures| pictures.fps),
        focal_px: camera.start.focal_px,
        mode: camera.mode.name().to_owned(),
        rigid: camera.rigid,
        balls: taught::balls_message(&camera.start.balls, &camera.start.places),
    }
}

fn camera_of(message: &msg::Camera) -> Result<CameraBeginning, String> {
    let name = &message.name;
    let pictures = if message.encoding.is_empty() {
        None
    } else {
        let side = |side: u32| {
            u16::try_from(side).map_err(|_| format!("camera {name}: a side of {side} pixels is too long"))
        };
        let format = picture::format(&message.encoding).ok_or_else(|| {
            format!("camera {name}: pictures in the format `{}` are not read here", message.encoding)
        })?;
        let size = (side(message.width)?, side(message.height)?);
        Some(Pictures { size, format, fps: message.fps.filter(|fps| fps.is_finite() && *fps > 0.0) })
    };
    let (balls, places) =
        taught::balls_of(&message.balls).map_err(|reason| format!("camera {name}: {reason}"))?;
    let start = CameraStart { balls, places, focal_px: message.focal_px };
    Ok(CameraBeginning {
        name: name.clone(),
        source: message.source.clone(),
        pictures,
        start,
        mode: mode(&message.mode)?,
        rigid: message.rigid,
    })
}

fn filter_message(filter: &FilterConfig) -> msg::Filter {
    let (smoothed, euro) = match filter.smoothing {
        Smoothing::OneEuro(euro) => (true, euro),
        Smoothing::Off => (false, OneEuroConfig::default()),
    };
    msg::Filter {
        smoothed,
        min_cutoff_hz: euro.min_cutoff_hz,
        cutoff_per_m_s: euro.cutoff_per_m_s,
        turn_min_cutoff_hz: euro.turn_min_cutoff_hz,
        turn_cutoff_per_rad_s: euro.turn_cutoff_per_rad_s,
        acceleration: filter.prediction == Prediction::Acceleration,
        lead_us: filter.lead_us,
        memory_us: filter.memory_us,
        coast_us: filter.coast_us,
        restart_us: filter.restart_us,
        max_speed_m_s: filter.max_speed_m_s,
        max_turn_rad_s: filter.max_turn_rad_s,
        max_acceleration_m_s2: filter.max_acceleration_m_s2,
    }
}

fn filter_of(message: &msg::Filter) -> FilterConfig {
    let euro = OneEuroConfig {
        min_cutoff_hz: message.min_cutoff_hz,
        cutoff_per_m_s: message.cutoff_per_m_s,
        turn_min_cutoff_hz: message.turn_min_cutoff_hz,
        turn_cutoff_per_rad_s: message.turn_cutoff_per_rad_s,
    };
    FilterConfig {
        smoothing: if message.smoothed { Smoothing::OneEuro(euro) } else { Smoothing::Off },
        prediction: if message.acceleration { Prediction::Acceleration } else { Prediction::Velocity },
        lead_us: message.lead_us,
        memory_us: message.memory_us,
        coast_us: message.coast_us,
        restart_us: message.restart_us,
        max_speed_m_s: message.max_speed_m_s,
        max_turn_rad_s: message.max_turn_rad_s,
        max_acceleration_m_s2: message.max_acceleration_m_s2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prost::Message as _;
    use tetrad_core::geometry::ImagePoint;
    use tetrad_core::observation::BALLS;
    use tetrad_core::vision::appearance::LearntBall;
    use tetrad_core::vision::colour::{Primary, Reference};
    use tetrad_core::vision::frame::Rgb;

    fn beginning() -> Beginning {
        let learnt = LearntBall {
            reference: Reference {
                primary: Primary::Yellow,
                reference: Rgb::new(250, 240, 3),
                typical: Rgb::new(200, 190, 30),
                background: Rgb::new(0, 128, 255),
            },
            diameter: 1.0 / 3.0 + 12.0,
            aspect: 1.1,
        };
        let start = CameraStart {
            balls: [Some(learnt), None, None, Some(LearntBall { diameter: 9.5, ..learnt })],
            places: [None, None, None, Some(ImagePoint::new(12.5, 0.1))],
            focal_px: Some(801.5),
        };
        let pictures = Pictures { size: (640, 480), format: PixelFormat::Nv12, fps: Some(29.97) };
        let left = CameraBeginning {
            name: "left".to_owned(),
            source: "/dev/video0".to_owned(),
            pictures: Some(pictures),
            start,
            mode: Mode::Paper,
            rigid: true,
        };
        let right = CameraBeginning {
            name: "right".to_owned(),
            source: "node:right".to_owned(),
            pictures: None,
            start: CameraStart { focal_px: None, ..CameraStart::anywhere([None; BALLS]) },
            mode: Mode::Refined,
            rigid: false,
        };
        Beginning {
            chain: msg::Chain::Stations,
            mode: Mode::Refined,
            epoch_us: 1_700_000_000_000_000,
            arm_m: Some(0.08),
            filter: FilterConfig {
                smoothing: Smoothing::Off,
                prediction: Prediction::Acceleration,
                lead_us: 30_000,
                ..FilterConfig::default()
            },
            cameras: vec![left, right],
        }
    }

    #[test]
    fn what_a_session_began_with_comes_back() {
        for filter in [beginning().filter, FilterConfig::default()] {
            let beginning = Beginning { filter, ..beginning() };
            let bytes = beginning.message().encode_to_vec();
            let back = Beginning::of(&msg::Configuration::decode(bytes.as_slice()).unwrap()).unwrap();
            assert_eq!(back, beginning);
            assert_eq!(back.balls(), BallSet::ALL, "whatever it is taught later");
        }
    }

    #[test]
    fn what_is_missing_is_named() {
        let refused = |change: &dyn Fn(&mut msg::Configuration)| {
            let mut message = beginning().message();
            change(&mut message);
            Beginning::of(&message).unwrap_err()
        };
        assert_eq!(refused(&|m| m.chain = 0), "it does not say how it was made");
        assert_eq!(refused(&|m| m.cameras.clear()), "it has no camera");
        assert_eq!(refused(&|m| m.mode = "rough".to_owned()), "there is no mode `rough`");
        assert!(refused(&|m| m.filter = None).contains("filtered"));
        assert!(
            refused(&|m| m.cameras[0].encoding = "mono8".to_owned()).contains("camera left: pictures in")
        );
        assert!(refused(&|m| m.cameras[0].width = 70_000).contains("70000"));
        assert!(refused(&|m| m.cameras[0].balls[0].ball = "pink".to_owned()).contains("no ball `pink`"));
        assert!(refused(&|m| m.cameras[0].balls[0].primary = 7).contains("the red ball has no colours"));
    }
}
