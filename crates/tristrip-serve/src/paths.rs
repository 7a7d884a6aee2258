//! Paths of requests: decoded once, and refused unless they name something below a folder on every system.
//!
//! # Algorithm
//! 1. Percent signs are decoded once, to UTF-8. A percent sign that is left is a character.
//! 2. The path is cut at slashes. Each component is refused if it is empty, `.` or `..`, has a control character, a backslash or a colon, ends with a
//!    dot or a space, or names a device of Windows. So a path means the same on every system, whatever the folder is.
//! 3. Names that begin with a dot are not served: such files hold settings and secrets.
//!
//! The folder is then opened by a handle that no link leads out of (`folder.rs`); this check is the first of the two.

use std::fmt;

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_decode_str, utf8_percent_encode};

/// The longest path in bytes, the most components, and the longest component.
const MAX_BYTES: usize = 2048;
const MAX_COMPONENTS: usize = 32;
const MAX_COMPONENT_BYTES: usize = 255;

/// What is encoded in the paths of URLs.
const ENCODED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b'/');

/// Names that Windows keeps for devices, with any extension.
const DEVICES: [&str; 6] = ["CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"];

/// A path below the folder of a server: components between slashes.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct SitePath(String);

/// Why a path is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BadPath {
    /// It is not a path of a file.
    Malformed,
    /// It is one that is not served.
    Hidden,
}

impl SitePath {
    /// Decodes the path of a URL, behind the slash that ends its route.
    pub(crate) fn decode(raw: &str) -> Result<Self, BadPath> {
        if raw.len() > 3 * MAX_BYTES || !is_well_encoded(raw) {
            return Err(BadPath::Malformed);
        }
        let decoded = percent_decode_str(raw).decode_utf8().map_err(|_| BadPath::Malformed)?;
        Self::new(&decoded)
    }

    /// Checks a path that is not encoded.
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

    /// Returns the path without an extension, if it has this one.
    pub(crate) fn without_extension(&self, extension: &str) -> Option<Self> {
        let path = self.0.strip_suffix(extension)?.strip_suffix('.')?;
        Self::new(path).ok()
    }

    /// Returns the path as text between slashes.
    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }

    /// Returns the path for a URL.
    pub(crate) fn encoded(&self) -> impl fmt::Display + '_ {
        utf8_percent_encode(&self.0, ENCODED)
    }
}

/// Returns a relative path as a URL has it: percent signs for all but letters, digits, slashes and `-._~`.
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
