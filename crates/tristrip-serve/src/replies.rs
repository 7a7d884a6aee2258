//! Responses with bytes: conditional requests, ranges, and the headers that caches and range
//! requests need.
//!
//! # Algorithm
//! The headers are evaluated in the order of RFC 9110. First, `If-None-Match` can lead to a 304
//! response; if it is absent, `If-Modified-Since` can. Then the range is used if `If-Range` is
//! absent or names exactly this version. A date in `If-Range` never matches: the file may have been
//! written twice within one second. A single range is answered with 206. Several ranges are
//! answered with the complete file, as the RFC allows. A range after the end is answered with 416.
//! `If-Match` is ignored because all requests are GET or HEAD, and HEAD has no range.

use std::ops::Range;
use std::time::SystemTime;

use axum::body::Body;
use axum::http::header::{
    ACCEPT_RANGES, CACHE_CONTROL, CONTENT_LENGTH, CONTENT_RANGE, CONTENT_TYPE, ETAG, IF_NONE_MATCH, IF_RANGE,
    LAST_MODIFIED, RANGE, RETRY_AFTER, VARY,
};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::Response;
use headers::{ETag, HeaderMapExt, IfModifiedSince, IfNoneMatch, LastModified};

use crate::bytes_source::BytesSource;
use crate::media::is_compressible;

/// Bytes with the metadata of a response.
#[derive(Debug, Clone)]
pub(crate) struct Resource {
    pub(crate) source: BytesSource,
    pub(crate) media_type: &'static str,
    /// The tag of this version of the bytes: letters, digits and hyphens.
    pub(crate) tag: String,
    pub(crate) modified: Option<SystemTime>,
}

impl Resource {
    /// Answers a request with these headers. The body is the body for GET.
    pub(crate) fn reply(&self, request: &HeaderMap) -> Response {
        let etag = format!("\"{}\"", self.tag);
        let modified = self.modified.map(LastModified::from);
        let mut response = Response::new(Body::empty());
        let headers = response.headers_mut();
        set(headers, ETAG, &etag);
        set(headers, CACHE_CONTROL, "no-cache");
        if let Some(modified) = modified {
            headers.typed_insert(modified);
        }
        if is_compressible(self.media_type) {
            headers.insert(VARY, HeaderValue::from_static("accept-encoding"));
        }
        let parsed: Option<ETag> = etag.parse().ok();
        if self.is_known(request, parsed.as_ref()) {
            // A client that received compressed bytes has the weak tag.
            let weak = format!("W/{etag}");
            let is_weak = |value: &HeaderValue| value.to_str().is_ok_and(|tags| tags.contains(&weak));
            if request.get_all(IF_NONE_MATCH).iter().any(is_weak) {
                set(headers, ETAG, &weak);
            }
            *response.status_mut() = StatusCode::NOT_MODIFIED;
            return response;
        }
        set(headers, ACCEPT_RANGES, "bytes");
        let length = self.source.len();
        let range = if range_applies(request, &etag) { range(request, length) } else { Ok(None) };
        let (status, sent) = match range {
            Ok(None) => (StatusCode::OK, 0..length),
            Ok(Some(range)) => {
                set(headers, CONTENT_RANGE, &format!("bytes {}-{}/{length}", range.start, range.end - 1));
                (StatusCode::PARTIAL_CONTENT, range)
            }
            Err(()) => {
                set(headers, CONTENT_RANGE, &format!("bytes */{length}"));
                headers.remove(ETAG);
                headers.remove(LAST_MODIFIED);
                *response.status_mut() = StatusCode::RANGE_NOT_SATISFIABLE;
                return response;
            }
        };
        headers.insert(CONTENT_TYPE, HeaderValue::from_static(self.media_type));
        headers.insert(CONTENT_LENGTH, HeaderValue::from(sent.end - sent.start));
        *response.status_mut() = status;
        *response.body_mut() = self.source.body(sent.start, sent.end - sent.start);
        response
    }

    /// Checks whether the client already has this version.
    fn is_known(&self, request: &HeaderMap, etag: Option<&ETag>) -> bool {
        if let Some(tags) = request.typed_get::<IfNoneMatch>() {
            return etag.is_some_and(|etag| !tags.precondition_passes(etag));
        }
        let since = request.typed_get::<IfModifiedSince>();
        since.zip(self.modified).is_some_and(|(since, modified)| !since.is_modified(modified))
    }
}

/// Checks whether the range refers to this version: `If-Range` is absent or contains the strong tag
/// of this version.
fn range_applies(request: &HeaderMap, etag: &str) -> bool {
    request.get(IF_RANGE).is_none_or(|version| version.as_bytes() == etag.as_bytes())
}

/// Returns the range of a request, `None` for all bytes, or an error if the range contains no
/// bytes.
fn range(request: &HeaderMap, length: u64) -> Result<Option<Range<u64>>, ()> {
    use http_range_header::{RangeUnsatisfiableError, parse_range_header};
    let Some(text) = request.get(RANGE).and_then(|value| value.to_str().ok()) else { return Ok(None) };
    let found = match parse_range_header(text).and_then(|ranges| ranges.validate(length)) {
        Ok(found) => found,
        Err(RangeUnsatisfiableError::Unsatisfiable) => return Err(()),
        Err(_) => return Ok(None),
    };
    Ok(match found.as_slice() {
        [one] => Some(*one.start()..one.end() + 1),
        _ => None,
    })
}

fn set(headers: &mut HeaderMap, name: axum::http::HeaderName, text: &str) {
    if let Ok(value) = HeaderValue::from_str(text) {
        headers.insert(name, value);
    }
}

