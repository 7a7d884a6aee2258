//! Counts the simultaneous connections or responses, in total and per client, and enforces their
//! limits.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, PoisonError};

use crate::options::Limits;

/// The number of connections or responses of each client.
#[derive(Debug, Default)]
pub(crate) struct Clients {
    counts: Mutex<(usize, HashMap<IpAddr, usize>)>,
}

/// A connection or response that counts until this value is dropped.
#[derive(Debug)]
pub(crate) struct Place {
    clients: Arc<Clients>,
    network: IpAddr,
}

impl Clients {
    /// Counts a connection or response, or returns the name of the limit that it exceeds.
    pub(crate) fn enter(self: &Arc<Self>, client: IpAddr, limits: &Limits) -> Result<Place, &'static str> {
        let network = network(client);
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        let (all, by_client) = &mut *counts;
        if *all >= limits.connections {
            return Err("connections");
        }
        if by_client.get(&network).copied().unwrap_or(0) >= limits.connections_per_client {
            return Err("client");
        }
        *by_client.entry(network).or_default() += 1;
        *all += 1;
        Ok(Place { clients: Arc::clone(self), network })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut counts = self.clients.counts.lock().unwrap_or_else(PoisonError::into_inner);
        let (all, by_client) = &mut *counts;
        *all -= 1;
        if let Some(count) = by_client.get_mut(&self.network) {
            *count -= 1;
            if *count == 0 {
                by_client.remove(&self.network);
            }
        }
    }
}

/// Returns the address that identifies a client: its IPv4 address, or its IPv6 network of 64 bits.
fn network(client: IpAddr) -> IpAddr {
    match client.to_canonical() {
        IpAddr::V6(address) => IpAddr::V6(Ipv6Addr::from_bits(address.to_bits() >> 64 << 64)),
        v4 @ IpAddr::V4(_) => v4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn connections_are_counted_by_client_and_in_all() {
        let limits = Limits::default().with_connections(3, 2);
        let clients = Arc::new(Clients::default());
        let enter = |client: &str| clients.enter(client.parse().unwrap(), &limits);
        let first = enter("10.0.0.1").unwrap();
        let _second = enter("::ffff:10.0.0.1").unwrap();
        assert_eq!(enter("10.0.0.1").unwrap_err(), "client");
        let third = enter("2001:db8::1").unwrap();
        assert_eq!(enter("10.0.0.2").unwrap_err(), "connections");
        assert_eq!(clients.counts.lock().unwrap().0, 3);
        let none = limits.clone().with_connections(3, 0);
        assert_eq!(clients.enter("10.0.0.9".parse().unwrap(), &none).unwrap_err(), "connections");
        drop(first);
        assert_eq!(clients.enter("10.0.0.9".parse().unwrap(), &none).unwrap_err(), "client");
        let _fourth = enter("2001:db8::2").unwrap();
        drop(third);
        let _fifth = enter("2001:db8::3").unwrap();
        assert_eq!(clients.counts.lock().unwrap().1.len(), 2);
    }
}
