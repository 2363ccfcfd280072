//! The accept loop. Unlike `axum::serve` it limits the number of connections, and closes a connection whose client does not complete its
//! header or does not read its answer in time. When all places are taken, connections without an authorised request are replaced.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::http::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::Service;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::connection_places::{Arrival, MIN_TIME_TO_REQUEST, Place, Places};
use super::limits::HEADER_LIMIT;
use super::write_timeout::WriteTimeout;

/// Longest time until the first byte of a new connection.
const FIRST_BYTE_TIMEOUT: Duration = Duration::from_secs(10);

/// Longest time until a request header is complete. It is also the longest pause between two requests of a connection.
const HEADER_TIMEOUT: Duration = Duration::from_secs(30);

/// Longest time for which a client may read nothing of its answer.
const WRITE_TIMEOUT: Duration = Duration::from_secs(30);

/// Largest number of connections.
const MAX_CONNECTIONS: usize = 1024;

/// Largest number of connections beyond, the overflow, when no connection may be replaced: they get only the probes and are closed soon.
/// Further ones wait to be accepted.
const MAX_OVERFLOW: usize = 64;

/// Longest duration of an overflow connection.
const OVERFLOW_TIMEOUT: Duration = Duration::from_secs(2);

/// Number of open files in addition to connections: database and runtime.
const OTHER_FILES: u64 = 128;

/// Largest size of unsent data of a connection in the kernel [B]. By default it grows to megabytes, and clients that do not read could
/// fill them on many connections.
#[cfg(target_os = "linux")]
const UNSENT_BYTES: u32 = 128 << 10;

/// Longest time for requests to end when the service stops.
const STOP_TIMEOUT: Duration = Duration::from_secs(5);

/// Serves until `stop` is cancelled, then waits for the current requests.
pub async fn serve(listener: TcpListener, router: Router, overflow: Router, stop: CancellationToken) {
    // Connections inherit the options of their listener.
    #[cfg(target_os = "linux")]
    if let Err(error) = socket2::SockRef::from(&listener).set_tcp_notsent_lowat(UNSENT_BYTES) {
        tracing::warn!(%error, "the limit of unsent data could not be set; unread answers take more memory in the kernel");
    }
    let places = Places::new(connection_limit());
    let beyond = Arc::new(Semaphore::new(MAX_OVERFLOW));
    let connections = TaskTracker::new();
    while let Some((stream, admission)) = next(&listener, &places, &beyond, &stop).await {
        let (router, stop) = (if admission.is_overflow() { &overflow } else { &router }.clone(), stop.clone());
        connections.spawn(async move {
            tokio::select! {
                () = serve_connection(stream, router, &admission, &stop) => {}
                () = admission.ended() => {}
            }
        });
    }
    drop(listener);
    connections.close();
    if tokio::time::timeout(STOP_TIMEOUT, connections.wait()).await.is_err() {
        tracing::warn!(connections = connections.len(), "unfinished requests are aborted");
    }
}

/// Largest number of connections that the limit of open files allows. The limit is raised to its maximum first.
fn connection_limit() -> usize {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Resource, getrlimit, setrlimit};
        let mut files = getrlimit(Resource::Nofile);
        files.current = files.maximum;
        if let Err(error) = setrlimit(Resource::Nofile, files) {
            tracing::warn!(%error, "the limit of open files could not be raised");
        }
        if let Some(allowed) = getrlimit(Resource::Nofile).current {
            let allowed = usize::try_from(allowed.saturating_sub(OTHER_FILES)).unwrap_or(usize::MAX);
            return allowed.saturating_sub(MAX_OVERFLOW).clamp(1, MAX_CONNECTIONS);
        }
    }
    MAX_CONNECTIONS
}

/// The place of a connection.
enum Admission {
    Regular(Place),
    Overflow(#[allow(dead_code, reason = "held until the connection ends")] OwnedSemaphorePermit),
}

impl Admission {
    fn is_overflow(&self) -> bool {
        matches!(self, Self::Overflow(_))
    }

