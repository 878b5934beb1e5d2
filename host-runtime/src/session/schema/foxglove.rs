//! Foxglove's messages, field by field as in proto/foxglove.

/// A point in time.
#[derive(Clone, Copy, PartialEq, Eq, prost::Message)]
pub struct Timestamp {
    /// Seconds since 1970.
    #[prost(int64, tag = "1")]
    pub seconds: i64,
    /// Nanoseconds of the second.
    #[prost(int32, tag = "2")]
    pub nanos: i32,
}

impl Timestamp {
    /// So many microseconds since 1970.
    #[must_use]
    pub fn of_us(us: u64) -> Self {
        Self {
            seconds: i64::try_from(us / 1_000_000).unwrap_or(i64::MAX),
            // below 1e9
            nanos: (us % 1_000_000) as i32 * 1_000,
        }
    }

    /// Microseconds since 1970; nothing before.
    #[must_use]
    pub fn us(&self) -> u64 {
        let (seconds, nanos) = (u64::try_from(self.seconds), u64::try_from(self.nanos));
        seconds.unwrap_or(0).saturating_mul(1_000_000).saturating_add(nanos.unwrap_or(0) / 1_000)
    }
}

/// A picture as it was captured.
#[derive(Clone, PartialEq, prost::Message)]
pub struct RawImage {
    /// When.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// The camera.
    #[prost(string, tag = "7")]
    pub frame_id: String,
    /// Pixels.
    #[prost(fixed32, tag = "2")]
    pub width: u32,
    /// Pixels.
    #[prost(fixed32, tag = "3")]
    pub height: u32,
    /// How pixels lie in memory.
    #[prost(string, tag = "4")]
    pub encoding: String,
    /// Bytes from one row to the next.
    #[prost(fixed32, tag = "5")]
    pub step: u32,
    /// The rows.
    #[prost(bytes = "vec", tag = "6")]
    pub data: Vec<u8>,
}

/// A colour, 0 to 1.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Color {
    /// Red.
    #[prost(double, tag = "1")]
    pub r: f64,
    /// Green.
    #[prost(double, tag = "2")]
    pub g: f64,
    /// Blue.
    #[prost(double, tag = "3")]
    pub b: f64,
    /// 1 where nothing shines through.
    #[prost(double, tag = "4")]
    pub a: f64,
}

/// A place in a picture.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Point2 {
    /// To the right.
    #[prost(double, tag = "1")]
    pub x: f64,
    /// Down.
    #[prost(double, tag = "2")]
    pub y: f64,
}

/// A circle over a picture.
#[derive(Clone, PartialEq, prost::Message)]
pub struct CircleAnnotation {
    /// Of which picture.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Its centre.
    #[prost(message, optional, tag = "2")]
    pub position: Option<Point2>,
    /// Pixels.
    #[prost(double, tag = "3")]
    pub diameter: f64,
    /// Of the line, pixels.
    #[prost(double, tag = "4")]
    pub thickness: f64,
    /// Inside.
    #[prost(message, optional, tag = "5")]
    pub fill_color: Option<Color>,
    /// The line.
    #[prost(message, optional, tag = "6")]
    pub outline_color: Option<Color>,
}

/// Words over a picture.
#[derive(Clone, PartialEq, prost::Message)]
pub struct TextAnnotation {
    /// Of which picture.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// The lower left end.
    #[prost(message, optional, tag = "2")]
    pub position: Option<Point2>,
    /// The words.
    #[prost(string, tag = "3")]
    pub text: String,
    /// Pixels.
    #[prost(double, tag = "4")]
    pub font_size: f64,
    /// Of the letters.
    #[prost(message, optional, tag = "5")]
    pub text_color: Option<Color>,
    /// Behind them.
    #[prost(message, optional, tag = "6")]
    pub background_color: Option<Color>,
}

/// What is drawn over a picture.
#[derive(Clone, PartialEq, prost::Message)]
pub struct ImageAnnotations {
    /// Circles.
    #[prost(message, repeated, tag = "1")]
    pub circles: Vec<CircleAnnotation>,
    /// Words.
    #[prost(message, repeated, tag = "3")]
    pub texts: Vec<TextAnnotation>,
    /// Of which picture.
    #[prost(message, optional, tag = "5")]
    pub timestamp: Option<Timestamp>,
}

/// A place or a direction in space.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Vector3 {
    /// Metres.
    #[prost(double, tag = "1")]
    pub x: f64,
    /// Metres.
    #[prost(double, tag = "2")]
    pub y: f64,
    /// Metres.
    #[prost(double, tag = "3")]
    pub z: f64,
}

/// A rotation.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Quaternion {
    /// i
    #[prost(double, tag = "1")]
    pub x: f64,
    /// j
    #[prost(double, tag = "2")]
    pub y: f64,
    /// k
    #[prost(double, tag = "3")]
    pub z: f64,
    /// 1
    #[prost(double, tag = "4")]
    pub w: f64,
}

/// A place and a rotation.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Pose {
    /// Where.
    #[prost(message, optional, tag = "1")]
    pub position: Option<Vector3>,
    /// How it is turned.
    #[prost(message, optional, tag = "2")]
    pub orientation: Option<Quaternion>,
}

/// A pose in a named frame.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PoseInFrame {
    /// When.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// The frame.
    #[prost(string, tag = "2")]
    pub frame_id: String,
    /// The pose.
    #[prost(message, optional, tag = "3")]
    pub pose: Option<Pose>,
}

/// parent_from_child.
#[derive(Clone, PartialEq, prost::Message)]
pub struct FrameTransform {
    /// When.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// The frame that it is told in.
    #[prost(string, tag = "2")]
    pub parent_frame_id: String,
    /// The frame that is told.
    #[prost(string, tag = "3")]
    pub child_frame_id: String,
    /// The child's origin.
    #[prost(message, optional, tag = "4")]
    pub translation: Option<Vector3>,
    /// How the child is turned.
    #[prost(message, optional, tag = "5")]
    pub rotation: Option<Quaternion>,
}

/// One joint.
#[derive(Clone, PartialEq, prost::Message)]
pub struct JointState {
    /// Its name.
    #[prost(string, tag = "1")]
    pub name: String,
    /// Radians.
    #[prost(double, optional, tag = "2")]
    pub position: Option<f64>,
    /// rad/s
    #[prost(double, optional, tag = "3")]
    pub velocity: Option<f64>,
    /// rad/s^2
    #[prost(double, optional, tag = "4")]
    pub acceleration: Option<f64>,
    /// N m
    #[prost(double, optional, tag = "5")]
    pub effort: Option<f64>,
}

/// The joints of an arm.
#[derive(Clone, PartialEq, prost::Message)]
pub struct JointStates {
    /// When.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// From the base on.
    #[prost(message, repeated, tag = "2")]
    pub joints: Vec<JointState>,
}

/// A line that somebody should read.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Log {
    /// When.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// How bad it is.
    #[prost(enumeration = "Level", tag = "2")]
    pub level: i32,
    /// What it says.
    #[prost(string, tag = "3")]
    pub message: String,
    /// Who says it.
    #[prost(string, tag = "4")]
    pub name: String,
}

/// How bad something is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum Level {
    /// Nobody says.
    Unknown = 0,
    /// For whoever looks for a fault.
    Debug = 1,
    /// To be known.
    Info = 2,
    /// To be looked at.
    Warning = 3,
    /// Something failed.
    Error = 4,
    /// Everything did.
    Fatal = 5,
}
