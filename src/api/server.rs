//! The accept loop. A client that sends half a header and then waits, or does not read its answer, is cut off, which `axum::serve`
//! cannot do, and no number of connections takes more than its share.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::patience::Patient;
use super::request::HEADER_LIMIT;

/// Time in which a new connection has to begin its first request.
const FIRST_BYTE_TIME: Duration = Duration::from_secs(10);

/// Time for a whole request header, from the first moment of waiting for it: also the longest silence
/// between two requests of a connection.
const HEADER_TIME: Duration = Duration::from_secs(30);

/// Longest time in which a client may take nothing of its answer.
const READING_TIME: Duration = Duration::from_secs(30);

/// Connections at a time.
const CONNECTIONS: usize = 1024;

/// Connections beyond, which are soon closed and only told how the service is; more wait to be accepted.
const LOBBY: usize = 64;

/// All the time that those in the lobby have, and for their first byte: those who only hold a place there make way at once.
const LOBBY_TIME: Duration = Duration::from_secs(2);
const LOBBY_FIRST_BYTE_TIME: Duration = Duration::from_millis(200);

/// Open files beside connections: database, pages of the portal, the runtime's own.
const OTHER_FILES: u64 = 128;

/// Bytes of answers that wait in the kernel for a client to read, for each connection; on its own it takes megabytes, and whoever fills
/// them for many connections holds up the others.
#[cfg(target_os = "linux")]
const UNSENT_BYTES: u32 = 128 << 10;

/// Time that requests have to end once the service stops.
const GRACE: Duration = Duration::from_secs(5);

/// Serves until told to stop, then lets the requests under way end.
pub async fn serve(listener: TcpListener, router: Router, lobby: Router, stop: CancellationToken) {
    // What a listener has, its connections have.
    #[cfg(target_os = "linux")]
    if let Err(error) = socket2::SockRef::from(&listener).set_tcp_notsent_lowat(UNSENT_BYTES) {
        tracing::warn!(%error, "answers that are not read take more memory of the kernel than they should");
    }
    let places = Arc::new(Semaphore::new(connections()));
    let beyond = Arc::new(Semaphore::new(LOBBY));
    let conversations = TaskTracker::new();
    while let Some((stream, guest)) = next(&listener, &places, &beyond, &stop).await {
        let (router, stop) = (if guest.is_in_lobby { &lobby } else { &router }.clone(), stop.clone());
        conversations.spawn(async move {
            tokio::select! {
                () = converse(stream, router, &guest, &stop) => {}
                () = tokio::time::sleep(LOBBY_TIME), if guest.is_in_lobby => {}
            }
        });
    }
    drop(listener);
    conversations.close();
    if tokio::time::timeout(GRACE, conversations.wait()).await.is_err() {
        tracing::warn!(connections = conversations.len(), "requests are broken off");
    }
}

/// Connections that the limit of open files allows; the limit is raised as far as it goes.
fn connections() -> usize {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Resource, getrlimit, setrlimit};
        let mut files = getrlimit(Resource::Nofile);
        files.current = files.maximum;
        if let Err(error) = setrlimit(Resource::Nofile, files) {
            tracing::warn!(%error, "the limit of open files stays as it is");
        }
        if let Some(allowed) = getrlimit(Resource::Nofile).current {
            let allowed = usize::try_from(allowed.saturating_sub(OTHER_FILES)).unwrap_or(usize::MAX);
            return allowed.saturating_sub(LOBBY).clamp(1, CONNECTIONS);
        }
    }
    CONNECTIONS
}

/// A connection's place.
struct Guest {
    is_in_lobby: bool,
    _place: OwnedSemaphorePermit,
}

/// The next connection and its place, until told to stop.
async fn next(
    listener: &TcpListener,
    places: &Arc<Semaphore>,
    beyond: &Arc<Semaphore>,
    stop: &CancellationToken,
) -> Option<(TcpStream, Guest)> {
    let accept = async {
        // Before a connection is taken, so that those for which there is no place at all wait outside.
        let in_lobby = Arc::clone(beyond).acquire_owned().await.ok()?;
        loop {
            match listener.accept().await {
                Ok((stream, _)) => {
                    let guest = match Arc::clone(places).try_acquire_owned() {
                        Ok(place) => Guest { is_in_lobby: false, _place: place },
                        Err(_) => Guest { is_in_lobby: true, _place: in_lobby },
                    };
                    return Some((stream, guest));
                }
                // Such as too many open files: goes by itself, and until then trying again at once burns a core.
                Err(error) => {
                    tracing::warn!(%error, "a connection could not be accepted");
                    tokio::time::sleep(Duration::from_millis(100)).await;
                }
            }
        }
    };
    tokio::select! {
        accepted = accept => accepted,
        () = stop.cancelled() => None,
    }
}

async fn converse(stream: TcpStream, router: Router, guest: &Guest, stop: &CancellationToken) {
    // Answers are short and complete: waiting for more to send only delays them.
    let _ = stream.set_nodelay(true);
    let mut first = [0];
    let first_byte_time = if guest.is_in_lobby { LOBBY_FIRST_BYTE_TIME } else { FIRST_BYTE_TIME };
    let begun = tokio::select! {
        begun = tokio::time::timeout(first_byte_time, stream.peek(&mut first)) => matches!(begun, Ok(Ok(1))),
        () = stop.cancelled() => false,
    };
    if !begun {
        return;
    }
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER_TIME)
        // Also what is read ahead of a connection.
        .max_buf_size(HEADER_LIMIT)
        .keep_alive(!guest.is_in_lobby)
        .serve_connection(TokioIo::new(Patient::new(stream, READING_TIME)), TowerToHyperService::new(router));
    tokio::pin!(connection);
    let ended = tokio::select! {
        ended = connection.as_mut() => ended,
        () = stop.cancelled() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = ended {
        tracing::debug!(%error, "a connection broke off");
    }
}

/// The address as a client writes it: one that means every interface is reached on loopback, too.
pub fn url(address: SocketAddr) -> String {
    match (address.ip().is_unspecified(), address) {
        (true, SocketAddr::V4(_)) => format!("http://127.0.0.1:{}", address.port()),
        (true, SocketAddr::V6(_)) => format!("http://[::1]:{}", address.port()),
        (false, address) => format!("http://{address}"),
    }
}
