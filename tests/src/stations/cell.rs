//! What four stations need before they can be started: keys, a file each, ports that are free.

use super::station::Station;
use std::fs;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The scene both cameras see: a hand going round a circle, sixty pictures a second.
const SCENE: &str = "circular-0.25-60fps";

/// The stations that are dialled.
const LISTENERS: [&str; 3] = ["left", "right", "slave"];

/// Four stations, ready to be started.
#[derive(Debug)]
pub struct Cell {
    program: PathBuf,
    dir: PathBuf,
    addresses: [SocketAddr; 3],
}

impl Cell {
    /// Makes keys and files for the four in `dir`, which is emptied first.
    ///
    /// # Errors
    /// What could not be made, in a sentence.
    pub fn make(program: &Path, dir: &Path) -> Result<Self, String> {
        let at = |error: io::Error| format!("{}: {error}", dir.display());
        match fs::remove_dir_all(dir) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(at(error)),
            _ => fs::create_dir_all(dir).map_err(at)?,
        }
        let cell = Self {
            program: program.to_owned(),
            dir: dir.to_owned(),
            addresses: free_addresses().map_err(at)?,
        };
        cell.make_keys("keys", &["left", "right", "operator", "slave", "stranger"])?;
        // the same names, of an authority that nobody here knows
        cell.make_keys("other-keys", &["operator"])?;
        for (name, text) in cell.files() {
            fs::write(cell.file(name), text).map_err(at)?;
        }
        Ok(cell)
    }

    /// Writes the file of another station.
    pub(super) fn write(&self, name: &str, text: &str) -> Result<(), String> {
        let file = self.file(name);
        fs::write(&file, text).map_err(|error| format!("{}: {error}", file.display()))
    }

    /// Where results of that name go.
    #[must_use]
    pub fn out(&self, name: &str) -> PathBuf {
        self.dir.join(format!("{name}-out"))
    }

    /// Where the slave is dialled.
    #[must_use]
    pub const fn slave_address(&self) -> SocketAddr {
        self.addresses[2]
    }

    /// Starts the station whose file is `name.toml`: `tetrad ROLE --config name.toml EXTRA...`. What it
    /// prints goes to `name.log`; started again, it goes on there.
    ///
    /// # Errors
    /// Why it could not be started.
    pub fn start(&self, role: &str, name: &str, extra: &[&str]) -> Result<Station, String> {
        let mut command = Command::new(&self.program);
        command.arg(role).arg("--config").arg(self.file(name)).args(extra);
        Station::start(name, command, self.dir.join(format!("{name}.log")))
    }

    fn file(&self, name: &str) -> PathBuf {
        self.dir.join(format!("{name}.toml"))
    }

    fn make_keys(&self, folder: &str, stations: &[&str]) -> Result<(), String> {
        let keys = self.dir.join(folder);
        let make = |arguments: &[&str]| {
            let made =
                Command::new(&self.program).arg("keys").arg("--out").arg(&keys).args(arguments).output();
            let made = made.map_err(|error| format!("{}: {error}", self.program.display()))?;
            if made.status.success() {
                return Ok(());
            }
            Err(format!("tetrad keys: {}", String::from_utf8_lossy(&made.stderr)))
        };
        make(&["authority"])?;
        stations.iter().try_for_each(|name| make(&["station", name]))
    }

    fn files(&self) -> Vec<(&'static str, String)> {
        let [left, right, slave] = self.addresses;
        let camera = |name: &str, address: SocketAddr| {
            format!(
                "[station]\nname = \"{name}\"\nkeys = \"keys\"\nlisten = \"{address}\"\n\
                 [[peer]]\nname = \"operator\"\n\
                 [camera]\nsource = \"sim:{SCENE}\"\nview = \"{name}\"\n"
            )
        };
        let operator = |name: &str, keys: &str| {
            let peers = LISTENERS.iter().zip(self.addresses).fold(String::new(), |all, (name, address)| {
                format!("{all}[[peer]]\nname = \"{name}\"\naddress = \"{address}\"\n")
            });
            format!(
                "[station]\nname = \"{name}\"\nkeys = \"{keys}\"\n{peers}\
                 [operator]\narm_mm = 80\nslave = \"slave\"\n\
                 [[operator.camera]]\nsource = \"node:left\"\n[[operator.camera]]\nsource = \"node:right\"\n"
            )
        };
        // a watchdog of the simulated controller that a busy computer does not set off: what a slave does
        // that gets no processor for a tenth of a second is not what is looked at here
        let slave = format!(
            "[station]\nname = \"slave\"\nkeys = \"keys\"\nlisten = \"{slave}\"\n\
             [[peer]]\nname = \"operator\"\n\
             [slave]\nport = \"sim:?cycle_ms=1&watchdog_ms=2000\"\noperator = \"operator\"\n\
             [[slave.camera]]\nsource = \"sim:arm\"\n[[slave.camera]]\nsource = \"sim:arm\"\n\
             [governor]\ncycle_ms = 1\n"
        );
        vec![
            ("left", camera("left", left)),
            ("right", camera("right", right)),
            ("operator", operator("operator", "keys")),
            ("slave", slave),
            // of the same authority, but nobody's peer
            ("stranger", operator("stranger", "keys")),
            // the operator's name, of another authority
            ("impostor", operator("operator", "other-keys")),
        ]
    }
}

/// Ports nobody has at the moment.
fn free_addresses() -> io::Result<[SocketAddr; 3]> {
    let sockets = [(); 3].map(|()| UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)));
    let mut addresses = [SocketAddr::from((Ipv4Addr::LOCALHOST, 0)); 3];
    for (address, socket) in addresses.iter_mut().zip(sockets) {
        *address = socket?.local_addr()?;
    }
    Ok(addresses)
}
