//! Seeded scene renderer with exact ground truth.
