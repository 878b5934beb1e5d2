//! The console's thread: sockets in a bounded number, none of which may keep others waiting.

use super::access::Access;
use super::app::app;
use super::desk::Desk;
use super::files::{Files, FilesError};
use super::replay::Sessions;
use super::room::{Place, Room, Ticket};
use crate::precedence::step_back;
use crate::settings::station::{ConsolePort, ConsoleSettings};
use axum::Router;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::io;
use std::net::{SocketAddr, TcpListener as StdListener};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Notify;
use tokio::time::{sleep, timeout};
use tokio_rustls::TlsAcceptor;

/// Connections at once. Where one more comes, one gives way (`room`).
const SOCKETS: usize = 64;

/// So many ports are tried after the one that is taken.
const PORTS: u16 = 100;

/// A request's head has to be there within this time; so long an idle connection is kept too.
const HEAD_WITHIN: Duration = Duration::from_secs(10);

/// What TLS may take before the first request.
const HANDSHAKE_WITHIN: Duration = Duration::from_secs(5);

/// Bytes of a request's head.
const HEAD_BYTES: usize = 16 * 1024;

/// After a connection could not be taken (no file descriptors left).
const AFTER_AN_ERROR: Duration = Duration::from_millis(100);

/// Why there is no console.
#[derive(Debug, thiserror::Error)]
pub enum ConsoleError {
    /// It cannot listen.
    #[error("[console] listen: cannot listen on {0}: is another program there?")]
    Listen(SocketAddr, #[source] io::Error),
    /// What its settings name cannot be used.
    #[error(transparent)]
    Files(#[from] FilesError),
    /// The computer has no thread left.
    #[error("the console's thread cannot be started")]
    Thread(#[source] io::Error),
}

/// A console that is served. Where it is dropped, every socket is closed.
#[derive(Debug)]
pub struct Console {
    address: SocketAddr,
    tls: bool,
    end: Arc<Notify>,
    thread: Option<JoinHandle<()>>,
}

impl Console {
    /// Binds it and starts its thread.
    ///
    /// # Errors
    /// [`ConsoleError`]
    pub fn start(settings: &ConsoleSettings, desk: Desk) -> Result<Self, ConsoleError> {
        let Files { token, tls, certificate } = Files::read(settings)?;
        let access = Access {
            loopback: settings.listen.ip().is_loopback(),
            tls: tls.is_some(),
            names: settings.names.clone(),
            certificate,
            token,
        };
        let listener = bind(settings)?;
        let failed = |cause| ConsoleError::Listen(settings.listen, cause);
        let address = listener.local_addr().map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(ConsoleError::Thread)?;
        let end = Arc::new(Notify::new());
        let (ended, secure) = (Arc::clone(&end), tls.is_some());
        let sessions = settings.sessions.clone().map(|dir| Arc::new(Sessions::new(dir)));
        let thread = std::thread::Builder::new()
            .name("console".to_owned())
            .spawn(move || {
                step_back();
                runtime.block_on(async {
                    tokio::select! {
                        () = accept(listener, app(desk.clone(), access, sessions), desk, tls.map(TlsAcceptor::from)) => {}
                        () = ended.notified() => {}
                    }
                });
                // the sockets end with the runtime
            })
            .map_err(ConsoleError::Thread)?;
        let console = Self { address, tls: secure, end, thread: Some(thread) };
        tracing::info!(url = console.url(), "the console listens");
        Ok(console)
    }

    /// Where it listens.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// What is typed into a browser on this computer.
    #[must_use]
    pub fn url(&self) -> String {
        let scheme = if self.tls { "https" } else { "http" };
        format!("{scheme}://{}/", self.address)
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        self.end.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Binds the port, or the next that is free where that is wanted.
fn bind(settings: &ConsoleSettings) -> Result<StdListener, ConsoleError> {
    let mut address = settings.listen;
    let first = StdListener::bind(address);
    let mut tried = match first {
        Err(cause)
            if settings.port == ConsolePort::OrNextFree && cause.kind() == io::ErrorKind::AddrInUse =>
        {
            Err(cause)
        }
        first => return first.map_err(|cause| ConsoleError::Listen(address, cause)),
    };
    for _ in 0..PORTS {
        let Some(port) = address.port().checked_add(1) else { break };
        address.set_port(port);
        tried = StdListener::bind(address);
        if tried.is_ok() {
            break;
        }
    }
    tried.map_err(|cause| ConsoleError::Listen(settings.listen, cause))
}

/// Takes connections until the end of time.
async fn accept(listener: StdListener, routes: Router, desk: Desk, tls: Option<TlsAcceptor>) {
    let Ok(listener) = TcpListener::from_std(listener) else { return };
    let room = Room::new(desk, SOCKETS);
    loop {
        let Ok((stream, from)) = listener.accept().await else {
            sleep(AFTER_AN_ERROR).await;
            continue;
        };
        // where nobody gives way it is closed, so that whoever comes sees it
        let Some(place) = room.admit(from.ip()).await else { continue };
        // buttons are small and wait for nothing
        let _ = stream.set_nodelay(true);
        let (leave, ticket) = (place.leave(), place.ticket());
        let taken = Taken { stream, _place: place };
        let (routes, tls) = (routes.clone(), tls.clone());
        let served = async move {
            match tls {
                None => serve(taken, ticket, routes).await,
                Some(tls) => {
                    if let Ok(Ok(stream)) = timeout(HANDSHAKE_WITHIN, tls.accept(taken)).await {
                        serve(stream, ticket, routes).await;
                    }
                }
            }
        };
        tokio::spawn(async move {
            tokio::select! {
                biased;
                () = leave.notified() => {}
                () = served => {}
            }
        });
    }
}

async fn serve(stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static, ticket: Ticket, routes: Router) {
    let routes = TowerToHyperService::new(routes);
    let service = service_fn(move |mut request: Request<Incoming>| {
        // who gets in says by it that this connection is known
        request.extensions_mut().insert(ticket.clone());
        routes.call(request)
    });
    let served = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_WITHIN)
        .max_buf_size(HEAD_BYTES)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    // whoever goes away in the middle is nobody's concern
    let _ = served.await;
}

/// A connection, which has its place for as long as it is open, upgraded or not.
struct Taken {
    stream: TcpStream,
    _place: Place,
}

impl AsyncRead for Taken {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(cx, buffer)
    }
}

impl AsyncWrite for Taken {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(cx, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }
}

#[cfg(test)]
mod tests;
