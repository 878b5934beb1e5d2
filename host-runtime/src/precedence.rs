//! What moves the arm goes first, what is only looked at gives way.

use std::time::{Duration, Instant};

/// What a thread does on the way from camera to arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Duty {
    /// It finds balls in pictures. On a slow computer that may take all the time there is, and others, of whom one hears
    /// STOP, would get next to none: it goes first only while it takes little ([`Tracking`]).
    Track,
    /// It joins what was seen and hears the operator's keys: little, and at once. Niceness would not do for that:
    /// kernels of today let whatever runs finish its slice, four milliseconds, before a thread that has something to do.
    Join,
    /// It keeps the arm's cycles, or those of its port, and goes before those that join.
    Drive,
}

/// Puts the calling thread before all that is not on the way from camera to arm, where the system lets it
/// (docs/deploy.md). Elsewhere it stays as it is, a busy computer delays it, and the log says so.
///
/// Real-time priorities are for threads alone that nobody outside can keep busy: not for the network's, which
/// strangers may flood, nor for the console's, of whom one hears STOP beside that flood.
///
/// Threads that one with a real-time priority starts are as threads are.
pub(crate) fn step_forward(duty: Duty) {
    let allowed = match duty {
        Duty::Track => take_turns_at(1),
        Duty::Join => take_turns_at(2),
        Duty::Drive => take_turns_at(3),
    };
    if !allowed {
        tracing::info!(?duty, "this thread may not go before others: docs/deploy.md says how it may");
    }
}

/// Whether threads of this program may go before others here; a thread is made for it that ends at once.
pub(crate) fn may_step_forward() -> bool {
    std::thread::spawn(|| take_turns_at(3)).join().unwrap_or(false)
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

/// So much of a processor a thread may take that goes first, and so little it takes before it goes first again.
const MOST_SHARE: f64 = 0.5;
const AGAIN_SHARE: f64 = 0.3;

/// That is looked at so often.
const LOOK: Duration = Duration::from_secs(1);

/// A thread that tracks goes first while it takes little of its processor.
#[derive(Debug)]
pub(crate) struct Tracking {
    goes_first: bool,
    looked: Instant,
    taken: Duration,
}

impl Tracking {
    /// Puts the calling thread first.
    pub(crate) fn begin() -> Self {
        step_forward(Duty::Track);
        Self { goes_first: true, looked: Instant::now(), taken: taken() }
    }

    /// To be called by the same thread after each picture.
    pub(crate) fn look(&mut self) {
        let (now, taken) = (Instant::now(), taken());
        let since = now.saturating_duration_since(self.looked);
        if since < LOOK {
            return;
        }
        let share = taken.saturating_sub(self.taken).as_secs_f64() / since.as_secs_f64();
        (self.looked, self.taken) = (now, taken);
        let goes_first = goes_first(self.goes_first, share);
        if std::mem::replace(&mut self.goes_first, goes_first) == goes_first {
            return;
        }
        if goes_first {
            step_forward(Duty::Track);
        } else {
            tracing::warn!(share, "tracking takes too much of this computer to go before the rest of it");
            be_as_threads_are();
        }
    }
}

const fn goes_first(before: bool, share: f64) -> bool {
    if before { share <= MOST_SHARE } else { share < AGAIN_SHARE }
}

/// The processor's time that the calling thread has taken; none where nobody knows.
fn taken() -> Duration {
    #[cfg(target_os = "linux")]
    {
        let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        // SAFETY: `time` outlives the call, which writes it
        unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &raw mut time) };
        let nanos = u32::try_from(time.tv_nsec).unwrap_or_default();
        Duration::new(u64::try_from(time.tv_sec).unwrap_or_default(), nanos)
    }
    #[cfg(not(target_os = "linux"))]
    Duration::ZERO
}

/// A real-time priority, in turns with others that have the same (`SCHED_RR`). Whether it was given.
fn take_turns_at(priority: i32) -> bool {
    #[cfg(target_os = "linux")]
    return set(libc::SCHED_RR | libc::SCHED_RESET_ON_FORK, priority);
    #[cfg(not(target_os = "linux"))]
    {
        let _ = priority;
        false
    }
}

/// None any more.
fn be_as_threads_are() {
    #[cfg(target_os = "linux")]
    set(libc::SCHED_OTHER | libc::SCHED_RESET_ON_FORK, 0);
}

#[cfg(target_os = "linux")]
fn set(policy: i32, priority: i32) -> bool {
    let param = libc::sched_param { sched_priority: priority };
    // SAFETY: `param` outlives the call, which reads it; 0 is the calling thread alone. Not by the function of the
    // same name, which is for processes: some C libraries have none
    let answer = unsafe { libc::syscall(libc::SYS_sched_setscheduler, 0, policy, &raw const param) };
    answer == 0
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
        let niceness = before[2];
        let in_turns = i64::from(libc::SCHED_RR | libc::SCHED_RESET_ON_FORK);
        for (duty, forward) in [
            (Duty::Track, [in_turns, 1, niceness]),
            (Duty::Join, [in_turns, 2, niceness]),
            (Duty::Drive, [in_turns, 3, niceness]),
        ] {
            let there = spawn(move || {
                step_forward(duty);
                (stands(), spawn(stands).join().unwrap())
            });
            let (stood, its_own) = there.join().unwrap();
            assert!(stood == forward || stood == before, "{duty:?}: {stood:?}");
            assert_eq!(may_step_forward(), stood == forward, "{duty:?}: what is told of it");
            assert_eq!(its_own[1], before[1], "what it starts has no real-time priority");
        }
        assert_eq!(stands(), before);
    }

    #[test]
    fn who_takes_too_much_goes_first_no_longer() {
        let mut first = true;
        let told = [0.2, 0.5, 0.51, 0.4, 0.29, 0.5].map(|share| {
            first = goes_first(first, share);
            first
        });
        assert_eq!(told, [true, true, false, false, true, true]);
        let there = spawn(|| {
            let before = stands();
            let mut tracking = Tracking::begin();
            let began = Instant::now();
            while began.elapsed() < LOOK + Duration::from_millis(100) || tracking.goes_first {
                tracking.look();
                assert!(began.elapsed() < LOOK * 60, "a thread that never sleeps takes too much");
            }
            (before, stands())
        });
        let (before, after) = there.join().unwrap();
        assert_eq!(after[1..], before[1..], "as threads are");
    }
}
