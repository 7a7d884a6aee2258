//! Request paths. A path is decoded once and rejected unless it names a file below a directory on
//! every operating system.
//!
//! # Algorithm
//! 1. Decode percent-encoding once, to UTF-8. A remaining percent sign is a normal character.
//! 2. Split the path at slashes. Reject a component that is empty, `.` or `..`, contains a control
//!    character or one of the characters that Windows reserves (such as a backslash or a colon),
//!    ends with a dot or a space, or names a Windows device. A path then has the same meaning on
//!    every system.
//! 3. Reject names that begin with a dot: such files often contain settings and secrets.
//!
//! This is the first of two checks. Files are then opened through a directory handle that no link
//! can leave (`folder.rs`).

use std::fmt;

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_decode_str, utf8_percent_encode};

/// The maximum length of a path in bytes, the maximum number of its components, and the maximum
/// length of a component in bytes.
const MAX_BYTES: usize = 2048;
const MAX_COMPONENTS: usize = 32;
const MAX_COMPONENT_BYTES: usize = 255;

/// The characters that are percent-encoded in URL paths.
const ENCODED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b'/');

/// Names that Windows reserves for devices, with any extension.
const DEVICES: [&str; 6] = ["CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"];

/// A valid path below the directory of a server, with slashes between its components.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct SitePath(String);

/// Why a path is rejected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BadPath {
    /// It cannot be the path of a file.
    Malformed,
    /// It names a hidden file, which is not served.
    Hidden,
}

impl SitePath {
    /// Decodes a URL path without the prefix of its route.
    pub(crate) fn decode(raw: &str) -> Result<Self, BadPath> {
        if raw.len() > 3 * MAX_BYTES || !is_well_encoded(raw) {
            return Err(BadPath::Malformed);
        }
        let decoded = percent_decode_str(raw).decode_utf8().map_err(|_| BadPath::Malformed)?;
        Self::new(&decoded)
    }

    /// Checks a decoded path.
    pub(crate) fn new(path: &str) -> Result<Self, BadPath> {
        if path.len() > MAX_BYTES || path.split('/').count() > MAX_COMPONENTS {
            return Err(BadPath::Malformed);
        }
        if !path.split('/').all(is_portable) {
            return Err(BadPath::Malformed);
        }
        if path.split('/').any(|component| component.starts_with('.')) {
            return Err(BadPath::Hidden);
        }
        Ok(Self(path.to_owned()))
    }

    /// Returns the path without this extension, or `None` if it has another one.
    pub(crate) fn without_extension(&self, extension: &str) -> Option<Self> {
        let path = self.0.strip_suffix(extension)?.strip_suffix('.')?;
        Self::new(path).ok()
    }

    /// Returns the path as text, with slashes between its components.
    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }

    /// Returns the percent-encoded path for a URL.
    pub(crate) fn encoded(&self) -> impl fmt::Display + '_ {
        utf8_percent_encode(&self.0, ENCODED)
    }
}

/// Returns a relative path with percent-encoding for a URL. Only ASCII letters, digits, slashes and
/// `-._~` are unchanged.
///
/// ```
/// assert_eq!(tristrip_serve::url_path("a b/ä.ply"), "a%20b/%C3%A4.ply");
/// ```
pub fn url_path(path: &str) -> String {
    utf8_percent_encode(path, ENCODED).to_string()
}

/// Checks that two hexadecimal digits follow each percent sign.
fn is_well_encoded(raw: &str) -> bool {
    raw.split('%')
        .skip(1)
        .all(|rest| rest.as_bytes().get(..2).is_some_and(|digits| digits.iter().all(u8::is_ascii_hexdigit)))
}

fn is_portable(component: &str) -> bool {
    let stem = component.split('.').next().unwrap_or_default().trim_end();
    !component.is_empty()
        && component.len() <= MAX_COMPONENT_BYTES
        && !matches!(component, "." | "..")
        && !component.contains(['\\', ':', '*', '?', '"', '<', '>', '|', '\u{fffd}'])
        && !component.contains(char::is_control)
        && !component.ends_with(['.', ' '])
        && !is_device(stem)
}

fn is_device(stem: &str) -> bool {
    let is_numbered = |prefix: &str| {
        let rest = stem.get(..3).filter(|start| start.eq_ignore_ascii_case(prefix)).and(stem.get(3..));
        rest.is_some_and(|rest| {
            let mut digits = rest.chars();
            matches!(digits.next(), Some('0'..='9' | '¹' | '²' | '³')) && digits.next().is_none()
        })
    };
    DEVICES.iter().any(|device| stem.eq_ignore_ascii_case(device)) || is_numbered("COM") || is_numbered("LPT")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_decoded_once() {
        let decoded = |raw| SitePath::decode(raw).map(|path| path.as_str().to_owned());
        assert_eq!(decoded("a%20b/c.ply").as_deref(), Ok("a b/c.ply"));
        assert_eq!(decoded("a%2Fb.ply").as_deref(), Ok("a/b.ply"));
        assert_eq!(decoded("50%25.ply").as_deref(), Ok("50%.ply"));
        assert_eq!(decoded("%252e%252e").as_deref(), Ok("%2e%2e"));
        assert_eq!(decoded("%C3%A4.ply").as_deref(), Ok("ä.ply"));
        assert_eq!(decoded("console.ply").as_deref(), Ok("console.ply"));
        assert_eq!(decoded("com10.ply").as_deref(), Ok("com10.ply"));
    }

    #[test]
    fn paths_that_lead_elsewhere_are_refused() {
        let long = "a/".repeat(40) + "b";
        let longer = "a".repeat(300);
        for raw in [
            "",
            "/",
            "a/",
            "/a",
            "a//b",
            ".",
            "..",
            "../a",
            "a/../b",
            "a/./b",
            "%2e%2e/a",
            "a%2f..%2fb",
            "..%2fa",
            "a%5cb",
            "a\\b",
            "c:",
            "c:/a",
            "%43%3a/a",
            "a%00",
            "a%0a",
            "%7f",
            "%c2%85",
            "a.",
            "a%20",
            "a./b",
            "con",
            "CON.ply",
            "nul",
            "x/aux.txt",
            "com1",
            "lpt9.ply",
            "COM%C2%B9",
            "prn .ply",
            "%",
            "%2",
            "%zz",
            "%ff",
            "%c0%ae%c0%ae/a",
            "a*",
            "a%3f",
            "a%7cb",
            &long,
            &longer,
        ] {
            assert_eq!(SitePath::decode(raw), Err(BadPath::Malformed), "{raw}");
        }
        for raw in [".env", "a/.git/config", "%2egit", "...", "..a"] {
            let refused = SitePath::decode(raw);
            assert!(refused.is_err(), "{raw}");
        }
    }

    #[test]
    fn paths_are_encoded_for_urls() {
        let path = SitePath::new("a b/ä%.ply").unwrap();
        assert_eq!(path.encoded().to_string(), "a%20b/%C3%A4%25.ply");
        assert_eq!(SitePath::decode(&path.encoded().to_string()), Ok(path.clone()));
        let packed = SitePath::new("a/b.ply.glb").unwrap();
        assert_eq!(packed.without_extension("glb"), Some(SitePath::new("a/b.ply").unwrap()));
        assert_eq!(packed.without_extension("png"), None);
        assert_eq!(SitePath::new("a.glb").unwrap().without_extension("a.glb"), None);
    }
}
