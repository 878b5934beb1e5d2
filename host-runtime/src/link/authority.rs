//! The small private authority: it makes one certificate and one key a station.
//!
//! The keys are ECDSA P-256, the certificates X.509 version 3. A station's certificate carries its name
//! as its only subject alternative name, and is good for both ends of a connection. There is no date on
//! which it ends: a station on a closed network may not know the date, and an arm shall not stop because
//! a day has come. A key that got lost is answered by a new authority.

use super::name::{AUTHORITY, StationName};
use crate::text_file;
use rcgen::{
    BasicConstraints, CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer,
    KeyPair, KeyUsagePurpose, date_time_ymd,
};
use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// What an authority is called in its certificate; its key's identifier follows.
const COMMON_NAME: &str = "Tetrad authority";

/// Why keys were not made.
#[derive(Debug, thiserror::Error)]
pub enum KeysError {
    /// A file is there already.
    #[error("{} is there already and is not overwritten: move it away, or choose another --out", .0.display())]
    Exists(PathBuf),
    /// The authority has not been made.
    #[error("{} is not there: make the authority first, with `tetrad keys --out {} authority`", .0.display(), .0.parent().unwrap_or(Path::new(".")).display())]
    NoAuthority(PathBuf),
    /// The authority's key cannot be used.
    #[error("{} is no authority's key: restore it from a copy, or make a new authority elsewhere and new keys for all stations", .0.display())]
    BadAuthority(PathBuf, #[source] rcgen::Error),
    /// A file cannot be read or written.
    #[error("cannot {verb} {}", path.display())]
    File {
        /// What was tried.
        verb: &'static str,
        /// With which file.
        path: PathBuf,
        /// Why not.
        #[source]
        cause: io::Error,
    },
    /// A key or a certificate could not be made.
    #[error("no certificate could be made")]
    Certificate(#[from] rcgen::Error),
}

/// The two files of the authority or a station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyFiles {
    /// NAME.pem: the certificate. It may be seen by everybody.
    pub certificate: PathBuf,
    /// NAME.key: the private key. It is seen by nobody but its owner.
    pub key: PathBuf,
}

impl KeyFiles {
    /// Where the authority's are.
    #[must_use]
    pub fn of_authority(dir: &Path) -> Self {
        Self::named(dir, AUTHORITY)
    }

    /// Where a station's are.
    #[must_use]
    pub fn of_station(dir: &Path, name: &StationName) -> Self {
        Self::named(dir, name.as_str())
    }

    fn named(dir: &Path, name: &str) -> Self {
        Self { certificate: dir.join(format!("{name}.pem")), key: dir.join(format!("{name}.key")) }
    }

    /// Writes both, or neither; nothing is overwritten.
    fn write(self, certificate: &str, key: &str) -> Result<Self, KeysError> {
        write_new(&self.key, key, 0o600)?;
        if let Err(refused) = write_new(&self.certificate, certificate, 0o644) {
            // this key was made a moment ago, nobody has it
            let _ = std::fs::remove_file(&self.key);
            return Err(refused);
        }
        Ok(self)
    }
}

/// Makes an authority in a directory that is there.
///
/// # Errors
/// [`KeysError`]; nothing is overwritten.
pub fn make_authority(dir: &Path) -> Result<KeyFiles, KeysError> {
    let key = KeyPair::generate()?;
    let certificate = authority_params(&key).self_signed(&key)?;
    KeyFiles::of_authority(dir).write(&certificate.pem(), &key.serialize_pem())
}

/// Makes a station's key and certificate with the authority of the same directory.
///
/// # Errors
/// [`KeysError`]; nothing is overwritten.
pub fn make_station(dir: &Path, name: &StationName) -> Result<KeyFiles, KeysError> {
    make_station_with(dir, name, |_| {})
}

/// The same with something about the certificate changed, as another maker's might be.
pub(super) fn make_station_with(
    dir: &Path,
    name: &StationName,
    change: impl FnOnce(&mut CertificateParams),
) -> Result<KeyFiles, KeysError> {
    let authority = KeyFiles::of_authority(dir).key;
    let pem = text_file::read(&authority).map_err(|cause| match cause.kind() {
        io::ErrorKind::NotFound => KeysError::NoAuthority(authority.clone()),
        _ => KeysError::File { verb: "read", path: authority.clone(), cause },
    })?;
    let signing = KeyPair::from_pem(&pem).map_err(|cause| KeysError::BadAuthority(authority, cause))?;
    let issuer = Issuer::new(authority_params(&signing), signing);
    let key = KeyPair::generate()?;
    let mut params = station_params(name)?;
    change(&mut params);
    let certificate = params.signed_by(&key, &issuer)?;
    KeyFiles::of_station(dir, name).write(&certificate.pem(), &key.serialize_pem())
}

/// The same each time, so that the key alone is enough to sign with. Named after the key, so that two
/// authorities are not taken for one another.
fn authority_params(key: &KeyPair) -> CertificateParams {
    let mut params = CertificateParams::default();
    let id: String = params.key_identifier(key).iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign];
    params.distinguished_name = common_name(&format!("{COMMON_NAME} {id}"));
    without_end(&mut params);
    params
}

