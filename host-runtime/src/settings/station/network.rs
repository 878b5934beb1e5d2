//! `[station]` and `[[peer]]`: who the station is, and whom it talks to.

use crate::exit::{Exit, Failure};
use crate::link::discovery::Scope;
use crate::link::{
    Discovery, DiscoveryError, Identity, IdentityError, Link, LinkConfig, LinkError, MDNS,
    PICTURE_BYTES_PER_S, PeerConfig, StationName,
};
use crate::robot::clock::Clock;
use crate::settings::file::Problem;
use serde::Deserialize;
use std::io;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

/// Rates of pictures that can be given, kB/s: from a slide show to a whole gigabit line.
const PICTURE_KB_PER_S: std::ops::RangeInclusive<f64> = 1.0..=100_000.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::settings) struct StationToml {
    name: String,
    keys: PathBuf,
    listen: Option<String>,
    announce: Option<bool>,
    picture_kb_per_s: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::settings) struct PeerToml {
    name: String,
    address: Option<String>,
}

/// Who the station is and whom it talks to.
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkSettings {
    /// The file that says so, for messages.
    pub file: PathBuf,
    /// Its name, in its certificate too.
    pub name: StationName,
    /// Where its certificate and key are.
    pub keys: PathBuf,
    /// Whether it announces itself on the local network.
    pub announce: bool,
    /// Where it listens, and its peers.
    pub link: LinkConfig,
}

impl NetworkSettings {
    pub(super) fn checked(
        station: Option<&StationToml>,
        peers: &[PeerToml],
        file: &Path,
    ) -> Result<Option<Self>, Problem> {
        let dir = file.parent().unwrap_or(Path::new(""));
        let wrong = |key: &str, problem: String| (key.to_owned(), problem);
        let Some(station) = station else {
            if peers.is_empty() {
                return Ok(None);
            }
            let mend = "peers need a [station] table that says who this is: name and keys";
            return Err(wrong("[[peer]]", mend.to_owned()));
        };
        let name: StationName =
            station.name.parse().map_err(|error| wrong("[station] name", format!("{error}")))?;
        let listen = station.listen.as_deref().map(address).transpose();
        let listen = listen.map_err(|problem| wrong("[station] listen", problem))?;
        let kb =
            super::within("[station] picture_kb_per_s", station.picture_kb_per_s, PICTURE_KB_PER_S, " kB/s")?;
        let announce = station.announce.unwrap_or(false);
        if let Some(problem) = cannot_announce(listen).filter(|_| announce) {
            return Err(wrong("[station] announce", problem));
        }
        let mut all = Vec::new();
        for (index, peer) in peers.iter().enumerate() {
            let key = format!("[[peer]] {}", index + 1);
            let name =
                peer.name.parse().map_err(|error| wrong(&format!("{key} name"), format!("{error}")))?;
            if let Some(address) = &peer.address {
                dialled(address).map_err(|problem| wrong(&format!("{key} address"), problem))?;
            }
            all.push(PeerConfig { name, address: peer.address.clone() });
        }
        if let Some((key, problem)) = same_address(&all, listen) {
            return Err(wrong(&key, problem));
        }
        let link = LinkConfig {
            listen,
            peers: all,
            picture_bytes_per_s: kb.map_or(PICTURE_BYTES_PER_S, |kb| (kb * 1000.0) as u32),
        };
        link.check(&name).map_err(|error| {
            let key = if matches!(error, LinkError::NoWay(_)) { "[[peer]] address" } else { "[[peer]] name" };
            wrong(key, error.to_string())
        })?;
        let (file, keys) = (file.to_owned(), dir.join(&station.keys));
        Ok(Some(Self { file, name, keys, announce, link }))
    }

    /// Whether a peer is called so.
    #[must_use]
    pub fn has_peer(&self, name: &StationName) -> bool {
        self.link.peers.iter().any(|peer| peer.name == *name)
    }

    /// The station's certificate and key, and its authority's certificate.
    ///
    /// # Errors
    /// [`Exit::BadArguments`]: the message names the key, the file and what makes it.
    pub fn identity(&self) -> Result<Identity, Failure> {
        Identity::load(&self.keys, &self.name).map_err(|error| {
            let help = self.mend(&error);
            let said = format!("{}: [station] keys: this station cannot say who it is", self.file.display());
            let cause = anyhow::Error::new(error).context(said);
            Failure { exit: Exit::BadArguments, cause, help: help.map(Into::into) }
        })
    }

    /// What announces this station and looks for peers, where either is wanted.
    fn discovery(&self) -> Result<Option<Discovery>, DiscoveryError> {
        let sought = self.link.sought();
        let wanted = self.announce || !sought.is_empty();
        wanted.then(|| Discovery::start(sought, Scope::Network)).transpose()
    }

    /// What mends it, where the error does not say so itself. Only a file that is not there has to be made.
    fn mend(&self, error: &IdentityError) -> Option<String> {
        let IdentityError::File { path, cause, .. } = error else { return None };
        match cause.kind() {
            io::ErrorKind::NotFound => Some(self.makes_keys()),
            io::ErrorKind::PermissionDenied => Some(lets_read(path)),
            _ => None,
        }
    }

    /// The commands that make what `[station] keys` is to hold.
    fn makes_keys(&self) -> String {
        let (keys, name) = (self.keys.display(), &self.name);
        format!(
            "make them where the authority is kept, with `tetrad keys --out {keys} authority` once and \
             `tetrad keys --out {keys} station {name}`, and copy authority.pem, {name}.pem and {name}.key to {keys}"
        )
    }

