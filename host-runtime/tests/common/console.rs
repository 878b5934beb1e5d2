//! `tetrad operator` as a process with its console, asked as a page asks it.
#![allow(dead_code, reason = "every test file uses its own part")]

use super::command;
use serde_json::Value;
use std::fs;
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longer than anything takes.
const LONG: Duration = Duration::from_secs(120);

/// How often something is looked at that is waited for.
const POLL: Duration = Duration::from_millis(50);

/// A program with a console. Dropped, it is killed.
pub(crate) struct Operator {
    process: Child,
    said: PathBuf,
    console: SocketAddr,
}

impl Operator {
    /// Starts it in `dir`, where tetrad.toml is.
    pub(crate) fn start(dir: &Path, arguments: &str) -> Self {
        let said = dir.join("said.txt");
        let log = fs::File::create(&said).expect("a file");
        let process = command(&format!("operator --config tetrad.toml {arguments}"))
            .current_dir(dir)
            .stdin(Stdio::null())
            .stdout(log.try_clone().expect("the same file"))
            .stderr(log)
            .spawn()
            .expect("the program starts");
        let mut operator = Self { process, said, console: SocketAddr::from(([127, 0, 0, 1], 0)) };
        operator.console = operator.until("a console", |operator| console_in(&operator.said()));
        operator
    }

    /// What it has printed.
    pub(crate) fn said(&self) -> String {
        fs::read_to_string(&self.said).unwrap_or_default()
    }

    /// Looks again and again until there is what is waited for.
    #[track_caller]
    pub(crate) fn until<T>(&self, what: &str, look: impl Fn(&Self) -> Option<T>) -> T {
        let began = Instant::now();
        loop {
            if let Some(found) = look(self) {
                return found;
            }
            assert!(began.elapsed() < LONG, "no {what}: {}", self.said());
            std::thread::sleep(POLL);
        }
    }

    /// What a route has to say.
    #[track_caller]
    pub(crate) fn get(&self, path: &str) -> String {
        let (status, answer) = self.ask("GET", path, "");
        assert_eq!(status, 200, "{path}: {answer}");
        answer
    }

    /// The status and the answer to a request.
    pub(crate) fn post(&self, path: &str, body: &Value) -> (u16, Value) {
        let (status, answer) = self.ask("POST", path, &body.to_string());
        (status, serde_json::from_str(&answer).unwrap_or(Value::Null))
    }

    fn ask(&self, method: &str, path: &str, body: &str) -> (u16, String) {
        let (console, length) = (self.console, body.len());
        let mut stream = TcpStream::connect(console).expect("a connection");
        stream.set_read_timeout(Some(LONG)).expect("a time");
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nhost: {console}\r\nconnection: close\r\ncontent-length: {length}\r\n\r\n{body}"
        )
        .expect("a request");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("an answer");
        let (head, body) = answer.split_once("\r\n\r\n").expect("a head");
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok());
        (status.expect("a status"), body.to_owned())
    }

    /// What the loop knows.
    pub(crate) fn snapshot(&self) -> Value {
        serde_json::from_str(&self.get("/api/snapshot")).expect("JSON")
    }

    /// Ends it as Ctrl-C does; all that it has printed.
    pub(crate) fn end(mut self) -> String {
        let told = Command::new("kill").args(["-INT", &self.process.id().to_string()]).status();
        assert!(told.is_ok_and(|status| status.success()), "it runs");
        let began = Instant::now();
        let status = loop {
            if let Some(status) = self.process.try_wait().expect("a child") {
                break status;
            }
            assert!(began.elapsed() < LONG, "it does not end: {}", self.said());
            std::thread::sleep(POLL);
        };
        assert!(status.success(), "{status}: {}", self.said());
        self.said()
    }
}

impl Drop for Operator {
    fn drop(&mut self) {
        // one that ended is no longer there to be killed
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The address in what it printed, once its line is whole.
fn console_in(said: &str) -> Option<SocketAddr> {
    let (_, rest) = said.split_once("console at http://")?;
    rest.split_once(['/', '\n'])?.0.parse().ok()
}
