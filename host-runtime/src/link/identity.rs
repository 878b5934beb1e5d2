//! Who a station is: its name, its certificate and key, and the authority it trusts.

use super::authority::KeyFiles;
use super::name::{AUTHORITY, StationName};
use super::tls;
use crate::text_file;
use rustls::client::verify_server_name;
use rustls::pki_types::pem::{self, PemObject};
use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
use rustls::server::ParsedCertificate;
use rustls::{CertificateError, RootCertStore};
use std::io;
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
    /// A file is missing, or may not be read.
    #[error("cannot read the {what} in {}", path.display())]
    File {
        /// What was wanted.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// Why not.
        #[source]
        cause: io::Error,
    },
    /// A file holds something else.
    #[error("there is no whole {what} in {}: {problem}; copy it again from where `tetrad keys` made it", path.display())]
    Damaged {
        /// What was wanted.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// The certificate is another station's.
    #[error("the certificate in {} is not that of `{name}`: give the station the files made by `tetrad keys station {name}`", path.display())]
    AnotherName {
        /// The file.
        path: PathBuf,
        /// The name that was expected.
        name: StationName,
    },
    /// The certificate has more names than one: other stations could not tell whose it is.
    #[error(
        "the certificate in {} is made out to several names, {names}, and a station has one; `tetrad keys \
         station {name}` makes one", path.display()
    )]
    Names {
        /// The file.
        path: PathBuf,
        /// The names, with commas.
        names: String,
        /// The station's own.
        name: StationName,
    },
    /// The certificate's time is over, or has not come.
    #[error(
        "the certificate in {} is not valid on the day that this computer's clock shows: set the clock, or make \
         another with `tetrad keys station {name}`, which has no last day", path.display()
    )]
    NotToday {
        /// The file.
        path: PathBuf,
        /// The station's name.
        name: StationName,
        /// Since when, or until when.
        #[source]
        cause: rustls::Error,
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
        let certificate: CertificateDer<'_> = read(&files.certificate, "certificate")?;
        let key: PrivateKeyDer<'_> = read(&files.key, "private key")?;
        if !is_named(&certificate, name) {
            return Err(IdentityError::AnotherName { path: files.certificate, name: name.clone() });
        }
        let names = names(&certificate);
        if names.len() > 1 {
            let (path, names) = (files.certificate, names.join(", "));
            return Err(IdentityError::Names { path, names, name: name.clone() });
        }
        let authority_file = KeyFiles::of_authority(dir).certificate;
        let mut authority = RootCertStore::empty();
        authority
            .add(read(&authority_file, "authority's certificate")?)
            .map_err(|cause| IdentityError::BadAuthority(authority_file, cause))?;
        let identity = Self { name: name.clone(), certificate, key, authority };
        tls::is_believed(&identity).map_err(|cause| {
            let name = name.clone();
            if is_of_time(&cause) {
                IdentityError::NotToday { path: files.certificate, name, cause }
            } else {
                IdentityError::NotBelieved { name, dir: dir.to_owned(), cause }
            }
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

/// The names that a certificate is made out to, as rustls tells them where none of them is the one that was
/// asked for: no station is called like the authority.
fn names(certificate: &CertificateDer<'_>) -> Vec<String> {
    let Ok(nobody) = ServerName::try_from(AUTHORITY) else { return Vec::new() };
    let Ok(parsed) = ParsedCertificate::try_from(certificate) else { return Vec::new() };
    match verify_server_name(&parsed, &nobody) {
        Err(rustls::Error::InvalidCertificate(CertificateError::NotValidForNameContext {
            presented,
            ..
        })) => presented,
        // it is the authority's too
        Ok(()) => vec![AUTHORITY.to_owned(), "another".to_owned()],
        Err(_) => Vec::new(),
    }
}

/// Whether a certificate is refused for the day alone.
const fn is_of_time(error: &rustls::Error) -> bool {
    use CertificateError::{Expired, ExpiredContext, NotValidYet, NotValidYetContext};
    matches!(
        error,
        rustls::Error::InvalidCertificate(
            Expired | ExpiredContext { .. } | NotValidYet | NotValidYetContext { .. }
        )
    )
}

/// What a file in PEM holds.
fn read<T: PemObject>(path: &Path, what: &'static str) -> Result<T, IdentityError> {
    let path_buf = || path.to_owned();
    let text =
        text_file::read(path).map_err(|cause| IdentityError::File { what, path: path_buf(), cause })?;
    T::from_pem_slice(text.as_bytes()).map_err(|error| {
        let problem = match error {
            pem::Error::NoItemsFound => "it holds something else",
            pem::Error::MissingSectionEnd { .. } => {
                "it is cut short, for its last line (-----END ...) is missing"
            }
            _ => "it is damaged",
        };
        IdentityError::Damaged { what, path: path_buf(), problem }
    })
}

#[cfg(test)]
mod tests {
    use super::super::authority::{make_authority, make_station, make_station_with};
    use super::*;
    use rcgen::CertificateParams;

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
        assert!(none.contains("it holds something else"), "{none}");
    }

    #[test]
    fn a_file_that_is_cut_short_is_told_in_words() {
        let dir = tempfile::tempdir().unwrap();
        make_authority(dir.path()).unwrap();
        let files = make_station(dir.path(), &name("slave")).unwrap();
        for file in [files.certificate, files.key] {
            let whole = std::fs::read_to_string(&file).unwrap();
            for (half, words) in
                [(&whole[..whole.len() / 2], "cut short"), (&whole.replace("MI", "!!"), "damaged")]
            {
                std::fs::write(&file, half).unwrap();
                let told = Identity::load(dir.path(), &name("slave")).unwrap_err();
                let words_of = format!("{:#}", anyhow::Error::new(told));
                assert!(words_of.contains(words) && !words_of.contains('['), "{words_of}");
            }
            std::fs::write(&file, whole).unwrap();
        }
    }

    #[test]
    fn a_certificate_of_two_names_or_another_year_is_told_as_that() {
        let dir = tempfile::tempdir().unwrap();
        make_authority(dir.path()).unwrap();
        let told = |change: fn(&mut CertificateParams)| {
            let files = make_station_with(dir.path(), &name("slave"), change).unwrap();
            let told = Identity::load(dir.path(), &name("slave")).unwrap_err().to_string();
            for file in [files.certificate, files.key] {
                std::fs::remove_file(file).unwrap();
            }
            told
        };
        let two = told(|params| {
            let other = "operator".to_owned().try_into().unwrap();
            params.subject_alt_names.push(rcgen::SanType::DnsName(other));
        });
        assert!(two.contains("several names") && two.contains("operator"), "{two}");
        let old = told(|params| params.not_after = rcgen::date_time_ymd(2001, 1, 1));
        let early = told(|params| params.not_before = rcgen::date_time_ymd(4001, 1, 1));
        for told in [old, early] {
            assert!(told.contains("not valid on the day") && told.contains("slave.pem"), "{told}");
        }
    }
}
