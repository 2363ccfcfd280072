//! Places of connections. When all are taken, a new connection replaces one that has sent no authorised request.

use std::collections::{BTreeMap, HashMap};
use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_util::sync::CancellationToken;

/// Shortest time that a connection has for its first request. A burst of clients that send at once is therefore answered.
pub const MIN_TIME_TO_REQUEST: Duration = Duration::from_millis(200);

/// The places of all connections.
pub struct Places {
    free: Arc<Semaphore>,
    arrivals: Arc<Mutex<Arrivals>>,
}

/// Connections without an authorised request, in the order of their arrival.
#[derive(Default)]
struct Arrivals {
    count: u64,
    waiting: BTreeMap<u64, Waiting>,
}

struct Waiting {
    network: IpAddr,
    since: Instant,
    replaced: CancellationToken,
}

impl Places {
    /// `count` free places.
    pub fn new(count: usize) -> Self {
        Self { free: Arc::new(Semaphore::new(count)), arrivals: Arc::default() }
    }

    /// A place for a new connection; `None` if all are taken by connections with an authorised request, or by ones that just arrived.
    pub async fn take(&self, address: IpAddr) -> Option<Place> {
        let permit = match Arc::clone(&self.free).try_acquire_owned() {
            Ok(permit) => permit,
            Err(_) => {
                lock(&self.arrivals).take_longest(Instant::now())?.replaced.cancel();
                tracing::debug!("a connection without an authorised request was replaced");
                Arc::clone(&self.free).acquire_owned().await.ok()?
            }
        };
        let replaced = CancellationToken::new();
        let number = lock(&self.arrivals).add(network(address), Instant::now(), replaced.clone());
        let arrival = Arrival { arrivals: Arc::clone(&self.arrivals), number };
        Some(Place { arrival, replaced, _permit: permit })
    }
}

impl Arrivals {
    fn add(&mut self, network: IpAddr, since: Instant, replaced: CancellationToken) -> u64 {
        self.count += 1;
        self.waiting.insert(self.count, Waiting { network, since, replaced });
        self.count
    }

    /// Removes the oldest connection of the network that has most of them. One network can thus not displace the others.
    fn take_longest(&mut self, now: Instant) -> Option<Waiting> {
        let mut counts = HashMap::<IpAddr, (usize, u64)>::new();
        for (&number, waiting) in &self.waiting {
            let (count, _) = counts.entry(waiting.network).or_insert((0, number));
            *count += 1;
        }
        let is_old = |number: u64| now.saturating_duration_since(self.waiting[&number].since) >= MIN_TIME_TO_REQUEST;
        let replaceable = counts.into_values().filter(|&(_, oldest)| is_old(oldest));
        // Of networks with the same number, the one with the oldest connection.
        let (_, oldest) = replaceable.max_by_key(|&(count, oldest)| (count, u64::MAX - oldest))?;
        self.waiting.remove(&oldest)
    }
}

/// The place of a connection, free again when it is dropped.
pub struct Place {
    pub arrival: Arrival,
    /// Cancelled when another connection takes the place.
    pub replaced: CancellationToken,
    _permit: OwnedSemaphorePermit,
}

impl Drop for Place {
    fn drop(&mut self) {
        // Before the permit is returned: a connection without permit must not be chosen.
        self.arrival.remove();
    }
}

/// The entry of a connection among those without an authorised request.
#[derive(Clone)]
pub struct Arrival {
    arrivals: Arc<Mutex<Arrivals>>,
    number: u64,
}

impl Arrival {
    /// Removes the entry, so that the connection is no longer replaced.
    pub fn remove(&self) {
        lock(&self.arrivals).waiting.remove(&self.number);
    }
}

fn lock(arrivals: &Mutex<Arrivals>) -> MutexGuard<'_, Arrivals> {
    arrivals.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The network of a client: its IPv4 address, or the first 64 bits of its IPv6 address, within which a client can choose addresses.
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => Ipv6Addr::from_bits(address.to_bits() >> 64 << 64).into(),
        address => address,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(host: u8) -> IpAddr {
        IpAddr::from([10, 0, 0, host])
    }

    #[test]
    fn the_network_with_most_waiting_connections_loses_its_oldest() {
        let (mut arrivals, begin) = (Arrivals::default(), Instant::now());
        let hosts = [1, 2, 2, 2];
        let signals = hosts.map(|host| {
            let replaced = CancellationToken::new();
            arrivals.add(address(host), begin, replaced.clone());
            replaced
        });
        assert!(arrivals.take_longest(begin + MIN_TIME_TO_REQUEST / 2).is_none(), "all have just arrived");
        let later = begin + MIN_TIME_TO_REQUEST;
        arrivals.take_longest(later).expect("an old connection").replaced.cancel();
        assert_eq!(signals.map(|replaced| replaced.is_cancelled()), [false, true, false, false]);
        // The oldest one where all networks have as many.
        let left: Vec<IpAddr> = std::iter::from_fn(|| arrivals.take_longest(later)).map(|lost| lost.network).collect();
        assert_eq!(left, [2, 1, 2].map(address));
    }

    #[tokio::test]
    async fn a_connection_with_an_authorised_request_keeps_its_place() {
        let places = Places::new(2);
        let held = [places.take(address(1)).await, places.take(address(1)).await];
        held.iter().flatten().for_each(|place| place.arrival.remove());
        tokio::time::sleep(MIN_TIME_TO_REQUEST).await;
        assert!(places.take(address(2)).await.is_none());
        drop(held);
        assert!(places.take(address(2)).await.is_some());
    }

    #[test]
    fn addresses_of_one_client_are_one_network() {
        let of = |text: &str| network(text.parse().expect("an address"));
        assert_eq!(of("2001:db8:0:1::1"), of("2001:db8:0:1:ffff::2"));
        assert_ne!(of("2001:db8:0:1::1"), of("2001:db8:0:2::1"));
        assert_eq!(of("::ffff:10.0.0.1"), of("10.0.0.1"));
        assert_ne!(of("10.0.0.1"), of("10.0.0.2"));
    }
}
