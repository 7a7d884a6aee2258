//! OFF: a keyword, three counts, then one line per vertex and per face.
//!
//! ```text
//! COFF                    [ST] [C] [N] OFF: texture coordinates, colour, normal of vertices
//! 4 2 0                   vertices, faces, edges (edges may be any number)
//! 0 0 0  255 0 0 255      position, [normal], [colour], [texture coordinate]
//! …
//! 3 0 1 2                 corner count, corners, [colour]
//! ```
//!
//! Comments start with `#`. Files with four or n dimensions and binary files are rejected.
//!
//! # References
//! *Geomview Manual*, 1.9, section *OFF Files*.
//!
//! # Complexity
//! One pass; memory for the file's bytes and the arrays of the result.

use tristrip::MAX_COUNT;
use tristrip::text::counted;
use tristrip::{Attribute, AttributeData, Mesh};

use crate::error::Error;
use crate::model::{Model, Part};
use crate::polygons::Polygons;
use crate::text::{Text, integer, quote};

/// The values after each position in a vertex line.
#[derive(Debug, Default, Clone, Copy)]
struct VertexFields {
    normals: bool,
    colours: bool,
    texcoords: bool,
}

/// Reads an OFF file.
pub(crate) fn read(bytes: &[u8]) -> Result<Model, Error> {
    let mut text = Text::new(bytes).with_comments();
    let (fields, first_count) = read_keyword(&mut text)?;
    let vertex_count = match first_count {
        Some(word) => parse_count(&text, word, "vertices")?,
        None => read_count(&mut text, "vertices")?,
    };
    let face_count = read_count(&mut text, "faces")?;
    // The number of edges may be missing.
    if let Some(word) = text.word() {
        parse_count(&text, word, "edges")?;
    }
    if let Some(word) = text.word() {
        return Err(Error::format(text.position(), quote(word), "the end of the line after three counts"));
    }
    check_capacity(&text, vertex_count, 3, "vertex")?;
    let mut reader =
        OffReader { text, fields, vertex_count, arrays: VertexArrays::default(), notes: Vec::new() };
    reader.read_vertices()?;
    check_capacity(&reader.text, face_count, 1, "face")?;
    let polygons = reader.read_faces(face_count)?;
    let OffReader { mut text, arrays, notes, .. } = reader;
    if let Some(word) = text.word_on_any_line() {
        return Err(Error::format(
            text.position(),
            quote(word),
            "the end of the file, as its counts require",
        ));
    }
    let mut mesh = Mesh::new(arrays.positions, polygons.finish()?)?;
    if fields.normals {
        mesh = mesh.with_attribute(attribute("NORMAL", 3, AttributeData::F32(arrays.normals)))?;
    }
    if fields.colours && !arrays.colours.is_empty() {
        let data = colour_data(arrays.colours, arrays.fractional_colours);
        mesh = mesh.with_attribute(attribute("COLOR_0", 4, data))?;
    }
    if fields.texcoords {
        mesh = mesh.with_attribute(attribute("TEXCOORD_0", 2, AttributeData::F32(arrays.texcoords)))?;
    }
    Ok(Model { parts: vec![Part { mesh, ..Part::default() }], notes, ..Model::default() })
}

fn attribute(name: &str, components: u8, data: AttributeData) -> Attribute {
    let normalized = matches!(data, AttributeData::U8(_));
    Attribute { name: name.to_owned(), components, normalized, data }
}

/// Returns colours as bytes if all are integers from 0 to 255 and one is larger than 1, else as
/// fractions.
#[allow(clippy::cast_sign_loss, reason = "the values are checked to be 0 to 255")]
fn colour_data(values: Vec<f32>, fractional: bool) -> AttributeData {
    let bytes = !fractional
        && values.iter().any(|&value| value > 1.0)
        && values.iter().all(|&value| (0.0..=255.0).contains(&value));
    if bytes {
        AttributeData::U8(values.into_iter().map(|value| value as u8).collect())
    } else {
        AttributeData::F32(values)
    }
}

