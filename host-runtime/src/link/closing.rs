//! Why a station ends a connection, as the other end is told: a number and a text.

use quinn::{Connection, ConnectionError, Endpoint, VarInt};

/// Why a connection is ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Closing {
    /// The station ends.
    Ends,
    /// There is a newer connection.
    Replaced,
    /// Two dial each other: the one with the lesser name does.
    Dialled,
    /// The session has ended, or is another station's.
    Session,
    /// What came over the stream is no message.
    Nonsense,
    /// The certificate is not that of one peer.
    Stranger,
    /// Another process of that name and key is there and alive.
    Taken,
}

impl Closing {
    const ALL: [Self; 7] = [
        Self::Ends,
        Self::Replaced,
        Self::Dialled,
        Self::Session,
        Self::Nonsense,
        Self::Stranger,
        Self::Taken,
    ];

    const fn code(self) -> u32 {
        self as u32
    }

    pub(super) const fn text(self) -> &'static str {
        match self {
            Self::Ends => "the station ended",
            Self::Replaced => "a newer connection took its place",
            Self::Dialled => "both ends dial each other, and the other end's connection is kept",
            Self::Session => {
                "its session has ended or is another station's: two stations run with the same name and key"
            }
            Self::Nonsense => "what came over the stream makes no sense",
            Self::Taken => {
                "a station of that name and key is connected already and alive: end one of the two"
            }
            Self::Stranger => "its certificate is not that of one of the peers",
        }
    }

    pub(super) fn close_all(self, endpoint: &Endpoint) {
        endpoint.close(VarInt::from_u32(self.code()), self.text().as_bytes());
    }

    pub(super) fn close(self, connection: &Connection) {
        connection.close(VarInt::from_u32(self.code()), self.text().as_bytes());
    }
}

/// Why a connection ended, in words. What the peer wrote is not repeated: it may be anything.
pub(super) fn in_words(error: &ConnectionError) -> String {
    match error {
        ConnectionError::ApplicationClosed(close) => {
            let known =
                Closing::ALL.into_iter().find(|closing| VarInt::from_u32(closing.code()) == close.error_code);
            format!("the peer says: {}", known.map_or("something that is not known here", Closing::text))
        }
        ConnectionError::TimedOut => "no answer".to_owned(),
        // at the end of the link itself nobody is there to be told
        ConnectionError::LocallyClosed => Closing::Replaced.text().to_owned(),
        ConnectionError::ConnectionClosed(close) => format!("the peer refuses: {}", alert(close.error_code)),
        ConnectionError::TransportError(error) => format!("{} ({error})", alert(error.code)),
        other => other.to_string(),
    }
}

/// What TLS's alerts mean here: QUIC's error 0x100 + the number of the alert (RFC 9001, section 4.8).
fn alert(code: quinn::TransportErrorCode) -> String {
    match u64::from(code).checked_sub(0x100) {
        Some(116) => "no certificate was shown".to_owned(),
        Some(45) => {
            "the certificate is not valid on the day that one of the two clocks shows: set the clocks, or \
                     make another with `tetrad keys`, which has no last day"
                .to_owned()
        }
        Some(42..=44 | 46) => "the certificate is not that of a configured peer".to_owned(),
        Some(48) => "the certificate is of another authority".to_owned(),
        Some(51) => "the certificate's signature is wrong".to_owned(),
        Some(120) => "the two speak different versions: update the older one".to_owned(),
        _ => format!("error {code:?}"),
    }
}
