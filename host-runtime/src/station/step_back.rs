//! What is only looked at gives way to what moves the arm.

/// Makes the calling thread one niceness lower than it was. Where the system does not know of it, or does
/// not allow it, the thread stays as it is: it is slower to nobody's harm.
pub fn step_back() {
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

    fn niceness() -> i32 {
        // SAFETY: plain numbers in and out
        unsafe { libc::getpriority(libc::PRIO_PROCESS, 0) }
    }

    #[test]
    fn it_is_the_calling_thread_alone() {
        let before = niceness();
        let there = std::thread::spawn(|| {
            step_back();
            niceness()
        });
        assert_eq!(there.join().unwrap(), (before + 1).min(19));
        assert_eq!(niceness(), before);
    }
}
