//! WebDriver, as much of it as is needed: JSON over HTTP/1.1 to a driver on loopback, a connection a request.
//!
//! <https://www.w3.org/TR/webdriver2/> has the commands. The crates for it bring dozens of others, for cookies, time
//! zones and Unicode in names of hosts.

use super::browser::LONG;
use serde_json::{Value, json};
use std::io::{self, BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Ipv4Addr, TcpStream};

/// What elements are known by in answers (section 12.2).
const ELEMENT: &str = "element-6066-11e4-a52e-4f735466cecf";

/// A browser's session.
pub(crate) struct Session {
    port: u16,
    path: String,
}

impl Session {
    /// A new one with these capabilities.
    ///
    /// # Errors
    /// What the driver says instead.
    pub(crate) fn new(port: u16, capabilities: Value) -> Result<Self, String> {
        let wanted = json!({"capabilities": {"alwaysMatch": capabilities}});
        let told = ask(port, "POST", "/session", Some(&wanted))?;
        let id = told["sessionId"].as_str().ok_or("a session without a name")?;
        Ok(Self { port, path: format!("/session/{id}") })
    }

    /// Has the driver do something.
    #[track_caller]
    pub(crate) fn post(&self, command: &str, parameters: Value) -> Value {
        self.try_post(command, parameters).unwrap_or_else(|problem| panic!("{command}: {problem}"))
    }

    /// The same, where it may fail.
    ///
    /// # Errors
    /// What the driver says.
    pub(crate) fn try_post(&self, command: &str, parameters: Value) -> Result<Value, String> {
        ask(self.port, "POST", &format!("{}{command}", self.path), Some(&parameters))
    }

    /// Asks the driver for something.
    #[track_caller]
    pub(crate) fn get(&self, command: &str) -> Value {
        let told = ask(self.port, "GET", &format!("{}{command}", self.path), None);
        told.unwrap_or_else(|problem| panic!("{command}: {problem}"))
    }

    /// Ends something; without a command, the session and its browser.
    ///
    /// # Errors
    /// What the driver says.
    pub(crate) fn delete(&self, command: &str) -> Result<Value, String> {
        ask(self.port, "DELETE", &format!("{}{command}", self.path), None)
    }

    /// The element that a selector finds first, as commands and scripts take it.
    #[track_caller]
    pub(crate) fn element(&self, css: &str) -> Value {
        self.post("/element", json!({"using": "css selector", "value": css}))
    }

    /// Has the driver do something with an element.
    #[track_caller]
    pub(crate) fn post_to(&self, css: &str, command: &str, parameters: Value) -> Value {
        let element = self.element(css);
        let id = element[ELEMENT].as_str().unwrap_or_default();
        self.post(&format!("/element/{id}{command}"), parameters)
    }
}

/// The value that a driver answers with.
fn ask(port: u16, method: &str, path: &str, body: Option<&Value>) -> Result<Value, String> {
    let body = body.map(Value::to_string).unwrap_or_default();
    let (status, answer) = exchange(port, method, path, &body).map_err(|error| error.to_string())?;
    let mut answer: Value = serde_json::from_slice(&answer).map_err(|error| error.to_string())?;
    let value = answer["value"].take();
    if status == 200 {
        return Ok(value);
    }
    Err(format!("{}: {}", value["error"], value["message"]))
}

/// The status and the body of the answer.
fn exchange(port: u16, method: &str, path: &str, body: &str) -> io::Result<(u16, Vec<u8>)> {
    let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port))?;
    stream.set_read_timeout(Some(LONG))?;
    write!(
        stream,
        "{method} {path} HTTP/1.1\r\nHost: localhost:{port}\r\nContent-Type: application/json; charset=utf-8\r\n\
         Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
        body.len()
    )?;
    let mut stream = BufReader::new(stream);
    let mut line = String::new();
    stream.read_line(&mut line)?;
    let unreadable = || io::Error::new(io::ErrorKind::InvalidData, "no answer of HTTP/1.1 with a length");
    let status = line.split(' ').nth(1).and_then(|status| status.parse().ok()).ok_or_else(unreadable)?;
    let mut length = None;
    loop {
        line.clear();
        stream.read_line(&mut line)?;
        let Some((name, value)) = line.split_once(':') else { break };
        if name.eq_ignore_ascii_case("content-length") {
            length = value.trim().parse().ok();
        }
    }
    let mut body = vec![0; length.ok_or_else(unreadable)?];
    stream.read_exact(&mut body)?;
    Ok((status, body))
}
