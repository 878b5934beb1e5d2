//! Mutual TLS 1.3: who may be at the other end. There is no plain mode.
//!
//! Both ends show a certificate. The one who dials checks the other's chain and name by rustls's own
//! verifier; the one who is dialled checks the chain by rustls's own verifier for clients, and the name
//! by [`NamedClients`] around it, within the handshake: a stranger never has a connection. Sessions are
//! never resumed, for what is resumed is not verified again, and no data is sent before the handshake is
//! done, for such data can be replayed.

use super::identity::{Identity, is_named};
use super::name::StationName;
use quinn::crypto::rustls::{QuicClientConfig, QuicServerConfig};
use rustls::client::Resumption;
use rustls::crypto::{CryptoProvider, ring};
use rustls::pki_types::{CertificateDer, UnixTime};
use rustls::server::danger::{ClientCertVerified, ClientCertVerifier};
use rustls::server::{NoServerSessionStorage, WebPkiClientVerifier};
use rustls::{
    ClientConfig, DigitallySignedStruct, DistinguishedName, ServerConfig, SignatureScheme, version::TLS13,
};
use std::sync::Arc;
use tetrad_core::wire::VERSION;

/// The layout of what goes over streams. Raised like the wire format's version: docs/wire.md.
const LINK_VERSION: u8 = 1;

/// What a connection is for, agreed within the handshake (ALPN) together with the versions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lane {
    /// Packets, and the clock exchange.
    Motion,
    /// Pictures, on a connection of their own: its losses and its congestion are none of motion's.
    Pictures,
}

impl Lane {
    pub(super) const ALL: [Self; 2] = [Self::Motion, Self::Pictures];

    /// The protocol's name on the wire.
    pub(super) fn alpn(self) -> Vec<u8> {
        match self {
            Self::Motion => format!("tetrad-motion/{LINK_VERSION}.{VERSION}").into_bytes(),
            Self::Pictures => format!("tetrad-pictures/{LINK_VERSION}").into_bytes(),
        }
    }

    pub(super) fn of(connection: &quinn::Connection) -> Option<Self> {
        let data = connection.handshake_data()?.downcast::<quinn::crypto::rustls::HandshakeData>().ok()?;
        let protocol = data.protocol?;
        Self::ALL.into_iter().find(|lane| lane.alpn() == protocol)
    }
}

/// Whose certificate the other end has shown, among those who are known here.
pub(super) fn peer_name<'a>(
    connection: &quinn::Connection,
    known: impl Iterator<Item = &'a StationName>,
) -> Option<&'a StationName> {
    let chain = connection.peer_identity()?.downcast::<Vec<CertificateDer<'static>>>().ok()?;
    only_name(chain.first()?, known)
}

/// The one name a certificate is made out to. One that is made out to several of those who are known
/// could be used as either, so it is nobody's.
fn only_name<'a>(
    certificate: &CertificateDer<'_>,
    known: impl Iterator<Item = &'a StationName>,
) -> Option<&'a StationName> {
    let mut named = known.filter(|name| is_named(certificate, name));
    named.next().filter(|_| named.next().is_none())
}

/// The side that is dialled.
pub(super) fn server(
    identity: &Identity,
    peers: Vec<StationName>,
) -> Result<QuicServerConfig, rustls::Error> {
    let provider = provider();
    let chain = WebPkiClientVerifier::builder_with_provider(
        Arc::new(identity.authority.clone()),
        Arc::clone(&provider),
    )
    .build()
    .map_err(|error| rustls::Error::General(error.to_string()))?;
    let mut config = ServerConfig::builder_with_provider(provider)
        .with_protocol_versions(&[&TLS13])?
        .with_client_cert_verifier(Arc::new(NamedClients { chain, peers }))
        .with_single_cert(vec![identity.certificate.clone()], identity.key.clone_key())?;
    config.alpn_protocols = Lane::ALL.map(Lane::alpn).to_vec();
    config.session_storage = Arc::new(NoServerSessionStorage {});
    config.send_tls13_tickets = 0;
    config.max_early_data_size = 0;
    QuicServerConfig::try_from(config).map_err(|error| rustls::Error::General(error.to_string()))
}

/// Whether others will take this station for who it says it is: its key is the certificate's, and the
/// authority is the one who signed.
pub(super) fn is_believed(identity: &Identity) -> Result<(), rustls::Error> {
    let server = server(identity, Vec::new())?;
    // built to see that the key fits; a link builds its own
    drop(server);
    let roots = Arc::new(identity.authority.clone());
    let chain = WebPkiClientVerifier::builder_with_provider(roots, provider())
        .build()
        .map_err(|error| rustls::Error::General(error.to_string()))?;
    chain.verify_client_cert(&identity.certificate, &[], UnixTime::now()).map(drop)
}

/// The side that dials.
pub(super) fn client(identity: &Identity, lane: Lane) -> Result<QuicClientConfig, rustls::Error> {
    let mut config = ClientConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&TLS13])?
        .with_root_certificates(identity.authority.clone())
        .with_client_auth_cert(vec![identity.certificate.clone()], identity.key.clone_key())?;
    config.alpn_protocols = vec![lane.alpn()];
    config.resumption = Resumption::disabled();
    QuicClientConfig::try_from(config).map_err(|error| rustls::Error::General(error.to_string()))
}

fn provider() -> Arc<CryptoProvider> {
    Arc::new(ring::default_provider())
}

/// Numbers nobody can foresee.
pub(super) fn random_u32() -> Result<u32, rustls::Error> {
    let mut bytes = [0; 4];
    let random = ring::default_provider().secure_random;
    random.fill(&mut bytes).map_err(|_| rustls::Error::FailedToGetRandomBytes)?;
    Ok(u32::from_le_bytes(bytes))
}

/// rustls's verifier for clients, and on top of it: the certificate is that of a named peer. rustls
/// leaves names of clients to the application.
#[derive(Debug)]
struct NamedClients {
    chain: Arc<dyn ClientCertVerifier>,
    peers: Vec<StationName>,
}

impl ClientCertVerifier for NamedClients {
    fn root_hint_subjects(&self) -> &[DistinguishedName] {
        self.chain.root_hint_subjects()
    }

    fn verify_client_cert(
        &self,
        end_entity: &CertificateDer<'_>,
        intermediates: &[CertificateDer<'_>],
        now: UnixTime,
    ) -> Result<ClientCertVerified, rustls::Error> {
        let verified = self.chain.verify_client_cert(end_entity, intermediates, now)?;
        match only_name(end_entity, self.peers.iter()) {
            Some(_) => Ok(verified),
            None => Err(rustls::CertificateError::NotValidForName.into()),
        }
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<rustls::client::danger::HandshakeSignatureValid, rustls::Error> {
        self.chain.verify_tls12_signature(message, certificate, signed)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<rustls::client::danger::HandshakeSignatureValid, rustls::Error> {
        self.chain.verify_tls13_signature(message, certificate, signed)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.chain.supported_verify_schemes()
    }
}