/// Returns a response with a line of text.
pub(crate) fn text(status: StatusCode, message: &str) -> Response {
    let mut response = Response::new(Body::from(format!("{message}\n")));
    *response.status_mut() = status;
    let headers = response.headers_mut();
    headers.insert(CONTENT_TYPE, HeaderValue::from_static("text/plain; charset=utf-8"));
    headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
    if status == StatusCode::SERVICE_UNAVAILABLE {
        headers.insert(RETRY_AFTER, HeaderValue::from_static("2"));
    }
    response
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn resource() -> Resource {
        let source = BytesSource::Memory((0..100).collect::<Vec<u8>>().into());
        let modified = Some(SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000));
        Resource { source, media_type: "model/obj", tag: "a-1".into(), modified }
    }

    fn status(pairs: &[(&'static str, &str)]) -> (u16, Option<String>, u64) {
        let mut request = HeaderMap::new();
        for (name, value) in pairs {
            request.append(*name, HeaderValue::from_str(value).unwrap());
        }
        let response = resource().reply(&request);
        let range = response.headers().get(CONTENT_RANGE).map(|value| value.to_str().unwrap().to_owned());
        let length = response
            .headers()
            .get(CONTENT_LENGTH)
            .map_or(0, |value| value.to_str().unwrap().parse().unwrap());
        (response.status().as_u16(), range, length)
    }

    #[test]
    fn ranges_are_those_that_were_asked_for() {
        let part = |text: &str, length| (206, Some(text.to_owned()), length);
        assert_eq!(status(&[]), (200, None, 100));
        assert_eq!(status(&[("range", "bytes=0-9")]), part("bytes 0-9/100", 10));
        assert_eq!(status(&[("range", "bytes=90-")]), part("bytes 90-99/100", 10));
        assert_eq!(status(&[("range", "bytes=-1")]), part("bytes 99-99/100", 1));
        assert_eq!(status(&[("range", "bytes=0-1000")]), part("bytes 0-99/100", 100));
        assert_eq!(status(&[("range", "bytes=-1000")]), part("bytes 0-99/100", 100));
        let none = (416, Some("bytes */100".to_owned()), 0);
        assert_eq!(status(&[("range", "bytes=100-")]), none);
        assert_eq!(status(&[("range", "bytes=-0")]), none);
        let most = u64::MAX;
        assert_eq!(status(&[("range", &format!("bytes=5-{most}"))]), part("bytes 5-99/100", 95));
        assert_eq!(status(&[("range", &format!("bytes={most}-{most}"))]), none);
        let long = format!("bytes={}", "0-1,".repeat(2000));
        for whole in ["bytes=0-1,5-6", "lines=1-2", "bytes=9-1", "bytes", "bytes=a-b", "bytes=-", &long] {
            assert_eq!(status(&[("range", whole)]), (200, None, 100), "{whole}");
        }
    }

    #[test]
    fn an_empty_file_has_no_ranges() {
        let empty = Resource { source: BytesSource::Memory(bytes::Bytes::new()), ..resource() };
        // The last bytes of nothing are nothing.
        for (range, status) in [("bytes=0-", 416), ("bytes=0-0", 416), ("bytes=-0", 416), ("bytes=-1", 200)] {
            let mut request = HeaderMap::new();
            request.insert(RANGE, HeaderValue::from_static(range));
            let response = empty.reply(&request);
            assert_eq!(response.status().as_u16(), status, "{range}");
            assert_eq!(response.headers().contains_key(CONTENT_RANGE), status == 416, "{range}");
        }
    }

    #[test]
    fn what_may_be_compressed_varies_and_a_known_weak_tag_stays_weak() {
        let reply = |name: &'static str, value: &'static str| {
            let mut request = HeaderMap::new();
            request.insert(name, HeaderValue::from_static(value));
            let response = resource().reply(&request);
            assert_eq!(response.headers()[VARY], "accept-encoding");
            (response.status().as_u16(), response.headers()[ETAG].clone())
        };
        assert_eq!(reply("if-none-match", "\"a-1\""), (304, HeaderValue::from_static("\"a-1\"")));
        assert_eq!(reply("if-none-match", "\"b\", W/\"a-1\""), (304, HeaderValue::from_static("W/\"a-1\"")));
        assert_eq!(reply("range", "bytes=0-9").0, 206);
    }

    #[test]
    fn conditions_are_compared_with_this_version() {
        let known = (304, None, 0);
        assert_eq!(status(&[("if-none-match", "\"a-1\"")]), known);
        assert_eq!(status(&[("if-none-match", "\"b\", W/\"a-1\"")]), known);
        assert_eq!(status(&[("if-none-match", "*")]), known);
        assert_eq!(status(&[("if-none-match", "\"b\"")]).0, 200);
        let date = "Mon, 12 Jan 1970 13:46:40 GMT";
        assert_eq!(status(&[("if-modified-since", date)]), known);
        assert_eq!(status(&[("if-modified-since", "Mon, 12 Jan 1970 13:46:39 GMT")]).0, 200);
        assert_eq!(status(&[("if-modified-since", date), ("if-none-match", "\"b\"")]).0, 200);
        let part = ("range", "bytes=0-9");
        assert_eq!(status(&[part, ("if-range", "\"a-1\"")]).0, 206);
        for other in ["\"b\"", "W/\"a-1\"", "a-1", date, "Mon, 12 Jan 1970 13:46:41 GMT", "neither"] {
            assert_eq!(status(&[part, ("if-range", other)]).0, 200, "{other}");
        }
    }
}