fn station_params(name: &StationName) -> Result<CertificateParams, rcgen::Error> {
    let mut params = CertificateParams::new([name.as_str().to_owned()])?;
    params.is_ca = IsCa::ExplicitNoCa;
    params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
    params.extended_key_usages =
        vec![ExtendedKeyUsagePurpose::ServerAuth, ExtendedKeyUsagePurpose::ClientAuth];
    params.distinguished_name = common_name(name.as_str());
    params.use_authority_key_identifier_extension = true;
    without_end(&mut params);
    Ok(params)
}

fn common_name(name: &str) -> DistinguishedName {
    let mut distinguished = DistinguishedName::new();
    distinguished.push(DnType::CommonName, name);
    distinguished
}

/// From the first day a clock that was never set shows to the last that can be written, which
/// RFC 5280 section 4.1.2.5 gives to certificates with no well-defined end.
fn without_end(params: &mut CertificateParams) {
    params.not_before = date_time_ymd(1970, 1, 1);
    params.not_after = date_time_ymd(9999, 12, 31);
}

fn write_new(path: &Path, text: &str, mode: u32) -> Result<(), KeysError> {
    let failed = |cause: io::Error| match cause.kind() {
        io::ErrorKind::AlreadyExists => KeysError::Exists(path.to_owned()),
        _ => KeysError::File { verb: "write", path: path.to_owned(), cause },
    };
    let mut file = create_new(path, mode).map_err(failed)?;
    file.write_all(text.as_bytes()).and_then(|()| file.sync_all()).map_err(|cause| {
        let _ = std::fs::remove_file(path);
        failed(cause)
    })
}

/// The file has its mode from its first moment on.
#[cfg(unix)]
fn create_new(path: &Path, mode: u32) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt as _;
    OpenOptions::new().write(true).create_new(true).mode(mode).open(path)
}

#[cfg(not(unix))]
fn create_new(path: &Path, _mode: u32) -> io::Result<File> {
    OpenOptions::new().write(true).create_new(true).open(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::error::Error as _;

    fn name(text: &str) -> StationName {
        text.parse().unwrap()
    }

    #[test]
    fn nothing_is_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        let authority = make_authority(dir.path()).unwrap();
        let station = make_station(dir.path(), &name("slave")).unwrap();
        let files = [&authority.certificate, &authority.key, &station.certificate, &station.key];
        let before = files.map(|file| std::fs::read(file).unwrap());
        assert!(matches!(make_authority(dir.path()), Err(KeysError::Exists(path)) if path == authority.key));
        let again = make_station(dir.path(), &name("slave")).unwrap_err();
        assert!(matches!(&again, KeysError::Exists(path) if *path == station.key), "{again}");
        assert_eq!(files.map(|file| std::fs::read(file).unwrap()), before);

        std::fs::write(dir.path().join("operator.pem"), "mine").unwrap();
        let half = make_station(dir.path(), &name("operator")).unwrap_err();
        assert!(half.to_string().contains("operator.pem is there already"), "{half}");
        assert!(!dir.path().join("operator.key").exists(), "no key without its certificate");
        assert_eq!(std::fs::read(dir.path().join("operator.pem")).unwrap(), b"mine");
    }

    #[cfg(unix)]
    #[test]
    fn private_keys_are_the_owners_alone() {
        use std::os::unix::fs::PermissionsExt as _;
        let dir = tempfile::tempdir().unwrap();
        let authority = make_authority(dir.path()).unwrap();
        let station = make_station(dir.path(), &name("slave")).unwrap();
        for key in [authority.key, station.key] {
            assert_eq!(std::fs::metadata(&key).unwrap().permissions().mode() & 0o777, 0o600);
        }
    }

    #[test]
    fn without_a_sound_authority_there_is_no_station() {
        let dir = tempfile::tempdir().unwrap();
        let missing = make_station(dir.path(), &name("slave")).unwrap_err().to_string();
        assert!(missing.contains("authority.key is not there: make the authority first"), "{missing}");
        std::fs::write(dir.path().join("authority.key"), "nonsense").unwrap();
        let bad = make_station(dir.path(), &name("slave")).unwrap_err();
        assert!(bad.to_string().contains("is no authority's key"), "{bad}");
        assert!(bad.source().is_some());
        assert!(!dir.path().join("slave.key").exists());
    }
}
