//! The format of a file, detected from its extension or its first bytes.

use std::path::Path;

use crate::stl;

/// A mesh file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// The Stanford polygon file format.
    Ply,
    /// The object file format of `Geomview`.
    Off,
    /// Stereolithography, as text or binary.
    Stl,
    /// glTF 2.0 as JSON.
    Gltf,
    /// glTF 2.0 in its binary container.
    Glb,
}

impl Format {
    /// All formats, in display order.
    pub const ALL: [Self; 6] = [Self::Obj, Self::Ply, Self::Off, Self::Stl, Self::Gltf, Self::Glb];

    /// Returns the file name extension without the dot.
    ///
    /// ```
    /// use tristrip_io::Format;
    /// let file_names = Format::ALL.map(|format| format!("bunny.{}", format.extension()));
    /// assert_eq!(file_names[5], "bunny.glb");
    /// assert_eq!(file_names.map(Format::from_path), Format::ALL.map(Some));
    /// ```
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Off => "off",
            Self::Stl => "stl",
            Self::Gltf => "gltf",
            Self::Glb => "glb",
        }
    }

    /// Returns the usual name.
    ///
    /// ```
    /// use tristrip_io::Format;
    /// assert_eq!(Format::ALL.map(Format::name).join(", "), "OBJ, PLY, OFF, STL, glTF, GLB");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Off => "OFF",
            Self::Stl => "STL",
            Self::Gltf => "glTF",
            Self::Glb => "GLB",
        }
    }

    /// Returns the format for a file name's extension, ignoring case.
    ///
    /// ```
    /// use tristrip_io::Format;
    /// assert_eq!(Format::from_path("models/Bunny.PLY"), Some(Format::Ply));
    /// assert_eq!(Format::from_path("bunny"), None);
    /// ```
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        let extension = path.as_ref().extension()?;
        Self::ALL.into_iter().find(|format| extension.eq_ignore_ascii_case(format.extension()))
    }

    /// Detects the format from the file's content. Content without a known signature is treated as
    /// OBJ.
    ///
    /// ```
    /// use tristrip_io::Format;
    /// assert_eq!(Format::from_bytes(b"ply\nformat ascii 1.0\n"), Format::Ply);
    /// assert_eq!(Format::from_bytes(b"v 0 0 0\n"), Format::Obj);
    /// ```
    pub fn from_bytes(bytes: &[u8]) -> Self {
        if bytes.starts_with(b"glTF") {
            return Self::Glb;
        }
        if bytes.starts_with(b"ply") && bytes.get(3).is_none_or(u8::is_ascii_whitespace) {
            return Self::Ply;
        }
        if stl::has_binary_size(bytes) {
            return Self::Stl;
        }
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
        if text.first() == Some(&b'{') {
            return Self::Gltf;
        }
        let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        match &text[..end] {
            word if word.eq_ignore_ascii_case(b"solid") => Self::Stl,
            word if word.len() <= 8 && word.ends_with(b"OFF") => Self::Off,
            _ => Self::Obj,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detects_the_format_by_content() {
        let mut binary_stl = b"solid but binary".to_vec();
        binary_stl.resize(84, 0);
        let cases: [(&[u8], Format); 9] = [
            (b"glTF\x02\0\0\0", Format::Glb),
            (b"ply\r\nformat", Format::Ply),
            (b"plywood 1", Format::Obj),
            (&binary_stl, Format::Stl),
            (b"solid cube\n", Format::Stl),
            (b"\xef\xbb\xbf {\"asset\"", Format::Gltf),
            (b"STCN4OFF BINARY\n", Format::Off),
            (b"# comment\nv 0 0 0", Format::Obj),
            (b"", Format::Obj),
        ];
        for (bytes, format) in cases {
            assert_eq!(Format::from_bytes(bytes), format, "{:?}", String::from_utf8_lossy(bytes));
        }
    }

    #[test]
    fn detects_the_format_by_extension() {
        for format in Format::ALL {
            assert_eq!(Format::from_path(format!("a.b.{}", format.extension())), Some(format));
        }
    }
}
