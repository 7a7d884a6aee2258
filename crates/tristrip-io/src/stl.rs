//! STL: a list of triangles with three positions each. Equal positions are welded into one vertex.
//!
//! ```text
//! text    solid name                       binary   80 bytes  any text
//!           facet normal x y z                       4 bytes  number of triangles
//!             outer loop                            50 bytes  each: normal, positions (12 floats),
//!               vertex x y z     (three)                      2 bytes, sometimes a colour
//!             endloop
//!           endfacet
//!         endsolid name
//! ```
//!
//! A binary file may also begin with `solid`, so the file size determines whether a file is binary.
//! Vertices are in order of first use; −0 equals 0. Normals are dropped, because they follow from
//! the positions. Several solids of a text file become one mesh.
//!
//! # References
//! 3D Systems: *`StereoLithography` Interface Specification*, 1989.
//!
//! # Complexity
//! One pass with a hash table of the positions: 16 bytes per vertex in addition to the arrays of
//! the result.

use std::collections::HashMap;

use tristrip::text::counted;
use tristrip::{Faces, Mesh};

use crate::error::Error;
use crate::model::{Model, Part};
use crate::text::{Text, quote};

const HEADER_BYTES: usize = 84;
const FACET_BYTES: usize = 50;

/// Checks whether the file size matches the triangle count of a binary file.
pub(crate) fn has_binary_size(bytes: &[u8]) -> bool {
    facet_count(bytes).is_some_and(|count| binary_bytes(count) == bytes.len() as u64)
}

fn facet_count(bytes: &[u8]) -> Option<u32> {
    let count = bytes.get(HEADER_BYTES - 4..HEADER_BYTES)?;
    Some(u32::from_le_bytes(count.try_into().ok()?))
}

fn binary_bytes(facet_count: u32) -> u64 {
    HEADER_BYTES as u64 + FACET_BYTES as u64 * u64::from(facet_count)
}

/// Reads an STL file.
pub(crate) fn read(bytes: &[u8]) -> Result<Model, Error> {
    if has_binary_size(bytes) {
        return read_binary(bytes);
    }
    let mut text = Text::new(bytes);
    let is_text = text.word_on_any_line().is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    if is_text { read_text(bytes) } else { read_binary(bytes) }
}

/// Welds equal positions in order of first use.
#[derive(Debug, Default)]
struct Welder {
    /// The random seed protects against files with colliding positions; the result does not depend
    /// on it.
    ids: HashMap<[u32; 3], u32>,
    positions: Vec<[f32; 3]>,
    corners: Vec<u32>,
}

impl Welder {
    fn push(&mut self, position: [f32; 3]) {
        // Adding 0 turns −0 into 0.
        let bits = position.map(|x| (x + 0.0).to_bits());
        let id = *self.ids.entry(bits).or_insert_with(|| {
            self.positions.push(position);
            self.positions.len() as u32 - 1
        });
        self.corners.push(id);
    }

    fn finish(self, name: Option<String>, mut notes: Vec<String>) -> Result<Model, Error> {
        drop(self.ids);
        let facet_count = self.corners.len() / 3;
        if facet_count > 0 {
            notes.insert(0, format!("face normals dropped: {facet_count}"));
        }
        let mesh = Mesh::new(self.positions, Faces::from_triangles(self.corners)?)?;
        Ok(Model { parts: vec![Part { name, mesh, ..Part::default() }], notes, ..Model::default() })
    }
}

fn read_binary(bytes: &[u8]) -> Result<Model, Error> {
    let Some(count) = facet_count(bytes) else {
        let found = counted(bytes.len(), "byte");
        return Err(Error::format("byte 0", found, "`solid`, or a binary file of 84 bytes or more"));
    };
    let expected = binary_bytes(count);
    let size = bytes.len() as u64;
    if expected > size {
        let found = format!("{} in a file of {}", counted(count, "triangle"), counted(size, "byte"));
        return Err(Error::format("byte 80", found, format!("{expected} bytes")));
    }
    let mut notes = Vec::new();
    if expected < size {
        notes.push(format!("bytes after the last triangle ignored: {}", size - expected));
    }
    let mut welder = Welder::default();
    welder.corners.reserve_exact(3 * count as usize);
    let mut marked = 0u64;
    for (i, facet) in bytes[HEADER_BYTES..].chunks_exact(FACET_BYTES).take(count as usize).enumerate() {
        for corner in 0..3 {
            let mut position = [0.0; 3];
            for (axis, x) in position.iter_mut().enumerate() {
                let at = 12 + 12 * corner + 4 * axis;
                *x = f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]]);
                if !x.is_finite() {
                    let position = format!("byte {}", HEADER_BYTES + FACET_BYTES * i + at);
                    return Err(Error::format(position, x.to_string(), "a finite number"));
                }
            }
            welder.push(position);
        }
        marked += u64::from(facet[48..] != [0, 0]);
    }
    if marked > 0 {
        notes.push(format!("triangles whose attribute bytes were dropped: {marked}"));
    }
    welder.finish(None, notes)
}

