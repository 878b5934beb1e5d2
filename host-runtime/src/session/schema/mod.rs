//! The messages of a session, and the descriptors that go with them into every file.
//!
//! Protobuf, because Foxglove's own schemas are and every reader of MCAP decodes it. The messages are
//! written out by hand beside their .proto files (proto/): a code generator would need protoc wherever
//! this is built, and the crate `foxglove` brings a runtime for live connections. A test compiles the
//! .proto files and compares them with [`DESCRIPTORS`], and each message with its descriptor.

pub mod foxglove;
pub mod tetrad;

/// A `google.protobuf.FileDescriptorSet` of every schema; `TETRAD_BLESS=1 cargo test -p tetrad session`
/// rewrites it.
pub const DESCRIPTORS: &[u8] = include_bytes!("../descriptors.bin");

#[cfg(test)]
mod tests;
