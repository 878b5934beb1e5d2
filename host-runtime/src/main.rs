//! The `tetrad` program.
fn main() {}
