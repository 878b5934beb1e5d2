//! One connection for packets, from the greeting to its end.
//!
//! ```text
//!   outbox -> send      datagrams     receive -> inbox
//!             write  <- the stream ->  read
//!      hello, asks and answers, configuration
//! ```

use super::clock::Exchange;
use super::closing::{Closing, in_words};
use super::message::{Message, Reader};
use super::peer::PeerShared;
use super::shared::LinkShared;
use super::tls::Lane;
use super::transport::set_for;
use quinn::{Connection, ConnectionError, RecvStream, SendStream, Side};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

/// The greeting is to be over within this.
const GREETING: Duration = Duration::from_secs(5);

/// Questions for the time at the beginning, and between them...
const FIRST_ASKS: u32 = 8;
const FIRST_ASKS_EVERY: Duration = Duration::from_millis(50);

/// ...and how long between them from then on.
const ASK_EVERY: Duration = Duration::from_millis(500);

/// Questions whose answers are waited for.
const ASKED: usize = 16;

/// Another process of the same name and key that is not heard for so long is taken for dead: longer than
/// [`ASK_EVERY`], after which whoever is alive has acknowledged something.
const DEAD: Duration = Duration::from_millis(600);
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Bytes read from the stream at a time.
const PIECE: usize = 4096;

/// Why a session ended.
#[derive(Debug)]
pub(super) enum Ended {
    /// The connection did.
    Connection(ConnectionError),
    /// This station ended it.
    Here(Closing),
    /// The greeting took too long.
    NoGreeting,
}

impl Ended {
    pub(super) fn in_words(&self) -> String {
        match self {
            Self::Connection(error) => in_words(error),
            Self::Here(closing) => closing.text().to_owned(),
            Self::NoGreeting => "it does not say who it is".to_owned(),
        }
    }
}

/// What the parts of a session share.
struct Session<'a> {
    connection: &'a Connection,
    link: &'a LinkShared,
    peer: &'a PeerShared,
    /// Questions that were asked: number and time.
    asked: Mutex<VecDeque<(u32, u64)>>,
}

/// Carries packets until the connection ends. `greeted` is called once the peer is known to be there.
pub(super) async fn run(
    connection: &Connection,
    link: &LinkShared,
    peer: &PeerShared,
    greeted: impl FnOnce(),
) -> Ended {
    set_for(Lane::Motion, connection);
    let session = Session { connection, link, peer, asked: Mutex::default() };
    let greeting = timeout(GREETING, session.greet()).await;
    let (stream_out, stream_in, reader) = match greeting {
        Ok(Ok(streams)) => streams,
        Ok(Err(ended)) => return session.end(ended),
        Err(_) => return session.end(Ended::NoGreeting),
    };
    // nobody was there to take it, and it is old now
    peer.outbox.clear();
    peer.connect(Lane::Motion, connection);
    greeted();
    let (heard, to_answer) = mpsc::channel(ASKED);
    let ended = tokio::select! {
        Err(ended) = session.send() => ended,
        Err(ended) = session.receive() => ended,
        Err(ended) = session.read(stream_in, reader, heard) => ended,
        Err(ended) = session.write(stream_out, to_answer) => ended,
    };
    peer.disconnect(Lane::Motion, connection);
    session.end(ended)
}

