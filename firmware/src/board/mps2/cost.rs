//! What a piece of work costs: its instructions, and its stack.
//!
//! QEMU has one instruction count as 1024 ns (`-icount shift=10`), so that the board's timer counts
//! instructions: exactly, and the same on every computer. Each figure is a line on standard output:
//! `name value unit`.

use super::{stack_of, time};
use semihosting::println;

/// Ticks of 40 ns in ten instructions of 1024 ns each.
const TICKS_OF_TEN: u64 = 256;

/// Runs `work` and tells its instructions, less those of looking at the clock.
#[must_use]
pub fn instructions(work: impl FnOnce()) -> u32 {
    let empty = time::ticks();
    let begin = time::ticks();
    work();
    let end = time::ticks();
    let ticks = end.wrapping_sub(begin).saturating_sub(begin.wrapping_sub(empty));
    u32::try_from(u64::from(ticks) * 10 / TICKS_OF_TEN).unwrap_or(u32::MAX)
}

/// The same work done twice: instructions of the first, stack of the second.
pub fn both(name: &str, mut work: impl FnMut()) {
    println!("{name} {} instructions", instructions(&mut work));
    println!("{name} {} stack", stack_of(&mut work));
}