fn read_text(bytes: &[u8]) -> Result<Model, Error> {
    let mut text = Text::new(bytes);
    let mut welder = Welder::default();
    let mut name = None;
    let mut solid_count = 0u64;
    while let Some(word) = text.word_on_any_line() {
        if !word.eq_ignore_ascii_case(b"solid") {
            return Err(Error::format(text.position(), quote(word), "`solid`"));
        }
        let rest = String::from_utf8_lossy(text.rest()).into_owned();
        if solid_count == 0 && !rest.is_empty() {
            name = Some(rest);
        }
        solid_count += 1;
        read_solid(&mut text, &mut welder)?;
    }
    let mut notes = Vec::new();
    if solid_count > 1 {
        notes.push(format!("solids merged into one mesh: {solid_count}"));
    }
    welder.finish(name, notes)
}

/// Reads facets up to `endsolid`.
fn read_solid(text: &mut Text, welder: &mut Welder) -> Result<(), Error> {
    loop {
        let expected = "`facet` or `endsolid`";
        match text.word_on_any_line() {
            Some(word) if word.eq_ignore_ascii_case(b"endsolid") => {
                text.rest();
                return Ok(());
            }
            Some(word) if word.eq_ignore_ascii_case(b"facet") => text.rest(),
            Some(word) => return Err(Error::format(text.position(), quote(word), expected)),
            None => return Err(text.missing(expected)),
        };
        expect(text, "outer")?;
        expect(text, "loop")?;
        for _ in 0..3 {
            expect(text, "vertex")?;
            welder.push([text.number("x")?, text.number("y")?, text.number("z")?]);
        }
        expect(text, "endloop")?;
        expect(text, "endfacet")?;
    }
}

fn expect(text: &mut Text, keyword: &str) -> Result<(), Error> {
    let expected = format!("`{keyword}`");
    match text.word_on_any_line() {
        Some(word) if word.eq_ignore_ascii_case(keyword.as_bytes()) => Ok(()),
        Some(word) => Err(Error::format(text.position(), quote(word), expected)),
        None => Err(text.missing(&expected)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: &str = "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
        endloop\nendfacet\nendsolid a b\nSOLID\nFACET NORMAL nan nan nan\nOUTER LOOP\nVERTEX 1 0 0\nVERTEX 1 1 0\n\
        VERTEX -0 1 0\nENDLOOP\nENDFACET\nENDSOLID\n";

    fn binary(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut out = b"solid in name only".to_vec();
        out.resize(80, b' ');
        out.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            out.extend([0; 12]);
            triangle.as_flattened().iter().for_each(|x| out.extend(x.to_le_bytes()));
            out.extend([0; 2]);
        }
        out
    }

    #[test]
    fn solids_are_welded_into_one_mesh() {
        let model = read(TWO.as_bytes()).unwrap();
        let part = &model.parts[0];
        assert_eq!(part.name.as_deref(), Some("a b"));
        assert_eq!(part.mesh.faces().as_triangles(), Some(&[0, 1, 2, 1, 3, 2][..]));
        assert_eq!(model.notes, ["face normals dropped: 2", "solids merged into one mesh: 2"]);
    }

    #[test]
    fn binary_files_may_begin_with_solid() {
        let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, -0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let bytes = binary(&[[p[0], p[1], p[2]], [p[3], p[1], p[4]]]);
        let mesh = &read(&bytes).unwrap().parts[0].mesh;
        assert_eq!(mesh.faces().as_triangles(), Some(&[0, 1, 2, 2, 1, 3][..]));
        assert_eq!(mesh.positions()[2][2].to_bits(), (-0.0f32).to_bits());
    }
}