impl Session<'_> {
    /// Each end says which session its packets are of. The one that is dialled says it last, so that who
    /// is turned away was never there.
    async fn greet(&self) -> Result<(SendStream, RecvStream, Reader), Ended> {
        let (mut stream_out, mut stream_in) = match self.connection.side() {
            Side::Client => self.connection.open_bi().await,
            Side::Server => self.connection.accept_bi().await,
        }
        .map_err(Ended::Connection)?;
        let hello = Message::Hello { session: self.link.session }.encode();
        let dials = self.connection.side() == Side::Client;
        if dials {
            stream_out.write_all(&hello).await.map_err(|_| self.broken())?;
        }
        let mut reader = Reader::default();
        let Message::Hello { session } = self.next(&mut stream_in, &mut reader).await? else {
            return Err(Ended::Here(Closing::Nonsense));
        };
        if self.is_taken(session).await {
            return Err(Ended::Here(Closing::Taken));
        }
        if !self.link.claim(session, &self.peer.name) || self.peer.lock().inbox.begin(session).is_err() {
            return Err(Ended::Here(Closing::Session));
        }
        if !dials {
            stream_out.write_all(&hello).await.map_err(|_| self.broken())?;
        }
        Ok((stream_out, stream_in, reader))
    }

    /// Whether another process of this peer's name is there and alive. Whoever has the arm keeps it; one
    /// that was killed and started again finds nobody.
    async fn is_taken(&self, session: u32) -> bool {
        while let Some(other) = self.peer.connected_as_another(session) {
            let heard = || other.stats().udp_rx.datagrams;
            let before = heard();
            let alive = timeout(DEAD, async {
                while heard() == before && other.close_reason().is_none() {
                    sleep(LOOK_EVERY).await;
                }
                other.close_reason().is_none()
            });
            match alive.await {
                Ok(true) => return true,
                // it has just ended: who is there now?
                Ok(false) => sleep(LOOK_EVERY).await,
                Err(_) => {
                    // unless somebody else has taken its place meanwhile
                    let now = self.peer.connected_as_another(session);
                    if now.is_none_or(|now| now.stable_id() == other.stable_id()) {
                        return false;
                    }
                }
            }
        }
        false
    }

    async fn send(&self) -> Result<Infallible, Ended> {
        loop {
            self.peer.outbox.ready().await;
            let Some(body) = self.peer.outbox.take() else { continue };
            // waits while the one before has not gone; what comes meanwhile waits in the outbox
            match self.connection.send_datagram_wait(body).await {
                Ok(()) => self.peer.outbox.count_sent(),
                Err(quinn::SendDatagramError::ConnectionLost(error)) => return Err(Ended::Connection(error)),
                // a peer that takes no datagrams, or none as long as a packet, is none of ours
                Err(_) => return Err(Ended::Here(Closing::Nonsense)),
            }
        }
    }

    async fn receive(&self) -> Result<Infallible, Ended> {
        loop {
            let body = self.connection.read_datagram().await.map_err(Ended::Connection)?;
            self.peer.take_datagram(&body);
        }
    }

    async fn read(
        &self,
        mut stream: RecvStream,
        mut reader: Reader,
        heard: mpsc::Sender<(u32, u64)>,
    ) -> Result<Infallible, Ended> {
        loop {
            match self.next(&mut stream, &mut reader).await? {
                Message::Hello { .. } => return Err(Ended::Here(Closing::Nonsense)),
                // whoever asks faster than can be answered gets no answer
                Message::Ask { id, .. } => drop(heard.try_send((id, self.link.clock.now_us()))),
                Message::Answer { id, heard_us, answered_us } => {
                    let back_us = self.link.clock.now_us();
                    if let Some(asked_us) = self.asked_at(id) {
                        let exchange = Exchange { asked_us, heard_us, answered_us, back_us };
                        self.peer.lock().inbox.clock.take(&exchange);
                    }
                }
                Message::Configuration(configuration) => self.peer.take_configuration(configuration),
            }
        }
    }

    async fn write(
        &self,
        mut stream: SendStream,
        mut to_answer: mpsc::Receiver<(u32, u64)>,
    ) -> Result<Infallible, Ended> {
        let mut configuration = self.peer.configuration.subscribe();
        configuration.mark_changed();
        let (mut soon, mut later) = (interval(FIRST_ASKS_EVERY), interval(ASK_EVERY));
        // a stall is no reason to ask twice at once
        later.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut id = 0_u32;
        loop {
            let message = tokio::select! {
                Some((id, heard_us)) = to_answer.recv() => {
                    Message::Answer { id, heard_us, answered_us: self.link.clock.now_us() }
                }
                Ok(()) = configuration.changed() => {
                    let Some(changed) = configuration.borrow_and_update().clone() else { continue };
                    Message::Configuration(changed.to_vec())
                }
                _ = soon.tick(), if id < FIRST_ASKS => self.ask(&mut id),
                _ = later.tick(), if id >= FIRST_ASKS => self.ask(&mut id),
            };
            stream.write_all(&message.encode()).await.map_err(|_| self.broken())?;
        }
    }

    fn ask(&self, id: &mut u32) -> Message {
        // never back to the first ones
        *id = id.checked_add(1).unwrap_or(FIRST_ASKS);
        let asked_us = self.link.clock.now_us();
        let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
        asked.push_back((*id, asked_us));
        if asked.len() > ASKED {
            asked.pop_front();
        }
        Message::Ask { id: *id, asked_us }
    }

    /// When a question was asked; each is answered once.
    fn asked_at(&self, id: u32) -> Option<u64> {
        let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
        let at = asked.iter().position(|(asked, _)| *asked == id)?;
        asked.remove(at).map(|(_, asked_us)| asked_us)
    }

    async fn next(&self, stream: &mut RecvStream, reader: &mut Reader) -> Result<Message, Ended> {
        let mut piece = [0; PIECE];
        loop {
            match reader.message() {
                Ok(Some(message)) => return Ok(message),
                Ok(None) => {}
                Err(_) => return Err(Ended::Here(Closing::Nonsense)),
            }
            match stream.read(&mut piece).await {
                Ok(Some(length)) => reader.feed(piece.get(..length).unwrap_or_default()),
                Ok(None) | Err(_) => return Err(self.broken()),
            }
        }
    }

    /// The stream has ended, which only the end of the connection may do to it.
    fn broken(&self) -> Ended {
        self.connection.close_reason().map_or(Ended::Here(Closing::Nonsense), Ended::Connection)
    }

    fn end(&self, ended: Ended) -> Ended {
        match &ended {
            Ended::Here(closing) => closing.close(self.connection),
            Ended::NoGreeting => Closing::Nonsense.close(self.connection),
            Ended::Connection(_) => {}
        }
        ended
    }
}
