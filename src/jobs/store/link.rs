//! What TCP is to do on the links to a server, which sqlx leaves to its defaults.
//!
//! Statements go out at once: else the end of one that takes several packets waits for the server's acknowledgement of the rest, which
//! the server puts off for 40 ms. And where nothing comes back any more, neither data nor a refusal, as behind a firewall that forgets
//! connections, the link is given up: by itself TCP does that after a quarter of an hour, and where only listening is done, never; a
//! query of the queue's, which has no time limit, would wait as long.

use std::os::fd::{BorrowedFd, RawFd};
use std::time::Duration;

use socket2::{SockRef, TcpKeepalive};

/// Time in which the server's machine has to acknowledge what was sent.
const SILENCE: Duration = Duration::from_secs(10);

/// Silence after which it is asked for a sign of life, and time between two such questions.
const ASK_AFTER: Duration = Duration::from_secs(15);
const ASK_AGAIN: Duration = Duration::from_secs(5);

/// Has TCP send at once and give up silent links, on all links to this port. The pool does not tell which socket is a connection's, and so all of this process are
/// looked at; to set the same again does no harm.
pub fn prepare(port: u16) {
    let Ok(files) = std::fs::read_dir("/proc/self/fd") else { return };
    for file in files.flatten() {
        let Some(file) = file.file_name().to_str().and_then(|name| name.parse::<RawFd>().ok()) else { continue };
        // SAFETY: the number is of a file that was open a moment ago, and is used only within this turn. Should another thread have closed it
        // meanwhile, the calls below fail, or ask another socket the same question.
        #[allow(unsafe_code)]
        let socket = unsafe { BorrowedFd::borrow_raw(file) };
        let socket = SockRef::from(&socket);
        if leads_to(&socket, port)
            && let Err(error) = set(&socket)
        {
            tracing::warn!(%error, "a link to the database is as slow, and is waited for as long, as TCP's defaults have it");
        }
    }
}

fn leads_to(socket: &SockRef<'_>, port: u16) -> bool {
    socket.peer_addr().ok().and_then(|peer| peer.as_socket()).is_some_and(|peer| peer.port() == port)
}

fn set(socket: &SockRef<'_>) -> std::io::Result<()> {
    socket.set_tcp_nodelay(true)?;
    socket.set_tcp_user_timeout(Some(SILENCE))?;
    socket.set_tcp_keepalive(&TcpKeepalive::new().with_time(ASK_AFTER).with_interval(ASK_AGAIN))
}
