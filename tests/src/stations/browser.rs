//! A browser that shows one page, and what is asked of the console without one.

use std::io::{self, Read as _, Write as _};
use std::net::TcpStream;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// What is needed for it.
const MISSING: &str = "missing: apt-get install --no-install-recommends chromium";

/// Chromium without a screen, with its profile in a folder of the run, which has less right to the processors than what is measured.
/// Dropped, it is ended.
pub(super) struct Browser(Child);

impl Browser {
    /// Shows a page, in a window of 1280x720.
    ///
    /// # Errors
    /// There is no browser.
    pub(super) fn show(url: &str, profile: &Path) -> Result<Self, String> {
        // what a browser that was killed has left there keeps the next from starting
        match std::fs::remove_dir_all(profile) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(format!("{}: {error}", profile.display()));
            }
            _ => {}
        }
        let known = Command::new("chromium").arg("--version").output();
        if !known.is_ok_and(|told| told.status.success()) {
            return Err(MISSING.to_owned());
        }
        let mut chromium = Command::new("chrt");
        chromium.args([
            "--idle",
            "0",
            "chromium",
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
        ]);
        // without a port for its tools it would load the page, print it and end
        chromium.args(["--remote-debugging-port=0", "--window-size=1280,720"]);
        chromium.arg(format!("--user-data-dir={}", profile.display())).arg(url);
        chromium.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        // its processes are a group, so that all of them end
        chromium
            .process_group(0)
            .spawn()
            .map(Self)
            .map_err(|error| format!("chrt (package util-linux): {error}"))
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let group = format!("-{}", self.0.id());
        // a group that has ended is no longer there to be killed
        let _ = Command::new("kill").args(["-KILL", "--", &group]).stderr(Stdio::null()).status();
        let _ = self.0.wait();
    }
}

/// The body of the answer to `GET path`.
///
/// # Errors
/// Nobody answers.
pub(super) fn get(console: &str, path: &str) -> io::Result<String> {
    let mut stream = TcpStream::connect(console)?;
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {console}\r\nConnection: close\r\n\r\n")?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer)?;
    let body = answer.split_once("\r\n\r\n").map(|(_, body)| body.to_owned());
    body.ok_or_else(|| io::ErrorKind::UnexpectedEof.into())
}
