//! Tetrad's own messages, field by field as in proto/tetrad.proto.

/// What a session began with: with the pictures, all that its replay needs.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Configuration {
    /// Of the program that recorded.
    #[prost(string, tag = "1")]
    pub version: String,
    /// Chain.
    #[prost(enumeration = "Chain", tag = "2")]
    pub chain: i32,
    /// How the pose is computed: paper or refined.
    #[prost(string, tag = "3")]
    pub mode: String,
    /// The session's zero, microseconds of Unix time; 0 where its times are a recording's or a scene's.
    #[prost(uint64, tag = "4")]
    pub epoch_us: u64,
    /// Length of E1, E2 and E3; absent where no hand is solved for.
    #[prost(float, optional, tag = "5")]
    pub arm_m: Option<f32>,
    /// Filter.
    #[prost(message, optional, tag = "6")]
    pub filter: Option<Filter>,
    /// Cameras.
    #[prost(message, repeated, tag = "7")]
    pub cameras: Vec<Camera>,
}

/// One camera of a session.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Camera {
    /// As in the topics.
    #[prost(string, tag = "1")]
    pub name: String,
    /// SRC as it was given.
    #[prost(string, tag = "2")]
    pub source: String,
    /// Of its pictures; 0 where they are not recorded.
    #[prost(uint32, tag = "3")]
    pub width: u32,
    /// Height.
    #[prost(uint32, tag = "4")]
    pub height: u32,
    /// As in foxglove.RawImage; empty where they are not recorded.
    #[prost(string, tag = "5")]
    pub encoding: String,
    /// Pictures a second, where that is known beforehand.
    #[prost(double, optional, tag = "6")]
    pub fps: Option<f64>,
    /// Focal px.
    #[prost(float, optional, tag = "7")]
    pub focal_px: Option<f32>,
    /// How centres are computed: paper or refined.
    #[prost(string, tag = "8")]
    pub mode: String,
    /// Whether the balls are one rigid frame.
    #[prost(bool, tag = "9")]
    pub rigid: bool,
    /// Those that are tracked.
    #[prost(message, repeated, tag = "10")]
    pub balls: Vec<LearntBall>,
}

/// A ball as it was taught in one camera.
#[derive(Clone, PartialEq, prost::Message)]
pub struct LearntBall {
    /// Ball.
    #[prost(string, tag = "1")]
    pub ball: String,
    /// Which of the paper's six V judges it, 1 to 6.
    #[prost(uint32, tag = "2")]
    pub primary: u32,
    /// Reference.
    #[prost(message, optional, tag = "3")]
    pub reference: Option<Colour>,
    /// Typical.
    #[prost(message, optional, tag = "4")]
    pub typical: Option<Colour>,
    /// Background.
    #[prost(message, optional, tag = "5")]
    pub background: Option<Colour>,
    /// Diameter px.
    #[prost(float, tag = "6")]
    pub diameter_px: f32,
    /// Aspect.
    #[prost(float, tag = "7")]
    pub aspect: f32,
    /// Where it is in the first picture; absent where it is searched for.
    #[prost(message, optional, tag = "8")]
    pub place: Option<Place>,
}

/// A camera was taught anew: from a picture on it looks for these balls, anywhere.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Taught {
    /// That picture's number: the sequence of its message.
    #[prost(uint32, tag = "1")]
    pub frame: u32,
    /// Time us.
    #[prost(uint64, tag = "2")]
    pub time_us: u64,
    /// Whether the balls are one rigid frame.
    #[prost(bool, tag = "3")]
    pub rigid: bool,
    /// Those that are tracked from there on.
    #[prost(message, repeated, tag = "4")]
    pub balls: Vec<LearntBall>,
}

/// The hand was set up anew: it is another, of which nothing is known but its arms, and its pose is told in
/// the axes of its own first complete instant.
#[derive(Clone, PartialEq, prost::Message)]
pub struct HandBegins {
    /// The first instant that may be of it, as Hand.frame counts.
    #[prost(uint64, tag = "1")]
    pub frame: u64,
    /// Time us.
    #[prost(uint64, tag = "2")]
    pub time_us: u64,
    /// Length of E1, E2 and E3.
    #[prost(float, repeated, tag = "3")]
    pub arms_m: Vec<f32>,
}

