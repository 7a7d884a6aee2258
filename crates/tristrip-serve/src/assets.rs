//! The viewer: the files of the directory `dist`, embedded in the binary. Each file is compressed
//! once, at its first request.

use std::collections::HashMap;
use std::io::Write;
use std::sync::{Arc, Mutex, PoisonError};

use axum::http::header::{ACCEPT_ENCODING, CONTENT_ENCODING};
use axum::http::{HeaderMap, HeaderValue};
use axum::response::Response;
use bytes::Bytes;
use flate2::Compression;
use flate2::write::GzEncoder;
use rust_embed::RustEmbed;

use crate::bytes_source::BytesSource;
use crate::media::{is_compressible, media_type};
use crate::replies::Resource;

/// The files that the browser loads. `npm run build` in `web` builds them from the sources.
#[derive(RustEmbed)]
#[folder = "$CARGO_MANIFEST_DIR/dist"]
struct Files;

/// Smaller files are sent uncompressed.
const FEWEST_BYTES: usize = 1024;

/// The content encoding of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Encoding {
    Identity,
    Gzip,
    Brotli,
}

impl Encoding {
    fn name(self) -> &'static str {
        match self {
            Self::Identity => "identity",
            Self::Gzip => "gzip",
            Self::Brotli => "br",
        }
    }

    /// Returns the best encoding that a client accepts.
    fn accepted(request: &HeaderMap) -> Self {
        let accepts = |name: &str| {
            let values = request.get_all(ACCEPT_ENCODING).iter().filter_map(|value| value.to_str().ok());
            values.flat_map(|value| value.split(',')).any(|item| {
                let mut parts = item.split(';').map(str::trim);
                let is_named = parts.next().is_some_and(|found| found.eq_ignore_ascii_case(name));
                let weight = parts
                    .find_map(|part| part.strip_prefix(['q', 'Q'])?.strip_prefix('='))
                    .map_or(1.0, |q| q.parse().unwrap_or(0.0));
                is_named && weight > 0.0
            })
        };
        if accepts("br") {
            Self::Brotli
        } else if accepts("gzip") {
            Self::Gzip
        } else {
            Self::Identity
        }
    }
}

/// The viewer's files with the compressed versions created so far.
#[derive(Debug, Default)]
pub(crate) struct Assets {
    compressed: Mutex<HashMap<(String, Encoding), Bytes>>,
}

impl Assets {
    /// Answers a request for a file; returns `None` if no file has this name.
    pub(crate) async fn reply(self: &Arc<Self>, name: &str, request: &HeaderMap) -> Option<Response> {
        let file = Files::get(name)?;
        let media_type = media_type(name);
        let pays = is_compressible(media_type) && file.data.len() >= FEWEST_BYTES;
        let encoding = if pays { Encoding::accepted(request) } else { Encoding::Identity };
        let hash = u64::from_be_bytes(*file.metadata.sha256_hash().first_chunk()?);
        let (this, name) = (Arc::clone(self), name.to_owned());
        let encoded = tokio::task::spawn_blocking(move || this.encoded(&name, &file.data, encoding));
        let source = BytesSource::Memory(encoded.await.ok()?);
        let tag = format!("{hash:016x}-{}", encoding.name());
        let mut response = Resource { source, media_type, tag, modified: None }.reply(request);
        if encoding != Encoding::Identity && response.status().is_success() {
            response.headers_mut().insert(CONTENT_ENCODING, HeaderValue::from_static(encoding.name()));
        }
        Some(response)
    }

    fn encoded(&self, name: &str, bytes: &[u8], encoding: Encoding) -> Bytes {
        let key = (name.to_owned(), encoding);
        let lock = || self.compressed.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().get(&key) {
            return known.clone();
        }
        let encoded = compress(bytes, encoding).unwrap_or_else(|| bytes.to_vec());
        lock().entry(key).or_insert_with(|| encoded.into()).clone()
    }
}

/// Compresses bytes in memory. Returns `None` if an encoder fails, which does not happen in memory.
fn compress(bytes: &[u8], encoding: Encoding) -> Option<Vec<u8>> {
    match encoding {
        Encoding::Identity => Some(bytes.to_vec()),
        Encoding::Gzip => {
            let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
            encoder.write_all(bytes).ok()?;
            encoder.finish().ok()
        }
        Encoding::Brotli => {
            // Quality 9: 11 takes ten times as long for a few percent.
            let params =
                brotli::enc::BrotliEncoderParams { quality: 9, size_hint: bytes.len(), ..Default::default() };
            let mut out = Vec::new();
            brotli::BrotliCompress(&mut &*bytes, &mut out, &params).ok()?;
            Some(out)
        }
    }
}

/// Returns whether the viewer has a file of this name.
pub(crate) fn has(name: &str) -> bool {
    Files::get(name).is_some()
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    #[test]
    fn the_best_encoding_is_chosen() {
        let chosen = |text: &'static str| {
            let mut request = HeaderMap::new();
            request.insert(ACCEPT_ENCODING, HeaderValue::from_static(text));
            Encoding::accepted(&request)
        };
        assert_eq!(chosen("gzip, deflate, br"), Encoding::Brotli);
        assert_eq!(chosen("br;q=0, GZIP;q=0.5"), Encoding::Gzip);
        assert_eq!(chosen("identity, gzip; q=0, br; Q=0"), Encoding::Identity);
        assert_eq!(chosen("br;q=NaN, gzip;q=-1"), Encoding::Identity);
        assert_eq!(Encoding::accepted(&HeaderMap::new()), Encoding::Identity);
    }

    #[test]
    fn only_the_viewer_is_in_the_binary() {
        let mut names: Vec<_> = Files::iter().collect();
        names.sort();
        assert_eq!(names, ["index.html", "style.css", "viewer.js", "worker.js"]);
        assert!(!has("package.json"));
    }

    #[test]
    fn compressed_bytes_are_those_of_the_file() {
        let bytes = b"let x = 1;\n".repeat(500);
        let gzip = compress(&bytes, Encoding::Gzip).unwrap();
        let mut again = Vec::new();
        flate2::read::GzDecoder::new(&gzip[..]).read_to_end(&mut again).unwrap();
        assert_eq!(again, bytes);
        let small = compress(&bytes, Encoding::Brotli).unwrap();
        let mut again = Vec::new();
        brotli::BrotliDecompress(&mut &small[..], &mut again).unwrap();
        assert_eq!(again, bytes);
    }
}
