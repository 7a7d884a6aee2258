//! The host names that a request may contain. A server on a loopback address accepts only names of
//! this machine.
//!
//! Otherwise, a page of any site could read the files by DNS rebinding. The site changes its own
//! DNS name to 127.0.0.1 after the page is loaded, and the browser then sends requests for the site
//! to this server. These requests still contain the name of the site.

use std::net::{IpAddr, Ipv6Addr};

use axum::http::header::HOST;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, Uri};

use crate::error::Error;

/// The allowed host names.
#[derive(Debug)]
pub(crate) struct Hosts {
    /// `None` allows all names.
    allowed: Option<Vec<String>>,
}

impl Hosts {
    pub(crate) fn new(address: IpAddr, names: &[String]) -> Result<Self, Error> {
        let names = names.iter().map(|name| allowed_name(name)).collect::<Result<_, _>>()?;
        Ok(Self { allowed: is_loopback(address).then_some(names) })
    }

    /// Checks the host name of a request in its URL, its `Host` header, or both.
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

/// Checks whether an address is a loopback address, also as an IPv4-mapped IPv6 address.
fn is_loopback(address: IpAddr) -> bool {
    address.to_canonical().is_loopback()
}

/// Returns a name in the form that requests use, without a port.
fn allowed_name(name: &str) -> Result<String, Error> {
    if name.parse::<Ipv6Addr>().is_ok() {
        return Ok(format!("[{name}]"));
    }
    let is_host = name.parse::<Authority>().is_ok_and(|authority| authority.host() == name);
    if !is_host {
        let expected = "a host name or an address without a port, such as models.example.org";
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