    /// Starts the link; `identity` is this station's.
    ///
    /// # Errors
    /// [`Exit::DeviceLost`] where it cannot listen at the moment, as with a camera that is not there:
    /// whatever starts it may try again. [`Exit::BadArguments`] where its certificate cannot be used,
    /// [`Exit::Failed`] where the computer has no thread left.
    pub fn start(&self, identity: &Identity, clock: Clock) -> Result<Link, Failure> {
        let started = self.discovery().map_err(LinkError::from).and_then(|discovery| {
            let link = Link::start_with(&self.link, identity, clock, discovery)?;
            if self.announce {
                link.announce()?;
            }
            Ok(link)
        });
        started.map_err(|error| {
            let (exit, key) = match &error {
                LinkError::Discovery(_) if self.announce => (Exit::DeviceLost, "[station] announce"),
                LinkError::Discovery(_) => (Exit::DeviceLost, "[[peer]] address"),
                LinkError::Listen(..) => (Exit::DeviceLost, "[station] listen"),
                LinkError::Tls(..) => (Exit::BadArguments, "[station] keys"),
                LinkError::SameName(_) => (Exit::BadArguments, "[[peer]] name"),
                LinkError::NoWay(_) => (Exit::BadArguments, "[[peer]] address"),
                LinkError::Thread(_) => (Exit::Failed, "[station]"),
            };
            let said = format!("{}: {key}: there is no link", self.file.display());
            Failure::new(exit, anyhow::Error::new(error).context(said))
        })
    }
}

/// What lets whoever runs this program read a key that is there. Another key would not be better.
fn lets_read(path: &Path) -> String {
    format!(
        "it is there, and this user may not read it: be in the group of the file (where it is set up as in \
         docs/deploy.md: `sudo usermod --append --groups tetrad \"$USER\"`, then log in anew), or be its owner \
         (`ls -l {}`)",
        path.display()
    )
}

/// Where to listen: an address of this computer, not a name, and a port.
fn address(text: &str) -> Result<SocketAddr, String> {
    text.parse().map_err(|_| {
        format!("'{text}' is no address to listen on: give IP:PORT, as 0.0.0.0:7420 or [::]:7420")
    })
}

/// Two stations at one address, or a peer at this station's own: the key, and what is wrong.
fn same_address(peers: &[PeerConfig], listen: Option<SocketAddr>) -> Option<(String, String)> {
    let mut known: Vec<(&str, &str)> = Vec::new();
    for (index, peer) in peers.iter().enumerate() {
        let Some(address) = peer.address.as_deref().filter(|address| *address != MDNS) else { continue };
        let key = format!("[[peer]] {} address", index + 1);
        if listen.is_some_and(|own| address.parse() == Ok(own)) {
            let problem =
                format!("{address} is where this station listens itself: give that of {}", peer.name);
            return Some((key, problem));
        }
        if let Some((other, _)) = known.iter().find(|(_, at)| *at == address) {
            let problem = format!("{other} is at {address} too: each station has an address of its own");
            return Some((key, problem));
        }
        known.push((peer.name.as_str(), address));
    }
    None
}

/// Why a station that listens there is not to be announced.
fn cannot_announce(listen: Option<SocketAddr>) -> Option<String> {
    match listen {
        None => Some("a station that only dials has nothing to announce: give [station] listen".to_owned()),
        Some(address) if address.ip().is_loopback() => {
            Some(format!("{address} is for this computer alone: listen on 0.0.0.0 or [::], or leave it out"))
        }
        Some(_) => None,
    }
}

/// Whether it can be dialled: a name or an address, and a port.
fn dialled(text: &str) -> Result<(), String> {
    if text == MDNS {
        return Ok(());
    }
    if text.parse::<SocketAddr>().is_ok_and(|address| address.ip().is_unspecified()) {
        return Err(format!(
            "'{text}' is an address to listen on: give that of the other station's computer"
        ));
    }
    let port = text.rsplit_once(':').filter(|(host, _)| !host.is_empty());
    match port.and_then(|(_, port)| port.parse::<u16>().ok()) {
        Some(1..) => Ok(()),
        _ => Err(format!(
            "'{text}' cannot be dialled: give HOST:PORT, as arm.local:7420 or 10.0.0.3:7420, or \"{MDNS}\""
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_that_may_not_be_read_is_not_made_anew() {
        let network = NetworkSettings {
            file: "tetrad.toml".into(),
            name: "slave".parse().unwrap(),
            keys: "keys".into(),
            announce: false,
            link: LinkConfig { listen: None, peers: Vec::new(), picture_bytes_per_s: 1 },
        };
        let mend = |kind: io::ErrorKind| {
            let path = PathBuf::from("keys/slave.key");
            network.mend(&IdentityError::File { what: "private key", path, cause: kind.into() })
        };
        let forbidden = mend(io::ErrorKind::PermissionDenied).unwrap();
        assert!(forbidden.contains("usermod") && forbidden.contains("ls -l keys/slave.key"), "{forbidden}");
        assert!(!forbidden.contains("tetrad keys"), "{forbidden}");
        assert!(mend(io::ErrorKind::NotFound).unwrap().contains("`tetrad keys --out keys station slave`"));
        assert_eq!(mend(io::ErrorKind::InvalidData), None);
    }
}
