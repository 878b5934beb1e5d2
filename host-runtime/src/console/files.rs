//! The files that `[console]` names, read and checked: for the console itself, and for `tetrad check`.

use super::access::{BadToken, Token};
use crate::settings::station::{ConsoleSettings, ConsoleTls};
use crate::text_file;
use rustls::ServerConfig;
use rustls::crypto::ring;
use rustls::pki_types::pem::{self, PemObject as _};
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Why one of them cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FilesError {
    /// The token's file cannot be read.
    #[error("[console] token_file: cannot read {}; `openssl rand -hex 32` makes a token", .0.display())]
    TokenFile(PathBuf, #[source] io::Error),
    /// It holds no token.
    #[error("[console] token_file: {}", .0.display())]
    Token(PathBuf, #[source] BadToken),
    /// A file of TLS cannot be read.
    #[error("[console] {key}: cannot read {}; `tetrad keys station NAME` makes one", path.display())]
    Unreadable {
        /// The key of the settings.
        key: &'static str,
        /// The file.
        path: PathBuf,
        /// Why not.
        #[source]
        cause: io::Error,
    },
    /// It holds something else.
    #[error("[console] {key}: cannot take it from {}; `tetrad keys station NAME` makes one", path.display())]
    Pem {
        /// The key of the settings.
        key: &'static str,
        /// The file.
        path: PathBuf,
        /// Why not.
        #[source]
        cause: pem::Error,
    },
    /// They do not belong together.
    #[error("[console] certificate, key: {} and {} are not of one make", certificate.display(), key.display())]
    NotAPair {
        /// The certificate.
        certificate: PathBuf,
        /// The key.
        key: PathBuf,
        /// What does not fit.
        #[source]
        cause: rustls::Error,
    },
    /// Sessions are not in a file.
    #[error("[console] sessions: {} is no folder: name the one that the recorded sessions are in", .0.display())]
    Sessions(PathBuf),
}

/// What was in them.
#[derive(Debug)]
pub(crate) struct Files {
    /// The secret that lets in.
    pub(super) token: Option<Token>,
    /// What a TLS server needs.
    pub(super) tls: Option<Arc<ServerConfig>>,
    /// The certificate that it shows.
    pub(super) certificate: Option<CertificateDer<'static>>,
}

impl Files {
    /// Reads all that the settings name.
    ///
    /// # Errors
    /// [`FilesError`], with the key and the file.
    pub(crate) fn read(settings: &ConsoleSettings) -> Result<Self, FilesError> {
        let sessions = settings.sessions.as_deref();
        // one that is not there yet is made when something is recorded
        if let Some(file) = sessions.filter(|sessions| sessions.exists() && !sessions.is_dir()) {
            return Err(FilesError::Sessions(file.to_owned()));
        }
        let token = settings.token_file.as_deref().map(token).transpose()?;
        let (tls, certificate) = settings.tls.as_ref().map(server).transpose()?.unzip();
        Ok(Self { token, tls, certificate })
    }
}

fn token(file: &Path) -> Result<Token, FilesError> {
    let text = text_file::read(file).map_err(|cause| FilesError::TokenFile(file.to_owned(), cause))?;
    Token::parse(&text).map_err(|bad| FilesError::Token(file.to_owned(), bad))
}

/// Of PEM files: what serves, and the certificate that it shows, which stands first in its file.
fn server(files: &ConsoleTls) -> Result<(Arc<ServerConfig>, CertificateDer<'static>), FilesError> {
    let ConsoleTls { certificate, key } = files;
    let read = |key, path: &Path| {
        text_file::read(path).map_err(|cause| FilesError::Unreadable { key, path: path.to_owned(), cause })
    };
    let wrong = |key, path: &Path, cause| FilesError::Pem { key, path: path.to_owned(), cause };
    let text = read("certificate", certificate)?;
    let chain = CertificateDer::pem_slice_iter(text.as_bytes()).collect::<Result<Vec<_>, _>>();
    let chain = chain.and_then(|chain| Ok((chain.first().cloned().ok_or(pem::Error::NoItemsFound)?, chain)));
    let (own, chain) = chain.map_err(|cause| wrong("certificate", certificate, cause))?;
    let text = read("key", key)?;
    let secret = PrivateKeyDer::from_pem_slice(text.as_bytes()).map_err(|cause| wrong("key", key, cause))?;
    let config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .and_then(|config| config.with_no_client_auth().with_single_cert(chain, secret));
    let mut config = config.map_err(|cause| FilesError::NotAPair {
        certificate: certificate.clone(),
        key: key.clone(),
        cause,
    })?;
    config.alpn_protocols = vec![b"http/1.1".to_vec()];
    Ok((Arc::new(config), own))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::error::Error as _;

    fn refused(settings: &ConsoleSettings) -> (String, String) {
        let error = Files::read(settings).unwrap_err();
        (error.to_string(), error.source().map(ToString::to_string).unwrap_or_default())
    }

    /// Each file of the settings in turn is something that is no file, and nothing is waited for.
    #[cfg(target_os = "linux")]
    #[test]
    fn what_is_no_file_is_refused_by_its_key() {
        let dir = tempfile::tempdir().unwrap();
        let pipe = dir.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        let large = dir.path().join("large");
        std::fs::write(&large, vec![b'x'; 2 << 20]).unwrap();
        let certificate = dir.path().join("arm.pem");
        crate::link::authority::make_authority(dir.path()).unwrap();
        crate::link::authority::make_station(dir.path(), &"arm".parse().unwrap()).unwrap();
        let zero = PathBuf::from("/dev/zero");
        let folder = dir.path().to_owned();
        for (file, why) in
            [(&zero, "a device"), (&pipe, "a pipe"), (&folder, "it is a folder"), (&large, "larger than")]
        {
            let tls = |certificate: &Path, key: &Path| ConsoleSettings {
                tls: Some(ConsoleTls { certificate: certificate.to_owned(), key: key.to_owned() }),
                ..ConsoleSettings::demo()
            };
            let token = ConsoleSettings { token_file: Some(file.clone()), ..ConsoleSettings::demo() };
            let cases =
                [("token_file", token), ("certificate", tls(file, file)), ("key", tls(&certificate, file))];
            for (key, settings) in cases {
                let (said, cause) = refused(&settings);
                assert!(said.starts_with(&format!("[console] {key}: cannot read ")), "{said}");
                assert!(said.contains(&file.display().to_string()) && cause.contains(why), "{said}: {cause}");
            }
        }
    }

    #[test]
    fn sessions_are_in_a_folder() {
        let dir = tempfile::tempdir().unwrap();
        let of = |sessions: PathBuf| ConsoleSettings { sessions: Some(sessions), ..ConsoleSettings::demo() };
        Files::read(&of(dir.path().to_owned())).unwrap();
        Files::read(&of(dir.path().join("not-there-yet"))).unwrap();
        let file = dir.path().join("session.mcap");
        std::fs::write(&file, "").unwrap();
        let (said, _) = refused(&of(file.clone()));
        assert!(said.starts_with("[console] sessions: ") && said.contains("no folder"), "{said}");
        assert!(said.contains(&file.display().to_string()), "{said}");
    }

    #[test]
    fn a_certificate_is_looked_for_in_its_file() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("arm.pem");
        std::fs::write(&file, "nothing of the kind").unwrap();
        let tls = Some(ConsoleTls { certificate: file.clone(), key: file });
        let (said, _) = refused(&ConsoleSettings { tls, ..ConsoleSettings::demo() });
        assert!(said.starts_with("[console] certificate: cannot take it from "), "{said}");
    }
}