/// Eight bits a component.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Colour {
    /// R.
    #[prost(uint32, tag = "1")]
    pub r: u32,
    /// G.
    #[prost(uint32, tag = "2")]
    pub g: u32,
    /// B.
    #[prost(uint32, tag = "3")]
    pub b: u32,
}

/// A place in a picture, px.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Place {
    /// U.
    #[prost(float, tag = "1")]
    pub u: f32,
    /// V.
    #[prost(float, tag = "2")]
    pub v: f32,
}

/// How the pose is smoothed and carried on.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Filter {
    /// Smoothed.
    #[prost(bool, tag = "1")]
    pub smoothed: bool,
    /// Min cutoff hz.
    #[prost(float, tag = "2")]
    pub min_cutoff_hz: f32,
    /// Cutoff per m s.
    #[prost(float, tag = "3")]
    pub cutoff_per_m_s: f32,
    /// Turn min cutoff hz.
    #[prost(float, tag = "4")]
    pub turn_min_cutoff_hz: f32,
    /// Turn cutoff per rad s.
    #[prost(float, tag = "5")]
    pub turn_cutoff_per_rad_s: f32,
    /// Carried on at constant acceleration rather than velocity.
    #[prost(bool, tag = "6")]
    pub acceleration: bool,
    /// Lead us.
    #[prost(uint32, tag = "7")]
    pub lead_us: u32,
    /// Memory us.
    #[prost(uint32, tag = "8")]
    pub memory_us: u32,
    /// Coast us.
    #[prost(uint32, tag = "9")]
    pub coast_us: u32,
    /// Restart us.
    #[prost(uint32, tag = "10")]
    pub restart_us: u32,
    /// Max speed m s.
    #[prost(float, tag = "11")]
    pub max_speed_m_s: f32,
    /// Max turn rad s.
    #[prost(float, tag = "12")]
    pub max_turn_rad_s: f32,
    /// Max acceleration m s2.
    #[prost(float, tag = "13")]
    pub max_acceleration_m_s2: f32,
}

/// One ball in one picture.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Observation {
    /// State.
    #[prost(enumeration = "BallState", tag = "1")]
    pub state: i32,
    /// The centre, and the covariance of its error, px^2.
    #[prost(float, tag = "2")]
    pub u: f32,
    /// V.
    #[prost(float, tag = "3")]
    pub v: f32,
    /// Diameter.
    #[prost(float, tag = "4")]
    pub diameter: f32,
    /// Uu.
    #[prost(float, tag = "5")]
    pub uu: f32,
    /// Uv.
    #[prost(float, tag = "6")]
    pub uv: f32,
    /// Vv.
    #[prost(float, tag = "7")]
    pub vv: f32,
    /// The share of the rim that was seen.
    #[prost(float, tag = "8")]
    pub visible: f32,
}

/// What one camera saw in one picture.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Observations {
    /// What the picture is called; a station's pictures count from 0.
    #[prost(uint64, tag = "1")]
    pub frame: u64,
    /// Capture us.
    #[prost(uint64, tag = "2")]
    pub capture_us: u64,
    /// Pictures that are missing before this one.
    #[prost(uint64, tag = "3")]
    pub missed: u64,
    /// Pixels tested.
    #[prost(uint32, tag = "4")]
    pub pixels_tested: u32,
    /// Red, green, blue, yellow.
    #[prost(message, repeated, tag = "5")]
    pub balls: Vec<Observation>,
    /// Width.
    #[prost(uint32, tag = "6")]
    pub width: u32,
    /// Height.
    #[prost(uint32, tag = "7")]
    pub height: u32,
    /// When the picture was whole in memory, when the balls were found, when the operator had them; 0 where
    /// that was not measured.
    #[prost(uint64, tag = "8")]
    pub ready_us: u64,
    /// Observed us.
    #[prost(uint64, tag = "9")]
    pub observed_us: u64,
    /// Received us.
    #[prost(uint64, tag = "10")]
    pub received_us: u64,
}

