//! Tasks, and sleep between them.
//!
//! embassy's own executor for Cortex-M sleeps by WFE, which QEMU takes for a no-op: it would spin, and
//! virtual time that stands for instructions would run while nothing is done. This one sleeps by WFI.

use core::sync::atomic::{AtomicBool, Ordering};
use embassy_executor::{Spawner, raw};
use static_cell::StaticCell;

static WOKEN: AtomicBool = AtomicBool::new(false);

#[unsafe(export_name = "__pender")]
fn pender(_: *mut ()) {
    WOKEN.store(true, Ordering::SeqCst);
}

/// Runs the tasks that `spawn` starts, for ever.
///
/// # Panics
/// When called a second time.
pub fn run(spawn: impl FnOnce(Spawner)) -> ! {
    static EXECUTOR: StaticCell<raw::Executor> = StaticCell::new();
    let executor: &'static raw::Executor = EXECUTOR.init(raw::Executor::new(core::ptr::null_mut()));
    spawn(executor.spawner());
    loop {
        // SAFETY: the only call, and not from within itself: the cell above gives one executor once.
        unsafe { executor.poll() }
        cortex_m::interrupt::disable();
        if !WOKEN.swap(false, Ordering::SeqCst) {
            // an interrupt that comes between the look and the sleep ends the sleep: it is pending then
            cortex_m::asm::wfi();
        }
        // SAFETY: they were on before.
        unsafe { cortex_m::interrupt::enable() }
    }
}
