//! Which names a request may have: a server that listens to this machine alone answers only to names of this machine.
//!
//! Otherwise a page of any site could read the files: its own name is made to lead to 127.0.0.1 once the page is loaded (DNS rebinding), and the browser then takes this server
//! for that site. The name in the request is still that of the site.

use std::net::IpAddr;

use axum::http::header::HOST;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, Uri};

/// The names that requests may have.
#[derive(Debug)]
pub(crate) struct Hosts {
    /// `None` for all.
    allowed: Option<Vec<String>>,
}

impl Hosts {
    pub(crate) fn new(address: IpAddr, names: &[String]) -> Self {
        let names = || names.iter().map(|name| name.trim_end_matches('.').to_ascii_lowercase()).collect();
        Self { allowed: address.is_loopback().then(names) }
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
            is_local(authority.host())
                || allowed.iter().any(|name| authority.host().eq_ignore_ascii_case(name))
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
    host.eq_ignore_ascii_case("localhost")
        || address.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
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
        let hosts = Hosts::new(IpAddr::from([127, 0, 0, 1]), &["Models.example".into()]);
        for host in
            ["localhost", "LOCALHOST:8080", "127.0.0.1:8080", "127.1.2.3", "[::1]:8080", "models.EXAMPLE:1"]
        {
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
        assert!(allowed(&Hosts::new(IpAddr::from([0, 0, 0, 0]), &[]), "evil.example"));
    }
}
