//! What `track`, `demo` and the stations write: CSV files as they go, and `summary.json` at the end.
//!
//! Every row is handed to the operating system at once, so what was written so far outlives an error.
//! Numbers have the fewest digits that read back as the same `f32`; what is not known is left empty.

mod arm;
mod arm_state;
mod aside;
mod csv;
mod delays;
mod hand;
mod observations;
mod picture;
mod recorder;
mod scan;
mod sent;
mod summary;
mod truth;

pub use arm::{ArmCsv, ArmRecord};
pub use arm_state::ArmStateCsv;
pub use aside::Aside;
pub use csv::{CsvFile, OutputError, Row};
pub use delays::write_delays;
pub use hand::{MotionCsv, PoseCovarianceCsv, PoseCsv};
pub use observations::{ObservationsCsv, UncertaintyCsv};
pub use picture::Canvas;
pub use recorder::{RecordedCamera, Recorder, Stamp};
pub use scan::ScanCsv;
pub use sent::SentCsv;
pub use summary::{CameraSummary, Spread, StateCounts, Summary};
pub use truth::TruthCsv;
