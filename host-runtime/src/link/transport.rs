//! How QUIC is set: nothing queues, nothing waits for pictures.

use super::tls::Lane;
use quinn::congestion::{Controller, ControllerFactory, ControllerMetrics, CubicConfig};
use quinn::{Connection, IdleTimeout, TransportConfig, VarInt};
use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tetrad_core::wire::MAX_BODY_LEN;

/// Without a packet for so long a connection is given up and made anew. Longer than the cut of two
/// seconds that a connection shall live through; no rule of safety waits for it.
const IDLE: Duration = Duration::from_secs(3);

/// A packet at least this often, also where no station has anything to say.
const KEEP_ALIVE: Duration = Duration::from_millis(500);

/// What is assumed of the way there and back before it is measured: a local network's, not the
/// internet's, so that a first packet that gets lost is sent again after 0.3 s instead of 1 s.
const INITIAL_RTT: Duration = Duration::from_millis(100);

/// Room for the one datagram that is being sent; the next waits in the outbox, where a newer one takes
/// its place. quinn counts 32 bytes for itself with each.
const DATAGRAM_ROOM: usize = MAX_BODY_LEN + 64;

/// Datagrams that have come and were not read yet. They are read at once: this is for a burst.
const RECEIVE_ROOM: usize = 64 * 1024;

/// What motion may always have in flight, bytes. Its rate is bounded by what it is (at most some 50 kB/s
/// with arm states at 100 Hz): neither losses nor a way of seconds may thin it out, and it must go on
/// being sent through a cut, so that the first packet after it comes through.
const MOTION_WINDOW: u64 = 256 * 1024;

/// What pictures may have in flight, bytes: what is handed to QUIC can be neither overtaken nor taken
/// back.
const PICTURE_WINDOW: u64 = 256 * 1024;

/// Pictures that may come at a time.
const PICTURES_AT_ONCE: u32 = 4;

/// How connections are set before it is known what they are for.
pub(super) fn config() -> TransportConfig {
    let mut config = TransportConfig::default();
    config
        .max_idle_timeout(IdleTimeout::try_from(IDLE).ok())
        .keep_alive_interval(Some(KEEP_ALIVE))
        .initial_rtt(INITIAL_RTT)
        .max_concurrent_bidi_streams(VarInt::from_u32(1))
        .max_concurrent_uni_streams(VarInt::from_u32(0))
        .datagram_send_buffer_size(DATAGRAM_ROOM)
        .datagram_receive_buffer_size(Some(RECEIVE_ROOM))
        .congestion_controller_factory(Arc::new(FlooredConfig));
    config
}

/// How they are set from then on.
pub(super) fn set_for(lane: Lane, connection: &Connection) {
    match lane {
        Lane::Motion => {
            if let Ok(floored) = connection.congestion_state().into_any().downcast::<Floored>() {
                floored.floor.store(MOTION_WINDOW, Ordering::Relaxed);
            }
        }
        Lane::Pictures => {
            connection.set_max_concurrent_bi_streams(VarInt::from_u32(0));
            connection.set_max_concurrent_uni_streams(VarInt::from_u32(PICTURES_AT_ONCE));
            connection.set_send_window(PICTURE_WINDOW);
        }
    }
}

struct FlooredConfig;

impl ControllerFactory for FlooredConfig {
    fn build(self: Arc<Self>, now: Instant, mtu: u16) -> Box<dyn Controller> {
        let inner = Arc::new(CubicConfig::default()).build(now, mtu);
        Box::new(Floored { inner, floor: Arc::new(AtomicU64::new(0)) })
    }
}

/// Cubic with a window that never falls below a floor. Clones share the floor, which is how it is
/// set on a connection that is there already.
struct Floored {
    inner: Box<dyn Controller>,
    floor: Arc<AtomicU64>,
}

impl Controller for Floored {
    fn on_sent(&mut self, now: Instant, bytes: u64, last_packet_number: u64) {
        self.inner.on_sent(now, bytes, last_packet_number);
    }

    fn on_ack(
        &mut self,
        now: Instant,
        sent: Instant,
        bytes: u64,
        app_limited: bool,
        rtt: &quinn_proto::RttEstimator,
    ) {
        self.inner.on_ack(now, sent, bytes, app_limited, rtt);
    }

    fn on_end_acks(&mut self, now: Instant, in_flight: u64, app_limited: bool, largest: Option<u64>) {
        self.inner.on_end_acks(now, in_flight, app_limited, largest);
    }

    fn on_congestion_event(&mut self, now: Instant, sent: Instant, persistent: bool, lost_bytes: u64) {
        self.inner.on_congestion_event(now, sent, persistent, lost_bytes);
    }

    fn on_mtu_update(&mut self, new_mtu: u16) {
        self.inner.on_mtu_update(new_mtu);
    }

    fn window(&self) -> u64 {
        self.inner.window().max(self.floor.load(Ordering::Relaxed))
    }

    fn metrics(&self) -> ControllerMetrics {
        let mut metrics = self.inner.metrics();
        metrics.congestion_window = self.window();
        metrics
    }

    fn clone_box(&self) -> Box<dyn Controller> {
        Box::new(Self { inner: self.inner.clone_box(), floor: Arc::clone(&self.floor) })
    }

    fn initial_window(&self) -> u64 {
        self.inner.initial_window()
    }

    fn into_any(self: Box<Self>) -> Box<dyn Any> {
        self
    }
}