/// a_from_b.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Transform {
    /// b's origin in a: x, y, z.
    #[prost(float, repeated, tag = "1")]
    pub translation: Vec<f32>,
    /// Row by row: r11, r12, r13, r21, ...
    #[prost(float, repeated, tag = "2")]
    pub rotation: Vec<f32>,
}

/// How the hand moved.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Motion {
    /// The paper's alpha and Phi: R(t)_from_R(t+1).
    #[prost(message, optional, tag = "1")]
    pub increment: Option<Transform>,
    /// engage_from_now.
    #[prost(message, optional, tag = "2")]
    pub since_engage: Option<Transform>,
    /// Engagements.
    #[prost(uint32, tag = "3")]
    pub engagements: u32,
    /// Residual px.
    #[prost(float, tag = "4")]
    pub residual_px: f32,
    /// Frames that the increment spans.
    #[prost(uint32, tag = "5")]
    pub spans: u32,
}

/// Where the hand is, to the bit.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Hand {
    /// The first camera's; a station's instants count from 0.
    #[prost(uint64, tag = "1")]
    pub frame: u64,
    /// Capture us.
    #[prost(uint64, tag = "2")]
    pub capture_us: u64,
    /// State.
    #[prost(enumeration = "HandState", tag = "3")]
    pub state: i32,
    /// Pose.
    #[prost(message, optional, tag = "4")]
    pub pose: Option<Transform>,
    /// Filtered.
    #[prost(message, optional, tag = "5")]
    pub filtered: Option<Transform>,
    /// The upper triangle of the pose's covariance row by row, 21 numbers; none where nothing is said.
    #[prost(float, repeated, tag = "6")]
    pub covariance: Vec<f32>,
    /// What moved since the last measured frame; absent where `refusal` says why.
    #[prost(message, optional, tag = "7")]
    pub motion: Option<Motion>,
    /// Refusal.
    #[prost(string, tag = "8")]
    pub refusal: String,
    /// How many times the hand was latched.
    #[prost(uint32, tag = "9")]
    pub engagements: u32,
}

/// An instant to which an operator joined the cameras: when it asked, and what it got.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Instant {
    /// Capture us.
    #[prost(uint64, tag = "1")]
    pub capture_us: u64,
    /// The operator's clock when it asked for the next instant.
    #[prost(uint64, tag = "2")]
    pub asked_us: u64,
    /// The camera whose picture was taken then, from 0.
    #[prost(uint32, tag = "3")]
    pub reference: u32,
    /// Views.
    #[prost(message, repeated, tag = "4")]
    pub views: Vec<View>,
}

/// A camera's part of an instant.
#[derive(Clone, PartialEq, prost::Message)]
pub struct View {
    /// Known.
    #[prost(enumeration = "Known", tag = "1")]
    pub known: i32,
    /// How far the two pictures around the instant lie apart.
    #[prost(uint64, tag = "2")]
    pub between_us: u64,
    /// Balls.
    #[prost(message, repeated, tag = "3")]
    pub balls: Vec<Observation>,
}

/// What the slave was told.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Command {
    /// Sequence.
    #[prost(uint32, tag = "1")]
    pub sequence: u32,
    /// Capture us.
    #[prost(uint64, tag = "2")]
    pub capture_us: u64,
    /// The operator moves the arm.
    #[prost(bool, tag = "3")]
    pub engaged: bool,
    /// State.
    #[prost(enumeration = "HandState", tag = "4")]
    pub state: i32,
    /// Motion.
    #[prost(message, optional, tag = "5")]
    pub motion: Option<Motion>,
    /// In how many cameras each ball was measured: red, green, blue, yellow.
    #[prost(uint32, repeated, tag = "6")]
    pub seen_in: Vec<u32>,
}

