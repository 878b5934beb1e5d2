//! What runs where: the parts of the stations that cross threads and wires.
//!
//! ```text
//! camera:    source --> CameraStation --observation packet--> (link, or CameraThread in the same process)
//!                           +-- Preview --picture--> (link)
//! smart camera:  serial port --> SerialNode --observation packet-->
//!                serial port <--> SmartCamera, which has it for itself: commands, observations
//! operator:  cameras' observations --> Operator (Pairing, HandStage) --motion, buttons--> the link
//! track:     pipeline --Step--> MotionSender --motion packet--> pipe, file
//! slave:     packets, hold-to-run --> SlaveStation --set-point--> robot port
//!            the link's motion, buttons --> LinkedSlave (a SlaveStation in it) --arm state--> the link
//! ```
//!
//! What decides reads no clock and opens no device, but is handed what came and when: by the commands, by
//! [`serve`], or by a thread beside it.

mod announcement;
pub mod arm_words;
mod asked;
mod back_off;
pub mod camera;
pub mod delays;
mod following;
mod jpeg;
mod linked_slave;
mod motion;
mod newest;
pub mod node;
pub mod operator;
mod overseer;
pub mod pairing;
mod picture_age;
mod picture_rate;
mod preview;
mod scene_camera;
mod serve;
mod slave;
mod trail;
mod unattended;

pub use announcement::{SlaveAnnouncement, UnreadableAnnouncement};
pub use asked::Asked;
pub use camera::{CameraCounts, CameraSink, CameraStation, CameraThread, Label};
pub use following::{Closeness, Following, Truth};
pub(crate) use jpeg::{encode_jpeg, jpeg};
pub use linked_slave::LinkedSlave;
pub use motion::MotionSender;
pub use node::{NodeCounts, SerialNode, SmartCamera, SmartCameraError, Told};
pub use operator::Operator;
pub use overseer::{Overseen, Overseer, SlaveTrouble};
pub use picture_age::{STALE_US, is_stale, picture_age_us};
pub use picture_rate::{LineState, PictureRate};
pub use preview::{Marks, Preview};
pub use scene_camera::{PictureLine, SceneCameras, SceneError};
pub use serve::{Served, serve};
pub use slave::{Cycle, SlaveStation};
pub use tetrad_core::arm::station::{EnableThenReset, NoReset, Reset, Resetting};
pub use trail::Trail;
pub use unattended::Unattended;