/// Reads the keyword. A file may start with its counts instead.
fn read_keyword<'a>(text: &mut Text<'a>) -> Result<(VertexFields, Option<&'a [u8]>), Error> {
    let expected = "`OFF`, with `ST`, `C` or `N` before it";
    let word = text.word_on_any_line().ok_or_else(|| text.missing(expected))?;
    if integer(word).is_some() {
        return Ok((VertexFields::default(), Some(word)));
    }
    let wrong = || Error::format(text.position(), quote(word), expected);
    let mut left = word.strip_suffix(b"OFF").ok_or_else(wrong)?;
    let mut has = |prefix: &[u8]| {
        let rest = left.strip_prefix(prefix);
        left = rest.unwrap_or(left);
        rest.is_some()
    };
    let fields = VertexFields { texcoords: has(b"ST"), colours: has(b"C"), normals: has(b"N") };
    if has(b"4") || has(b"n") {
        let expected = "three-dimensional positions";
        return Err(Error::format(text.position(), quote(word), expected));
    }
    if !left.is_empty() {
        return Err(wrong());
    }
    match text.word() {
        Some(b"BINARY") => {
            Err(Error::format(text.position(), "`BINARY`", "a text file: binary OFF is not supported"))
        }
        word => Ok((fields, word)),
    }
}

fn read_count(text: &mut Text, what: &str) -> Result<u64, Error> {
    match text.word_on_any_line() {
        Some(word) => parse_count(text, word, what),
        None => Err(text.missing(&format!("the number of {what}"))),
    }
}

fn parse_count(text: &Text, word: &[u8], what: &str) -> Result<u64, Error> {
    integer(word)
        .and_then(|count| u64::try_from(count).ok())
        .ok_or_else(|| Error::format(text.position(), quote(word), format!("the number of {what}")))
}

/// Checks that the remaining bytes can contain `count` items before memory is allocated for them.
fn check_capacity(text: &Text, count: u64, words: u64, noun: &str) -> Result<(), Error> {
    let most = text.words_left() as u64 / words;
    if count > most {
        let expected = format!("at most {most} in the remaining {}", counted(text.bytes_left(), "byte"));
        return Err(Error::format(text.position(), counted(count, noun), expected));
    }
    if count > MAX_COUNT as u64 {
        return Err(Error::LimitExceeded { at: text.position(), found: count, limit: MAX_COUNT as u64 });
    }
    Ok(())
}

#[derive(Debug, Default)]
struct VertexArrays {
    positions: Vec<[f32; 3]>,
    normals: Vec<f32>,
    colours: Vec<f32>,
    texcoords: Vec<f32>,
    /// Whether a colour value was written with a decimal point or an exponent.
    fractional_colours: bool,
}

struct OffReader<'a> {
    text: Text<'a>,
    fields: VertexFields,
    vertex_count: u64,
    arrays: VertexArrays,
    notes: Vec<String>,
}

