//! One connection for pictures: each on a stream of its own, the newest of each camera, at a bounded rate.
//!
//! One that has not begun is overtaken by the next. One that has begun and is not there after a second is
//! given up, and so is what QUIC would still send of it, for that goes before all that is newer. The next one
//! then has longer, so that a line which takes more than a second for a picture shows some all the same. So
//! a slow network sees fewer pictures, and none that is older than [`PATIENCE`]'s second by more than its way.

use super::closing::{Closing, in_words};
use super::peer::PeerShared;
use super::picture::{MAX_PICTURE_LEN, Picture};
use super::tls::Lane;
use super::transport::set_for;
use bytes::Bytes;
use quinn::{Connection, ConnectionError, VarInt};
use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;
use tokio::sync::Semaphore;
use tokio::time::{Instant, sleep_until, timeout, timeout_at};

/// Pictures on their way at a time: the next is begun while the last one's arrival is not yet known.
const ON_THEIR_WAY: usize = 2;

/// How long a picture may take: doubled from the first to the second for each that is given up, and back at
/// the first with one that arrives.
const PATIENCE: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(4));

/// What a stream is reset with whose picture is given up.
const GIVEN_UP: VarInt = VarInt::from_u32(1);

/// Carries pictures until the connection ends, and says why it did.
pub(super) async fn run(connection: &Connection, peer: &Arc<PeerShared>, bytes_per_s: u32) -> String {
    set_for(Lane::Pictures, connection);
    if peer.is_beside_another(connection) {
        Closing::Taken.close(connection);
        return Closing::Taken.text().to_owned();
    }
    // nobody was there to see it
    peer.pictures.clear();
    peer.connect(Lane::Pictures, connection);
    let ended = tokio::select! {
        Err(ended) = send(connection, peer, Pace::new(bytes_per_s)) => ended,
        Err(ended) = receive(connection, peer) => ended,
    };
    peer.disconnect(Lane::Pictures, connection);
    in_words(&ended)
}

async fn send(
    connection: &Connection,
    peer: &Arc<PeerShared>,
    mut pace: Pace,
) -> Result<Infallible, ConnectionError> {
    let on_their_way = Arc::new(Semaphore::new(ON_THEIR_WAY));
    let patience = Arc::new(Patience::default());
    loop {
        peer.pictures.ready().await;
        sleep_until(pace.free_at).await;
        let place = Arc::clone(&on_their_way).acquire_owned().await;
        let Some(picture) = peer.pictures.take() else { continue };
        if let Some(error) = connection.close_reason() {
            return Err(error);
        }
        pace.spend(picture.len());
        peer.pictures.count_sent();
        let (connection, peer, patience) = (connection.clone(), Arc::clone(peer), Arc::clone(&patience));
        tokio::spawn(async move {
            // one that does not get through is followed by a newer one
            if send_one(&connection, picture, patience.now()).await {
                patience.arrived();
            } else {
                patience.given_up();
                peer.pictures.count_given_up();
            }
            drop(place);
        });
    }
}

/// Whether it arrived within so long.
async fn send_one(connection: &Connection, picture: Bytes, patience: Duration) -> bool {
    let until = Instant::now() + patience;
    let Ok(Ok(mut stream)) = timeout_at(until, connection.open_uni()).await else { return false };
    let sent = timeout_at(until, async {
        stream.write_chunk(picture).await.ok()?;
        stream.finish().ok()?;
        stream.stopped().await.ok()
    });
    let arrived = matches!(sent.await, Ok(Some(None)));
    if !arrived {
        // a stream that is merely let go of is sent to its end
        let _ = stream.reset(GIVEN_UP);
    }
    arrived
}

async fn receive(connection: &Connection, peer: &Arc<PeerShared>) -> Result<Infallible, ConnectionError> {
    loop {
        let mut stream = connection.accept_uni().await?;
        let peer = Arc::clone(peer);
        tokio::spawn(async move {
            let Ok(Ok(bytes)) = timeout(PATIENCE.1, stream.read_to_end(MAX_PICTURE_LEN)).await else {
                return;
            };
            // what is no picture is nobody's loss
            if let Ok(picture) = Picture::decode(&bytes) {
                peer.take_picture(picture);
            }
        });
    }
}

/// How long the next picture may take: how often in a row one was given up.
#[derive(Default)]
struct Patience(AtomicU32);

impl Patience {
    fn now(&self) -> Duration {
        let (first, most) = PATIENCE;
        let times = 1_u32.checked_shl(self.0.load(Ordering::Relaxed)).unwrap_or(u32::MAX);
        first.saturating_mul(times).min(most)
    }

    fn arrived(&self) {
        self.0.store(0, Ordering::Relaxed);
    }

    fn given_up(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

/// Bytes a second, on average over a picture.
struct Pace {
    bytes_per_s: u32,
    free_at: Instant,
}

impl Pace {
    fn new(bytes_per_s: u32) -> Self {
        Self { bytes_per_s: bytes_per_s.max(1), free_at: Instant::now() }
    }

    fn spend(&mut self, bytes: usize) {
        let takes = Duration::from_secs_f64(bytes as f64 / f64::from(self.bytes_per_s));
        self.free_at = self.free_at.max(Instant::now()) + takes;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_gave_up_waits_longer_until_one_arrives() {
        let patience = Patience::default();
        let mut waits = Vec::new();
        for _ in 0..40 {
            waits.push(patience.now().as_secs());
            patience.given_up();
        }
        assert_eq!(waits[..4], [1, 2, 4, 4]);
        assert_eq!(waits.last(), Some(&4));
        patience.arrived();
        assert_eq!(patience.now().as_secs(), 1);
    }
}
