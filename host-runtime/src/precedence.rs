//! What moves the arm goes first, what is only looked at gives way.

/// What a thread does on the way from camera to arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Duty {
    /// It finds balls in pictures. On a slow computer that may take all the time there is, so it may not take it from
    /// everybody else, of whom one hears STOP: a niceness of ten less than it was.
    Track,
    /// It joins what was seen and hears the operator's keys: little, and at once. Niceness would not do for that:
    /// kernels of today let whatever runs finish its slice, four milliseconds, before a thread that has something to do.
    Join,
    /// It keeps the arm's cycles, or those of its port, and goes before those that join.
    Drive,
}

/// How much less niceness a thread has that tracks.
const TRACKING: i32 = 10;

/// Puts the calling thread before all that is not on the way from camera to arm, where the system lets it
/// (docs/deploy.md). Elsewhere it stays as it is, a busy computer delays it, and the log says so.
///
/// Real-time priorities are for threads alone that nobody outside can keep busy: not for the network's, which
/// strangers may flood, nor for the console's, of whom one hears STOP beside that flood.
///
/// Threads that one with a real-time priority starts are as threads are.
pub(crate) fn step_forward(duty: Duty) {
    let allowed = match duty {
        Duty::Track => add_niceness(-TRACKING),
        Duty::Join => take_turns_at(1),
        Duty::Drive => take_turns_at(2),
    };
    if !allowed {
        tracing::info!(?duty, "this thread may not go before others: docs/deploy.md says how it may");
    }
}

/// Makes the calling thread one niceness lower than it was. Where the system does not know of it, or does
/// not allow it, the thread stays as it is: it is slower to nobody's harm.
pub(crate) fn step_back() {
    let _ = add_niceness(1);
}

/// A real-time priority, in turns with others that have the same (`SCHED_RR`). Whether it was given.
fn take_turns_at(priority: i32) -> bool {
    #[cfg(target_os = "linux")]
    {
        let param = libc::sched_param { sched_priority: priority };
        let policy = libc::SCHED_RR | libc::SCHED_RESET_ON_FORK;
        // SAFETY: `param` outlives the call, which reads it; 0 is the calling thread alone. Not by the function of the
        // same name, which is for processes: some C libraries have none
        let answer = unsafe { libc::syscall(libc::SYS_sched_setscheduler, 0, policy, &raw const param) };
        answer == 0
    }
    #[cfg(not(target_os = "linux"))]
    {
        let _ = priority;
        false
    }
}

/// Whether it was given.
fn add_niceness(more: i32) -> bool {
    #[cfg(target_os = "linux")]
    {
        // SAFETY: plain numbers in and out; under Linux 0 is the calling thread alone
        let before = unsafe { libc::getpriority(libc::PRIO_PROCESS, 0) };
        // SAFETY: as above
        let answer = unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, before.saturating_add(more)) };
        answer == 0
    }
    #[cfg(not(target_os = "linux"))]
    {
        let _ = more;
        false
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
        let [policy, priority, niceness] = before;
        let in_turns = i64::from(libc::SCHED_RR | libc::SCHED_RESET_ON_FORK);
        for (duty, forward) in [
            (Duty::Track, [policy, priority, (niceness - i64::from(TRACKING)).max(-20)]),
            (Duty::Join, [in_turns, 1, niceness]),
            (Duty::Drive, [in_turns, 2, niceness]),
        ] {
            let there = spawn(move || {
                step_forward(duty);
                (stands(), spawn(stands).join().unwrap())
            });
            let (stood, its_own) = there.join().unwrap();
            assert!(stood == forward || stood == before, "{duty:?}: {stood:?}");
            assert_eq!(its_own[..2], before[..2], "what it starts has no real-time priority");
        }
        assert_eq!(stands(), before);
    }
}
