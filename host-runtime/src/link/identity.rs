//! Who a station is: its name, its certificate and key, and the authority it trusts.

use super::authority::KeyFiles;
use super::name::StationName;
use super::tls;
use rustls::RootCertStore;
use rustls::client::verify_server_name;
use rustls::pki_types::pem::{self, PemObject as _};
use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
use rustls::server::ParsedCertificate;
use std::path::{Path, PathBuf};

/// A station's name, certificate, key, and the authority whose certificates it takes.
#[derive(Debug)]
pub struct Identity {
    pub(super) name: StationName,
    pub(super) certificate: CertificateDer<'static>,
    pub(super) key: PrivateKeyDer<'static>,
    pub(super) authority: RootCertStore,
}

/// Why a station cannot say who it is.
#[derive(Debug, thiserror::Error)]
pub enum IdentityError {
    /// A file is missing or holds something else.
    #[error("cannot take the {what} from {}; `tetrad keys` makes it", path.display())]
    File {
        /// What was wanted.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// Why not.
        #[source]
        cause: pem::Error,
    },
    /// The certificate is another station's.
    #[error("the certificate in {} is not that of `{name}`: give the station the files made by `tetrad keys station {name}`", path.display())]
    AnotherName {
        /// The file.
        path: PathBuf,
        /// The name that was expected.
        name: StationName,
    },
    /// The certificate of the authority cannot be used.
    #[error("{} is no authority's certificate; copy authority.pem from where `tetrad keys` was run", .0.display())]
    BadAuthority(PathBuf, #[source] rustls::Error),
    /// The key is not the certificate's, or the certificate is of another authority.
    #[error(
        "nobody would believe `{name}` with the files in {}: they are not of one make; copy authority.pem, \
         {name}.pem and {name}.key from one `tetrad keys` directory", dir.display()
    )]
    NotBelieved {
        /// The station.
        name: StationName,
        /// Where its files are.
        dir: PathBuf,
        /// What does not fit.
        #[source]
        cause: rustls::Error,
    },
}

impl Identity {
    /// Reads NAME.pem, NAME.key and authority.pem from a directory. authority.key need not, and on a
    /// station should not, be there.
    ///
    /// # Errors
    /// [`IdentityError`]
    pub fn load(dir: &Path, name: &StationName) -> Result<Self, IdentityError> {
        let files = KeyFiles::of_station(dir, name);
        let certificate_of = |path: &Path, what| {
            CertificateDer::from_pem_file(path).map_err(|cause| IdentityError::File {
                what,
                path: path.to_owned(),
                cause,
            })
        };
        let certificate = certificate_of(&files.certificate, "certificate")?;
        let key = PrivateKeyDer::from_pem_file(&files.key).map_err(|cause| IdentityError::File {
            what: "private key",
            path: files.key.clone(),
            cause,
        })?;
        if !is_named(&certificate, name) {
            return Err(IdentityError::AnotherName { path: files.certificate, name: name.clone() });
        }
        let authority_file = KeyFiles::of_authority(dir).certificate;
        let mut authority = RootCertStore::empty();
        authority
            .add(certificate_of(&authority_file, "authority's certificate")?)
            .map_err(|cause| IdentityError::BadAuthority(authority_file, cause))?;
        let identity = Self { name: name.clone(), certificate, key, authority };
        tls::is_believed(&identity).map_err(|cause| IdentityError::NotBelieved {
            name: name.clone(),
            dir: dir.to_owned(),
            cause,
        })?;
        Ok(identity)
    }

    /// The station's name.
    #[must_use]
    pub const fn name(&self) -> &StationName {
        &self.name
    }
}

/// Whether a certificate is made out to this name. Who signed it is another question.
pub(super) fn is_named(certificate: &CertificateDer<'_>, name: &StationName) -> bool {
    let Ok(expected) = ServerName::try_from(name.as_str()) else { return false };
    ParsedCertificate::try_from(certificate)
        .is_ok_and(|parsed| verify_server_name(&parsed, &expected).is_ok())
}

#[cfg(test)]
mod tests {
    use super::super::authority::{make_authority, make_station};
    use super::*;

    fn name(text: &str) -> StationName {
        text.parse().unwrap()
    }

    #[test]
    fn a_station_is_who_its_certificate_says() {
        let dir = tempfile::tempdir().unwrap();
        make_authority(dir.path()).unwrap();
        make_station(dir.path(), &name("slave")).unwrap();
        std::fs::remove_file(dir.path().join("authority.key")).unwrap();
        let slave = Identity::load(dir.path(), &name("slave")).unwrap();
        assert_eq!(slave.name().as_str(), "slave");
        assert!(is_named(&slave.certificate, &name("slave")));
        assert!(!is_named(&slave.certificate, &name("slave-2")));

        for ending in ["pem", "key"] {
            let of = |name: &str| dir.path().join(format!("{name}.{ending}"));
            std::fs::copy(of("slave"), of("operator")).unwrap();
        }
        let other = Identity::load(dir.path(), &name("operator")).unwrap_err().to_string();
        assert!(other.contains("is not that of `operator`"), "{other}");
    }

    #[test]
    fn files_of_two_makes_are_refused() {
        let dirs = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        for dir in &dirs {
            make_authority(dir.path()).unwrap();
            make_station(dir.path(), &name("slave")).unwrap();
        }
        for file in ["authority.pem", "slave.key"] {
            let [mine, other] = [&dirs[0], &dirs[1]].map(|dir| dir.path().join(file));
            let own = std::fs::read(&mine).unwrap();
            std::fs::copy(&other, &mine).unwrap();
            let refused = Identity::load(dirs[0].path(), &name("slave")).unwrap_err().to_string();
            assert!(refused.starts_with("nobody would believe `slave`"), "{file}: {refused}");
            std::fs::write(&mine, own).unwrap();
        }
        assert!(Identity::load(dirs[0].path(), &name("slave")).is_ok());
    }

    #[test]
    fn what_is_missing_is_named() {
        let dir = tempfile::tempdir().unwrap();
        make_authority(dir.path()).unwrap();
        let none = Identity::load(dir.path(), &name("slave")).unwrap_err().to_string();
        assert!(none.contains("certificate") && none.contains("slave.pem"), "{none}");
        make_station(dir.path(), &name("slave")).unwrap();
        std::fs::write(dir.path().join("slave.key"), "").unwrap();
        let none = Identity::load(dir.path(), &name("slave")).unwrap_err().to_string();
        assert!(none.contains("private key") && none.contains("slave.key"), "{none}");
    }
}
