//! OFF: a keyword, three counts, then vertices and faces, each on a line.
//!
//! ```text
//! COFF                    [ST] [C] [N] OFF: texture coordinates, colour and normal follow each position
//! 4 2 0                   vertices, faces, edges (edges may be any number)
//! 0 0 0  255 0 0 255      position, [normal], [colour], [texture coordinate]
//! …
//! 3 0 1 2                 number of corners, corners, [colour]
//! ```
//!
//! Comments begin with `#`. Files of four or n dimensions, and binary ones, are refused.
//!
//! # References
//! *Geomview Manual*, 1.9, section *OFF Files*.
//!
//! # Complexity
//! One pass; beside the file's bytes only the arrays of the result are held.

use tristrip::mesh::MAX_COUNT;
use tristrip::{Attribute, AttributeData, Mesh};

use crate::polygons::Polygons;
use crate::text::{Text, integer, quote};
use crate::{Error, Model, Part};

/// What stands behind each position.
#[derive(Debug, Default, Clone, Copy)]
struct Kind {
    normals: bool,
    colours: bool,
    texcoords: bool,
}

/// Reads an OFF file.
pub(crate) fn read(bytes: &[u8]) -> Result<Model, Error> {
    let mut text = Text::new(bytes).with_comments();
    let (kind, first_count) = read_keyword(&mut text)?;
    let vertex_count = match first_count {
        Some(word) => parse_count(&text, word, "vertices")?,
        None => read_count(&mut text, "vertices")?,
    };
    let face_count = read_count(&mut text, "faces")?;
    // The number of edges may be left out.
    if let Some(word) = text.word() {
        parse_count(&text, word, "edges")?;
    }
    if let Some(word) = text.word() {
        return Err(Error::format(text.place(), quote(word), "the end of the line after three counts"));
    }
    check_room(&text, vertex_count, 3, "vertices")?;
    let mut reader = Reader { text, kind, vertex_count, columns: Columns::default(), notes: Vec::new() };
    reader.read_vertices()?;
    check_room(&reader.text, face_count, 1, "faces")?;
    let polygons = reader.read_faces(face_count)?;
    let Reader { mut text, columns, notes, .. } = reader;
    if let Some(word) = text.word_below() {
        return Err(Error::format(text.place(), quote(word), "the end of the file, by its counts"));
    }
    let mut mesh = Mesh::new(columns.positions, polygons.finish()?)?;
    if kind.normals {
        mesh = mesh.with_attribute(attribute("NORMAL", 3, AttributeData::F32(columns.normals)))?;
    }
    if kind.colours && !columns.colours.is_empty() {
        let data = colour_data(columns.colours, columns.fractional_colours);
        mesh = mesh.with_attribute(attribute("COLOR_0", 4, data))?;
    }
    if kind.texcoords {
        mesh = mesh.with_attribute(attribute("TEXCOORD_0", 2, AttributeData::F32(columns.texcoords)))?;
    }
    let part = Part { name: None, material: None, mesh, stripped: false, stored: None };
    Ok(Model { parts: vec![part], notes, scene: None })
}

fn attribute(name: &str, components: u8, data: AttributeData) -> Attribute {
    let normalized = matches!(data, AttributeData::U8(_));
    Attribute { name: name.to_owned(), components, normalized, data }
}

/// Makes colours fractions, or bytes where all are integers and one is larger than 1.
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

/// Reads the keyword; a file may begin with its counts instead.
fn read_keyword<'a>(text: &mut Text<'a>) -> Result<(Kind, Option<&'a [u8]>), Error> {
    let expected = "`OFF`, with `ST`, `C` or `N` before it";
    let word = text.word_below().ok_or_else(|| text.missing(expected))?;
    if integer(word).is_some() {
        return Ok((Kind::default(), Some(word)));
    }
    let wrong = || Error::format(text.place(), quote(word), expected);
    let mut left = word.strip_suffix(b"OFF").ok_or_else(wrong)?;
    let mut has = |prefix: &[u8]| {
        let rest = left.strip_prefix(prefix);
        left = rest.unwrap_or(left);
        rest.is_some()
    };
    let kind = Kind { texcoords: has(b"ST"), colours: has(b"C"), normals: has(b"N") };
    if has(b"4") || has(b"n") {
        let expected = "positions of three dimensions";
        return Err(Error::format(text.place(), quote(word), expected));
    }
    if !left.is_empty() {
        return Err(wrong());
    }
    match text.word() {
        Some(b"BINARY") => {
            Err(Error::format(text.place(), "`BINARY`", "a text file: binary OFF is not read"))
        }
        word => Ok((kind, word)),
    }
}

fn read_count(text: &mut Text, what: &str) -> Result<u64, Error> {
    match text.word_below() {
        Some(word) => parse_count(text, word, what),
        None => Err(text.missing(&format!("the number of {what}"))),
    }
}

fn parse_count(text: &Text, word: &[u8], what: &str) -> Result<u64, Error> {
    integer(word)
        .and_then(|count| u64::try_from(count).ok())
        .ok_or_else(|| Error::format(text.place(), quote(word), format!("the number of {what}")))
}

