//! TCP options of the connections to a server, which sqlx leaves at their defaults.
//!
//! - `TCP_NODELAY`: statements are sent at once. Otherwise the last packet of a long statement waits for the server's delayed
//!   acknowledgement (40 ms).
//! - Timeouts: a connection is closed when neither data nor a refusal arrives, as behind a firewall that forgets connections. By
//!   default TCP needs a quarter of an hour, and a connection that only listens stays open for ever. A query of the queue, which has
//!   no time limit, would wait as long.

use std::os::fd::{BorrowedFd, RawFd};
use std::time::Duration;

use socket2::{SockRef, TcpKeepalive};

/// Time in which the server's machine must acknowledge sent data.
const ACKNOWLEDGE_TIMEOUT: Duration = Duration::from_secs(10);

/// Idle time before the first keep-alive probe.
const KEEPALIVE_AFTER: Duration = Duration::from_secs(15);
/// Time between two keep-alive probes.
const KEEPALIVE_INTERVAL: Duration = Duration::from_secs(5);

/// Sets the options of all connections of this process to this port.
///
/// The pool does not give access to the socket of a connection, so all open files are examined. Setting an option twice is harmless.
pub fn set_for_port(port: u16) {
    let Ok(files) = std::fs::read_dir("/proc/self/fd") else { return };
    for file in files.flatten() {
        let Some(file) = file.file_name().to_str().and_then(|name| name.parse::<RawFd>().ok()) else { continue };
        // SAFETY: the descriptor was open a moment ago and is used only within this iteration. If another thread has closed it
        // meanwhile, the calls below fail, or examine another socket in the same way.
        #[allow(unsafe_code)]
        let socket = unsafe { BorrowedFd::borrow_raw(file) };
        let socket = SockRef::from(&socket);
        if is_connected_to(&socket, port)
            && let Err(error) = set(&socket)
        {
            tracing::warn!(%error, "TCP options of a database connection could not be set; the defaults apply");
        }
    }
}

fn is_connected_to(socket: &SockRef<'_>, port: u16) -> bool {
    socket.peer_addr().ok().and_then(|peer| peer.as_socket()).is_some_and(|peer| peer.port() == port)
}

fn set(socket: &SockRef<'_>) -> std::io::Result<()> {
    socket.set_tcp_nodelay(true)?;
    socket.set_tcp_user_timeout(Some(ACKNOWLEDGE_TIMEOUT))?;
    socket.set_tcp_keepalive(&TcpKeepalive::new().with_time(KEEPALIVE_AFTER).with_interval(KEEPALIVE_INTERVAL))
}
