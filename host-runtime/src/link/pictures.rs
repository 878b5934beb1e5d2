//! One connection for pictures: each on a stream of its own, the newest of each camera, at a bounded rate.
//!
//! A picture that has begun is sent to its end, for one that is broken off helps nobody; one that has
//! not begun is overtaken by the next. So a slow network sees fewer pictures and never older ones.

use super::closing::{Closing, in_words};
use super::peer::PeerShared;
use super::picture::{MAX_PICTURE_LEN, Picture};
use super::tls::Lane;
use super::transport::set_for;
use bytes::Bytes;
use quinn::{Connection, ConnectionError};
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;
use tokio::time::{Instant, sleep_until, timeout};

/// Pictures on their way at a time: the next is begun while the last one's arrival is not yet known.
const ON_THEIR_WAY: usize = 2;

/// A picture that takes longer than this, either way, is given up: it is of no use any more.
const TOO_OLD: Duration = Duration::from_secs(3);

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
    peer: &PeerShared,
    mut pace: Pace,
) -> Result<Infallible, ConnectionError> {
    let on_their_way = Arc::new(Semaphore::new(ON_THEIR_WAY));
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
        let connection = connection.clone();
        tokio::spawn(async move {
            // one that does not get through is followed by a newer one
            let _ = timeout(TOO_OLD, send_one(&connection, picture)).await;
            drop(place);
        });
    }
}

async fn send_one(connection: &Connection, picture: Bytes) -> Option<()> {
    let mut stream = connection.open_uni().await.ok()?;
    stream.write_chunk(picture).await.ok()?;
    stream.finish().ok()?;
    stream.stopped().await.ok().map(drop)
}

async fn receive(connection: &Connection, peer: &Arc<PeerShared>) -> Result<Infallible, ConnectionError> {
    loop {
        let mut stream = connection.accept_uni().await?;
        let peer = Arc::clone(peer);
        tokio::spawn(async move {
            let Ok(Ok(bytes)) = timeout(TOO_OLD, stream.read_to_end(MAX_PICTURE_LEN)).await else { return };
            // what is no picture is nobody's loss
            if let Ok(picture) = Picture::decode(&bytes) {
                peer.take_picture(picture);
            }
        });
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