/// Checks a count against what the bytes left can hold, before anything is allocated for it.
fn check_room(text: &Text, count: u64, words: u64, what: &str) -> Result<(), Error> {
    let most = text.words_left() as u64 / words;
    if count > most {
        let expected = format!("at most {most}, for the {} bytes left", text.bytes_left());
        return Err(Error::format(text.place(), format!("{count} {what}"), expected));
    }
    if count > MAX_COUNT as u64 {
        return Err(Error::LimitExceeded { at: text.place(), found: count, limit: MAX_COUNT as u64 });
    }
    Ok(())
}

#[derive(Debug, Default)]
struct Columns {
    positions: Vec<[f32; 3]>,
    normals: Vec<f32>,
    colours: Vec<f32>,
    texcoords: Vec<f32>,
    /// Whether a colour was written with a point or an exponent.
    fractional_colours: bool,
}

struct Reader<'a> {
    text: Text<'a>,
    kind: Kind,
    vertex_count: u64,
    columns: Columns,
    notes: Vec<String>,
}

impl Reader<'_> {
    fn read_vertices(&mut self) -> Result<(), Error> {
        let mut extra = 0u64;
        self.columns.positions.reserve_exact(self.vertex_count as usize);
        for _ in 0..self.vertex_count {
            self.next_row("a vertex")?;
            let text = &mut self.text;
            let position = [text.number("x")?, text.number("y")?, text.number("z")?];
            self.columns.positions.push(position);
            if self.kind.normals {
                for axis in ["the normal's x", "the normal's y", "the normal's z"] {
                    self.columns.normals.push(text.number(axis)?);
                }
            }
            let mut rest = Vec::new();
            while let Some(word) = text.word() {
                let value = text.parse_number(word, "a colour or texture coordinate")?;
                let is_colour = self.kind.colours && rest.len() < 4;
                self.columns.fractional_colours |= is_colour && integer(word).is_none();
                // More than the longest row has, they are only counted.
                if rest.len() < 6 {
                    rest.push(value);
                } else {
                    extra += 1;
                }
            }
            let mut left = &rest[..];
            if self.kind.texcoords {
                let Some((start, texcoord)) = left.split_last_chunk::<2>() else {
                    return Err(text.missing("a texture coordinate"));
                };
                self.columns.texcoords.extend(texcoord);
                left = start;
            }
            if self.kind.colours {
                let opaque = if self.columns.fractional_colours || left.iter().all(|&x| x <= 1.0) {
                    1.0
                } else {
                    255.0
                };
                let colour = match *left {
                    [r, g, b] => [r, g, b, opaque],
                    [r, g, b, a, ..] => [r, g, b, a],
                    _ => return Err(text.missing("a colour of three or four values")),
                };
                self.columns.colours.extend(colour);
                left = &left[left.len().min(4)..];
            }
            extra += left.len() as u64;
        }
        if extra > 0 {
            self.notes.push(format!("further values of vertices dropped: {extra}"));
        }
        Ok(())
    }

    fn read_faces(&mut self, face_count: u64) -> Result<Polygons, Error> {
        let room = (3 * face_count).min(self.text.words_left() as u64);
        let mut polygons = Polygons::with_capacity(room as usize);
        let mut coloured = 0u64;
        for _ in 0..face_count {
            self.next_row("a face")?;
            let text = &mut self.text;
            let word = text.word().unwrap_or_default();
            let size = parse_count(text, word, "corners")?;
            check_room(text, size, 1, "corners")?;
            for _ in 0..size {
                let Some(word) = text.word() else { return Err(text.missing("a vertex index")) };
                match integer(word).map(u64::try_from) {
                    Some(Ok(v)) if v < self.vertex_count => polygons.push(v as u32),
                    _ => {
                        let expected = format!("a vertex index from 0, less than {}", self.vertex_count);
                        return Err(Error::format(text.place(), quote(word), expected));
                    }
                }
            }
            polygons.end_face();
            coloured += u64::from(!text.rest().is_empty());
        }
        if coloured > 0 {
            self.notes.push(format!("faces whose colours are dropped: {coloured}"));
        }
        Ok(polygons)
    }

    /// Goes to the next line that is not blank.
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
    fn polygons_comments_and_missing_keyword() {
        let model = "OFF # a quad\n4 2 0\n\n0 0 0\n1 0 0 # corner\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n2 0 1\n";
        let got = read(model.as_bytes()).unwrap();
        let sizes: Vec<_> = got.parts[0].mesh.faces().iter().map(<[u32]>::len).collect();
        assert_eq!(sizes, [4, 2]);
        assert_eq!(got.notes, ["faces whose colours are dropped: 1"]);
        assert_eq!(mesh("3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2").faces().face_count(), 1);
        assert_eq!(mesh("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2").faces().face_count(), 1);
    }

    #[test]
    fn values_behind_the_position() {
        let got = mesh("STCNOFF\n1 0 0\n1 2 3  0 0 1  255 128 0 255  0.5 0.25\n");
        let [normal, colour, texcoord] = got.attributes() else { panic!() };
        assert_eq!(normal.data, AttributeData::F32(vec![0.0, 0.0, 1.0]));
        assert_eq!((&colour.data, colour.normalized), (&AttributeData::U8(vec![255, 128, 0, 255]), true));
        assert_eq!(texcoord.data, AttributeData::F32(vec![0.5, 0.25]));
        let got = mesh("COFF\n1 0 0\n1 2 3  1.0 0.5 0\n");
        assert_eq!(got.attributes()[0].data, AttributeData::F32(vec![1.0, 0.5, 0.0, 1.0]));
    }
}
