//! Which names a request may have: a server that listens to this machine alone answers only to names of this machine.
//!
//! Otherwise a page of any site could read the files: its own name is made to lead to 127.0.0.1 once the page is loaded (DNS rebinding), and the browser then takes this server
//! for that site. The name in the request is still that of the site.

use std::net::{IpAddr, Ipv6Addr};

use axum::http::header::HOST;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, Uri};

use crate::error::Error;

/// The names that requests may have.
#[derive(Debug)]
pub(crate) struct Hosts {
    /// `None` for all.
    allowed: Option<Vec<String>>,
}

impl Hosts {
    pub(crate) fn new(address: IpAddr, names: &[String]) -> Result<Self, Error> {
        let names = names.iter().map(|name| allowed_name(name)).collect::<Result<_, _>>()?;
        Ok(Self { allowed: is_loopback(address).then_some(names) })
    }

    /// Checks the name of a request: in its URL, its header, or both.
    pub(crate) fn allow(&self, uri: &Uri, headers: &HeaderMap) -> bool {
        let Some(allowed) = &self.allowed else { return true };
        let mut named = headers
            .get_all(HOST)
            .iter()
            .map(|value| value.to_str().ok().and_then(|text| text.parse::<Authority>().ok()));
        let header = named.next();
        if named.next().is_some() {
            return false;
        }
        let is_allowed = |authority: &Authority| {
            let host = authority.host().trim_end_matches('.');
            is_local(host) || allowed.iter().any(|name| host.eq_ignore_ascii_case(name))
        };
        match (uri.authority(), header) {
            (None, None) => false,
            (authority, header) => {
                authority.is_none_or(is_allowed)
                    && header.is_none_or(|header| header.as_ref().is_some_and(is_allowed))
            }
        }
    }
}

fn is_local(host: &str) -> bool {
    let address = host.strip_prefix('[').and_then(|host| host.strip_suffix(']')).unwrap_or(host);
    host.eq_ignore_ascii_case("localhost") || address.parse::<IpAddr>().is_ok_and(is_loopback)
}

/// Checks whether an address leads to this machine alone, also one of IPv4 that is written in IPv6.
fn is_loopback(address: IpAddr) -> bool {
    address.to_canonical().is_loopback()
}

/// Returns a name as requests have it, without their ports.
fn allowed_name(name: &str) -> Result<String, Error> {
    if name.parse::<Ipv6Addr>().is_ok() {
        return Ok(format!("[{name}]"));
    }
    let is_host = name.parse::<Authority>().is_ok_and(|authority| authority.host() == name);
    if !is_host {
        let expected = "a name or an address without a port, such as models.example.org";
        return Err(Error::Parameter { name: "host", found: name.to_owned(), expected });
    }
    Ok(name.trim_end_matches('.').to_ascii_lowercase())
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;

    use super::*;

    fn allowed(hosts: &Hosts, host: &str) -> bool {
        let mut headers = HeaderMap::new();
        headers.insert(HOST, HeaderValue::from_str(host).unwrap());
        hosts.allow(&Uri::from_static("/"), &headers)
    }

    #[test]
    fn only_names_of_this_machine_are_allowed() {
        let hosts =
            Hosts::new(IpAddr::from([127, 0, 0, 1]), &["Models.example.".into(), "fd00::1".into()]).unwrap();
        for host in [
            "localhost",
            "LOCALHOST:8080",
            "localhost.:8080",
            "127.0.0.1:8080",
            "127.1.2.3",
            "[::1]:8080",
            "models.EXAMPLE:1",
            "models.example.",
            "[fd00::1]:80",
            "[::ffff:127.0.0.1]",
        ] {
            assert!(allowed(&hosts, host), "{host}");
        }
        for host in [
            "evil.example",
            "localhost.evil.example",
            "127.0.0.1.evil.example",
            "192.168.1.1",
            "0.0.0.0",
            "",
            "a b",
            "[::2]",
        ] {
            assert!(!allowed(&hosts, host), "{host}");
        }
        assert!(!hosts.allow(&Uri::from_static("/"), &HeaderMap::new()));
        assert!(hosts.allow(&Uri::from_static("http://localhost/"), &HeaderMap::new()));
        assert!(!hosts.allow(&Uri::from_static("http://evil.example/"), &HeaderMap::new()));
        let mut two = HeaderMap::new();
        two.append(HOST, HeaderValue::from_static("localhost"));
        two.append(HOST, HeaderValue::from_static("localhost"));
        assert!(!hosts.allow(&Uri::from_static("/"), &two));
        assert!(allowed(&Hosts::new(IpAddr::from([0, 0, 0, 0]), &[]).unwrap(), "evil.example"));
        let mapped = Hosts::new("::ffff:127.0.0.1".parse().unwrap(), &[]).unwrap();
        assert!(!allowed(&mapped, "evil.example") && allowed(&mapped, "localhost"));
        for wrong in ["name:8080", "[::1]:8080", "http://name", "a/b", ""] {
            let refused = Hosts::new(IpAddr::from([127, 0, 0, 1]), &[wrong.into()]);
            assert!(matches!(refused, Err(Error::Parameter { name: "host", .. })), "{wrong}");
        }
    }
}
