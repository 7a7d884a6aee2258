//! Media types by file name extension, and which of them are worth compressing.

/// The media type of unknown files.
const BYTES: &str = "application/octet-stream";

/// Extensions, their media types, and whether they are worth compressing. Text and uncompressed
/// meshes are; progressive GLB and images are already compressed.
const TYPES: [(&str, &str, bool); 27] = [
    ("html", "text/html; charset=utf-8", true),
    ("js", "text/javascript; charset=utf-8", true),
    ("mjs", "text/javascript; charset=utf-8", true),
    ("css", "text/css; charset=utf-8", true),
    ("json", "application/json", true),
    ("map", "application/json", true),
    ("svg", "image/svg+xml", true),
    ("txt", "text/plain; charset=utf-8", true),
    ("md", "text/markdown; charset=utf-8", true),
    ("wgsl", "text/plain; charset=utf-8", true),
    ("glsl", "text/plain; charset=utf-8", true),
    ("wasm", "application/wasm", true),
    ("obj", "model/obj", true),
    ("mtl", "model/mtl", true),
    ("stl", "model/stl", true),
    ("ply", "model/ply", true),
    ("off", "model/off", true),
    ("gltf", "model/gltf+json", true),
    ("glb", "model/gltf-binary", false),
    ("bin", BYTES, false),
    ("png", "image/png", false),
    ("jpg", "image/jpeg", false),
    ("jpeg", "image/jpeg", false),
    ("webp", "image/webp", false),
    ("ktx2", "image/ktx2", false),
    ("ico", "image/x-icon", false),
    ("woff2", "font/woff2", false),
];

/// Returns the media type for a file name.
pub(crate) fn media_type(name: &str) -> &'static str {
    entry(name).map_or(BYTES, |(_, media_type, _)| media_type)
}

/// Checks whether a response of this type is worth compressing.
pub(crate) fn is_compressible(media_type: &str) -> bool {
    TYPES.iter().any(|(_, known, compressed)| *compressed && *known == media_type)
}

fn entry(name: &str) -> Option<(&'static str, &'static str, bool)> {
    let (_, extension) = name.rsplit_once('.')?;
    TYPES.into_iter().find(|(known, ..)| extension.eq_ignore_ascii_case(known))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_follow_extensions() {
        assert_eq!(media_type("a/b.GLB"), "model/gltf-binary");
        assert_eq!(media_type("b.gltf"), "model/gltf+json");
        assert_eq!(media_type("Makefile"), BYTES);
        assert!(is_compressible(media_type("a.obj")) && is_compressible(media_type("index.html")));
        assert!(!is_compressible(media_type("a.glb")) && !is_compressible(media_type("a.png")));
    }
}