    /// The entry of a regular connection among those without an authorised request.
    fn arrival(&self) -> Option<Arrival> {
        match self {
            Self::Regular(place) => Some(place.arrival.clone()),
            Self::Overflow(_) => None,
        }
    }

    /// Ends when the connection must give up its place.
    async fn ended(&self) {
        match self {
            Self::Regular(place) => place.replaced.cancelled().await,
            Self::Overflow(_) => tokio::time::sleep(OVERFLOW_TIMEOUT).await,
        }
    }
}

/// The next connection and its place; `None` when the service stops.
async fn next(
    listener: &TcpListener,
    places: &Places,
    beyond: &Arc<Semaphore>,
    stop: &CancellationToken,
) -> Option<(TcpStream, Admission)> {
    let accept = async {
        loop {
            match listener.accept().await {
                Ok((stream, address)) => return Some((stream, admission(address.ip(), places, beyond).await?)),
                // Such as too many open files, a temporary state. Retrying without a pause would occupy a core.
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

/// The place of an accepted connection. While it waits for one, connections beyond all limits wait in the kernel.
async fn admission(address: IpAddr, places: &Places, beyond: &Arc<Semaphore>) -> Option<Admission> {
    loop {
        if let Some(place) = places.take(address).await {
            return Some(Admission::Regular(place));
        }
        tokio::select! {
            overflow = Arc::clone(beyond).acquire_owned() => return Some(Admission::Overflow(overflow.ok()?)),
            // By then another connection may be replaced.
            () = tokio::time::sleep(MIN_TIME_TO_REQUEST) => {}
        }
    }
}

/// The routes as the service of one connection: each request carries the connection's entry.
struct Routes {
    routes: TowerToHyperService<Router>,
    arrival: Option<Arrival>,
}

impl Service<Request<Incoming>> for Routes {
    type Response = <TowerToHyperService<Router> as Service<Request<Incoming>>>::Response;
    type Error = <TowerToHyperService<Router> as Service<Request<Incoming>>>::Error;
    type Future = <TowerToHyperService<Router> as Service<Request<Incoming>>>::Future;

    fn call(&self, mut request: Request<Incoming>) -> Self::Future {
        if let Some(arrival) = &self.arrival {
            request.extensions_mut().insert(arrival.clone());
        }
        self.routes.call(request)
    }
}

async fn serve_connection(stream: TcpStream, router: Router, admission: &Admission, stop: &CancellationToken) {
    // Answers are written whole, so waiting for more data would only delay them.
    let _ = stream.set_nodelay(true);
    let mut first = [0];
    let first_byte_timeout = if admission.is_overflow() { MIN_TIME_TO_REQUEST } else { FIRST_BYTE_TIMEOUT };
    let has_data = tokio::select! {
        peeked = tokio::time::timeout(first_byte_timeout, stream.peek(&mut first)) => matches!(peeked, Ok(Ok(1))),
        () = stop.cancelled() => false,
    };
    if !has_data {
        return;
    }
    let service = Routes { routes: TowerToHyperService::new(router), arrival: admission.arrival() };
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER_TIMEOUT)
        // Also the limit of data that is read ahead.
        .max_buf_size(HEADER_LIMIT)
        .keep_alive(!admission.is_overflow())
        .serve_connection(TokioIo::new(WriteTimeout::new(stream, WRITE_TIMEOUT)), service);
    tokio::pin!(connection);
    let ended = tokio::select! {
        ended = connection.as_mut() => ended,
        () = stop.cancelled() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = ended {
        tracing::debug!(%error, "a connection ended with an error");
    }
}

/// The URL of an address. The unspecified address is written as loopback.
pub fn url(address: SocketAddr) -> String {
    match (address.ip().is_unspecified(), address) {
        (true, SocketAddr::V4(_)) => format!("http://127.0.0.1:{}", address.port()),
        (true, SocketAddr::V6(_)) => format!("http://[::1]:{}", address.port()),
        (false, address) => format!("http://{address}"),
    }
}
