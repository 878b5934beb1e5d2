//! `[console]`: where the operator's page is served, and to whom.

use crate::settings::file::Problem;
use serde::Deserialize;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};

/// Where the demo's console is, if nobody else is there.
const DEMO_PORT: u16 = 8080;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::settings) struct ConsoleToml {
    listen: String,
    token_file: Option<PathBuf>,
    certificate: Option<PathBuf>,
    key: Option<PathBuf>,
    #[serde(default)]
    names: Vec<String>,
    sessions: Option<PathBuf>,
}

/// The operator's console.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConsoleSettings {
    /// Where it listens.
    pub listen: SocketAddr,
    /// Whether another port will do.
    pub port: ConsolePort,
    /// The file with the token that lets in.
    pub token_file: Option<PathBuf>,
    /// Certificate and key, where it is served over TLS.
    pub tls: Option<ConsoleTls>,
    /// Names that it is known by beside its addresses, lower case.
    pub names: Vec<String>,
    /// The folder with the sessions that it shows; the one where the operator records, where none is given.
    pub sessions: Option<PathBuf>,
}

/// Which port is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConsolePort {
    /// That one.
    Given,
    /// That one, or the next that is free.
    OrNextFree,
}

/// The files of TLS, PEM.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConsoleTls {
    /// The certificate, those that vouch for it behind it.
    pub certificate: PathBuf,
    /// Its private key.
    pub key: PathBuf,
}

impl ConsoleSettings {
    /// The console of a demo: for this computer alone.
    #[must_use]
    pub const fn demo() -> Self {
        Self {
            listen: SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), DEMO_PORT),
            port: ConsolePort::OrNextFree,
            token_file: None,
            tls: None,
            names: Vec::new(),
            sessions: None,
        }
    }
}

impl ConsoleToml {
    pub(super) fn checked(&self, dir: &Path) -> Result<ConsoleSettings, Problem> {
        let wrong = |key: &str, problem: String| (format!("[console] {key}"), problem);
        let listen: SocketAddr = self.listen.parse().map_err(|_| {
            let mend = "is no address to listen on: give IP:PORT, as 127.0.0.1:8080 for this computer alone";
            wrong("listen", format!("'{}' {mend}", self.listen))
        })?;
        let tls = match (&self.certificate, &self.key) {
            (Some(certificate), Some(key)) => {
                Some(ConsoleTls { certificate: dir.join(certificate), key: dir.join(key) })
            }
            (None, None) => None,
            (Some(_), None) => {
                return Err(wrong("key", "the certificate's private key is missing: give both".to_owned()));
            }
            (None, Some(_)) => {
                return Err(wrong("certificate", "the key's certificate is missing: give both".to_owned()));
            }
        };
        if !listen.ip().is_loopback() {
            if self.token_file.is_none() {
                let mend = format!(
                    "{listen} can be reached from other computers, and whoever gets in can move the arm: name a \
                     file with a secret, as `openssl rand -hex 32` makes it, or listen on 127.0.0.1"
                );
                return Err(wrong("token_file", mend));
            }
            if tls.is_none() {
                let mend = format!(
                    "{listen} can be reached from other computers, and the token would cross the network in the \
                     clear: give certificate and key, as `tetrad keys station NAME` makes them"
                );
                return Err(wrong("certificate", mend));
            }
        }
        for name in &self.names {
            let sound = |c: u8| c.is_ascii_alphanumeric() || c == b'-' || c == b'.';
            if name.is_empty() || !name.bytes().all(sound) {
                let mend =
                    format!("'{name}' is no name of a computer: give it without port and path, as arm.local");
                return Err(wrong("names", mend));
            }
        }
        Ok(ConsoleSettings {
            listen,
            port: ConsolePort::Given,
            token_file: self.token_file.as_ref().map(|file| dir.join(file)),
            tls,
            names: self.names.iter().map(|name| name.to_ascii_lowercase()).collect(),
            sessions: self.sessions.as_ref().map(|folder| dir.join(folder)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(text: &str) -> Result<ConsoleSettings, Problem> {
        toml::from_str::<ConsoleToml>(text).expect("TOML").checked(Path::new("/etc/tetrad"))
    }

    #[test]
    fn loopback_needs_nothing_else() {
        let console = checked("listen = \"127.0.0.1:8080\"").unwrap();
        assert_eq!(console, ConsoleSettings { port: ConsolePort::Given, ..ConsoleSettings::demo() });
        assert!(checked("listen = \"[::1]:0\"\ntoken_file = \"token\"").is_ok());
        let console = checked("listen = \"127.0.0.1:8080\"\nsessions = \"kept\"").unwrap();
        assert_eq!(console.sessions, Some("/etc/tetrad/kept".into()));
    }

    #[test]
    fn elsewhere_a_token_and_a_certificate_are_needed() {
        let all = "listen = \"0.0.0.0:8443\"\ntoken_file = \"token\"\ncertificate = \"a.pem\"\nkey = \"a.key\"\n\
                   names = [\"Arm.Local\"]";
        let console = checked(all).unwrap();
        assert_eq!(console.token_file, Some("/etc/tetrad/token".into()));
        assert_eq!(console.tls.unwrap().key, Path::new("/etc/tetrad/a.key"));
        assert_eq!(console.names, ["arm.local"]);
        for (line, key) in [
            ("token_file = \"token\"\n", "[console] token_file"),
            ("certificate = \"a.pem\"\nkey = \"a.key\"\n", "[console] certificate"),
            ("certificate = \"a.pem\"\n", "[console] certificate"),
            ("key = \"a.key\"\n", "[console] key"),
        ] {
            assert_eq!(checked(&all.replace(line, "")).unwrap_err().0, key, "without {line}");
        }
        assert_eq!(checked(&all.replace("Arm.Local", "arm:1")).unwrap_err().0, "[console] names");
        assert_eq!(checked("listen = \"localhost:8080\"").unwrap_err().0, "[console] listen");
    }
}
