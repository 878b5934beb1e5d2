//! What moves the arm goes first, what is only looked at gives way.
//!
//! Niceness would not do for the first: kernels of today let whatever runs finish its slice, four milliseconds,
//! before a thread of the same kind that has something to send.

/// What a thread does on the way from camera to arm; a later one goes before those above it, which take longer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Duty {
    /// It finds balls in pictures.
    Track = 1,
    /// It joins what was seen and sends it, or carries it.
    Send = 2,
    /// It keeps the arm's cycles, or those of its port.
    Drive = 3,
}

/// Puts the calling thread before all that is not on the way from camera to arm: at a real-time priority
/// (`SCHED_RR`), where the system lets it (docs/deploy.md). Elsewhere it stays as it is, and a busy computer delays it.
///
/// Threads that it starts are as threads are. One that fails to sleep leaves the rest a twentieth of a
/// processor, as the kernel has it.
pub(crate) fn step_forward(duty: Duty) {
    #[cfg(target_os = "linux")]
    {
        let param = libc::sched_param { sched_priority: i32::from(duty as u8) };
        let policy = libc::SCHED_RR | libc::SCHED_RESET_ON_FORK;
        // SAFETY: `param` outlives the call, which reads it; 0 is the calling thread alone. Not by the function of the
        // same name, which is for processes: some C libraries have none
        let _ = unsafe { libc::syscall(libc::SYS_sched_setscheduler, 0, policy, &raw const param) };
    }
    #[cfg(not(target_os = "linux"))]
    let _ = duty;
}

/// Makes the calling thread one niceness lower than it was. Where the system does not know of it, or does
/// not allow it, the thread stays as it is: it is slower to nobody's harm.
pub(crate) fn step_back() {
    #[cfg(target_os = "linux")]
    {
        // SAFETY: plain numbers in and out; under Linux 0 is the calling thread alone
        let before = unsafe { libc::getpriority(libc::PRIO_PROCESS, 0) };
        // SAFETY: as above
        let _ = unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, before.saturating_add(1)) };
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::thread::spawn;

    /// The policy, the real-time priority and the niceness of the calling thread.
    fn stands() -> [i64; 3] {
        let mut param = libc::sched_param { sched_priority: -1 };
        // SAFETY: plain numbers in and out
        let policy = unsafe { libc::syscall(libc::SYS_sched_getscheduler, 0) };
        // SAFETY: `param` outlives the call, which writes it
        unsafe { libc::syscall(libc::SYS_sched_getparam, 0, &raw mut param) };
        // SAFETY: plain numbers in and out
        let niceness = unsafe { libc::getpriority(libc::PRIO_PROCESS, 0) };
        [policy, i64::from(param.sched_priority), i64::from(niceness)]
    }

    #[test]
    fn it_is_the_calling_thread_alone_that_steps_back() {
        let before = stands();
        let [policy, priority, niceness] = before;
        let there = spawn(|| {
            step_back();
            stands()
        });
        assert_eq!(there.join().unwrap(), [policy, priority, (niceness + 1).min(19)]);
        assert_eq!(stands(), before);
    }

    #[test]
    fn it_is_the_calling_thread_alone_that_steps_forward_where_it_may() {
        let before = stands();
        for duty in [Duty::Track, Duty::Send, Duty::Drive] {
            let there = spawn(move || {
                step_forward(duty);
                (stands(), spawn(stands).join().unwrap())
            });
            let (stood, its_own) = there.join().unwrap();
            let round_robin = i64::from(libc::SCHED_RR | libc::SCHED_RESET_ON_FORK);
            let forward = [round_robin, duty as i64, before[2]];
            assert!(stood == forward || stood == before, "{duty:?}: {stood:?}");
            assert_eq!(its_own[..2], before[..2], "what it starts is as threads are");
        }
        assert_eq!(stands(), before);
    }
}
