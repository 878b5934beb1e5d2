//! What is particular to a board: one file or folder each, chosen by a feature.

#[cfg(feature = "mps2")]
pub mod mps2;
#[cfg(feature = "stm32h743")]
pub mod stm32h743;