/// The operator's buttons.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Buttons {
    /// Time us.
    #[prost(uint64, tag = "1")]
    pub time_us: u64,
    /// Pressed.
    #[prost(bool, tag = "2")]
    pub pressed: bool,
    /// Stop.
    #[prost(bool, tag = "3")]
    pub stop: bool,
    /// Resets.
    #[prost(uint32, tag = "4")]
    pub resets: u32,
    /// The press is for the way home, not for following the hand.
    #[prost(bool, tag = "5")]
    pub home: bool,
    /// Percent of the slave's scale by which the next press follows.
    #[prost(uint32, tag = "6")]
    pub scale_percent: u32,
}

/// What the slave said of its arm.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Arm {
    /// Sequence.
    #[prost(uint32, tag = "1")]
    pub sequence: u32,
    /// When it was so, by the slave's clock.
    #[prost(uint64, tag = "2")]
    pub slave_us: u64,
    /// Received us.
    #[prost(uint64, tag = "3")]
    pub received_us: u64,
    /// State.
    #[prost(string, tag = "4")]
    pub state: String,
    /// In words.
    #[prost(string, tag = "5")]
    pub standing: String,
    /// Limits.
    #[prost(string, repeated, tag = "6")]
    pub limits: Vec<String>,
    /// The share of its speed that is asked for.
    #[prost(float, tag = "7")]
    pub speed_share: f32,
    /// How old the newest motion was, by the slave's clock.
    #[prost(uint64, optional, tag = "8")]
    pub command_age_us: Option<u64>,
    /// Joints, radians.
    #[prost(float, repeated, tag = "9")]
    pub set_point: Vec<f32>,
    /// None where they could not be read.
    #[prost(float, repeated, tag = "10")]
    pub measured: Vec<f32>,
    /// base_from_tool at the set-point.
    #[prost(message, optional, tag = "11")]
    pub tool: Option<Transform>,
    /// What keeps it from following as it was asked, in words.
    #[prost(string, repeated, tag = "12")]
    pub slowed: Vec<String>,
    /// Metres of the tool for one of the hand.
    #[prost(float, tag = "13")]
    pub scale: f32,
}

/// One stage of the way.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Stage {
    /// Name.
    #[prost(string, tag = "1")]
    pub name: String,
    /// Count.
    #[prost(uint64, tag = "2")]
    pub count: u64,
    /// P50 us.
    #[prost(uint64, tag = "3")]
    pub p50_us: u64,
    /// P99 us.
    #[prost(uint64, tag = "4")]
    pub p99_us: u64,
    /// Max us.
    #[prost(uint64, tag = "5")]
    pub max_us: u64,
}

/// How long each stage from a picture to the arm took so far.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Delays {
    /// Time us.
    #[prost(uint64, tag = "1")]
    pub time_us: u64,
    /// Stages.
    #[prost(message, repeated, tag = "2")]
    pub stages: Vec<Stage>,
}

/// Configuration.Chain of the .proto file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum Chain {
    /// Unknown.
    Unknown = 0,
    /// Pictures in pairs through one pipeline, as `tetrad track` and `tetrad record` have it.
    Pairs = 1,
    /// Cameras for themselves, joined by time, as `tetrad operator` has it.
    Stations = 2,
}

/// Observation.State of the .proto file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum BallState {
    /// Visible.
    Visible = 0,
    /// Occluded.
    Occluded = 1,
    /// Predicted.
    Predicted = 2,
    /// Lost.
    Lost = 3,
}

/// Hand.State of the .proto file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum HandState {
    /// Both.
    Both = 0,
    /// Three.
    Three = 1,
    /// One.
    One = 2,
    /// Predicted.
    Predicted = 3,
    /// Held.
    Held = 4,
    /// Lost.
    Lost = 5,
}

/// View.Known of the .proto file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum Known {
    /// Missing.
    Missing = 0,
    /// Seen.
    Seen = 1,
    /// Between.
    Between = 2,
}