impl OffReader<'_> {
    fn read_vertices(&mut self) -> Result<(), Error> {
        let mut extra = 0u64;
        self.arrays.positions.reserve_exact(self.vertex_count as usize);
        for _ in 0..self.vertex_count {
            self.next_row("a vertex")?;
            let text = &mut self.text;
            let position = [text.number("x")?, text.number("y")?, text.number("z")?];
            self.arrays.positions.push(position);
            if self.fields.normals {
                for axis in ["the normal's x", "the normal's y", "the normal's z"] {
                    self.arrays.normals.push(text.number(axis)?);
                }
            }
            let mut rest = Vec::new();
            while let Some(word) = text.word() {
                let value = text.parse_number(word, "a colour or texture coordinate")?;
                let is_colour = self.fields.colours && rest.len() < 4;
                self.arrays.fractional_colours |= is_colour && integer(word).is_none();
                // Values beyond the longest possible row are only counted.
                if rest.len() < 6 {
                    rest.push(value);
                } else {
                    extra += 1;
                }
            }
            let mut left = &rest[..];
            if self.fields.texcoords {
                let Some((start, texcoord)) = left.split_last_chunk::<2>() else {
                    return Err(text.missing("a texture coordinate"));
                };
                self.arrays.texcoords.extend(texcoord);
                left = start;
            }
            if self.fields.colours {
                let opaque = if self.arrays.fractional_colours || left.iter().all(|&x| x <= 1.0) {
                    1.0
                } else {
                    255.0
                };
                let colour = match *left {
                    [r, g, b] => [r, g, b, opaque],
                    [r, g, b, a, ..] => [r, g, b, a],
                    _ => return Err(text.missing("a colour of three or four values")),
                };
                self.arrays.colours.extend(colour);
                left = &left[left.len().min(4)..];
            }
            extra += left.len() as u64;
        }
        if extra > 0 {
            self.notes.push(format!("additional values of vertices dropped: {extra}"));
        }
        Ok(())
    }

    fn read_faces(&mut self, face_count: u64) -> Result<Polygons, Error> {
        let capacity = (3 * face_count).min(self.text.words_left() as u64);
        let mut polygons = Polygons::with_capacity(capacity as usize);
        let mut coloured = 0u64;
        for _ in 0..face_count {
            self.next_row("a face")?;
            let text = &mut self.text;
            let word = text.word().unwrap_or_default();
            let size = parse_count(text, word, "corners")?;
            check_capacity(text, size, 1, "corner")?;
            for _ in 0..size {
                let Some(word) = text.word() else { return Err(text.missing("a vertex index")) };
                match integer(word).map(u64::try_from) {
                    Some(Ok(v)) if v < self.vertex_count => polygons.push(v as u32),
                    _ => {
                        let expected = format!("a vertex index below {}", self.vertex_count);
                        return Err(Error::format(text.position(), quote(word), expected));
                    }
                }
            }
            polygons.end_face();
            coloured += u64::from(!text.rest().is_empty());
        }
        if coloured > 0 {
            self.notes.push(format!("face colours dropped: {coloured}"));
        }
        Ok(polygons)
    }

    /// Advances to the next line that is not blank.
    fn next_row(&mut self, what: &str) -> Result<(), Error> {
        self.text.next_line();
        if self.text.skip_blank_lines() { Ok(()) } else { Err(self.text.missing(what)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(text: &str) -> Mesh {
        let mut model = read(text.as_bytes()).unwrap();
        model.parts.remove(0).mesh
    }

    #[test]
    fn reads_polygons_comments_and_files_without_keyword() {
        let model = "OFF # a quad\n4 2 0\n\n0 0 0\n1 0 0 # corner\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n2 0 1\n";
        let got = read(model.as_bytes()).unwrap();
        let sizes: Vec<_> = got.parts[0].mesh.faces().iter().map(<[u32]>::len).collect();
        assert_eq!(sizes, [4, 2]);
        assert_eq!(got.notes, ["face colours dropped: 1"]);
        assert_eq!(mesh("3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2").faces().face_count(), 1);
        assert_eq!(mesh("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2").faces().face_count(), 1);
    }

    #[test]
    fn reads_values_after_the_position() {
        let got = mesh("STCNOFF\n1 0 0\n1 2 3  0 0 1  255 128 0 255  0.5 0.25\n");
        let [normal, colour, texcoord] = got.attributes() else { panic!() };
        assert_eq!(normal.data, AttributeData::F32(vec![0.0, 0.0, 1.0]));
        assert_eq!((&colour.data, colour.normalized), (&AttributeData::U8(vec![255, 128, 0, 255]), true));
        assert_eq!(texcoord.data, AttributeData::F32(vec![0.5, 0.25]));
        let got = mesh("COFF\n1 0 0\n1 2 3  1.0 0.5 0\n");
        assert_eq!(got.attributes()[0].data, AttributeData::F32(vec![1.0, 0.5, 0.0, 1.0]));
    }
}
