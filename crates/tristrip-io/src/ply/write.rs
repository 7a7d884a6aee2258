//! Writes little-endian binary PLY: the vertices of all parts, the faces, and strips as `tristrips`
//! rows.

use std::fmt::Write;

use tristrip::{Attribute, AttributeData, Error as MeshError, Layout};

use crate::error::Error;
use crate::join::{self, clean};
use crate::le_bytes::{append, fill_rows};
use crate::model::{Drawing, Model};

/// The restart index −1 of `tristrips` as an unsigned number.
const RESTART: u32 = u32::MAX;

/// Writes a PLY file.
pub(crate) fn write(model: &Model, drawings: &[Drawing], layout: Layout) -> Result<Vec<u8>, Error> {
    model.check_drawings(drawings)?;
    let blocks = join::blocks(model)?;
    if blocks.vertex_count > i32::MAX as usize {
        let (what, found) = ("vertices of a PLY file", blocks.vertex_count as u64);
        return Err(MeshError::LimitExceeded { what, found, limit: i32::MAX as u64 }.into());
    }
    let (columns, _) = columns(model);
    let rows = IndexRows::new(drawings, model, layout, &blocks.bases)?;

    // 1. The header.
    let mut header = String::from("ply\nformat binary_little_endian 1.0\n");
    for loss in losses(model) {
        line(&mut header, format_args!("comment {loss}"));
    }
    line(&mut header, format_args!("element vertex {}", blocks.vertex_count));
    for axis in ["x", "y", "z"] {
        line(&mut header, format_args!("property float {axis}"));
    }
    for column in &columns {
        for name in &column.names {
            line(&mut header, format_args!("property {} {name}", column.kind()));
        }
    }
    let count_type = if rows.largest_face > usize::from(u8::MAX) { "uint" } else { "uchar" };
    if rows.face_count > 0 || rows.strips.is_empty() {
        line(&mut header, format_args!("element face {}", rows.face_count));
        line(&mut header, format_args!("property list {count_type} int vertex_indices"));
    }
    if !rows.strips.is_empty() {
        line(&mut header, format_args!("element tristrips {}", rows.strips.len()));
        line(&mut header, format_args!("property list int int vertex_indices"));
    }
    header.push_str("end_header\n");

    // 2. The vertices.
    let mut out = header.into_bytes();
    let row: usize = 12 + columns.iter().map(WrittenAttribute::bytes).sum::<usize>();
    for &part in &blocks.parts {
        let mesh = &model.parts[part].mesh;
        let start = out.len();
        out.resize(start + row * mesh.vertex_count(), 0);
        let rows = &mut out[start..];
        fill_rows(rows, row, 0, mesh.positions().as_flattened(), 3, f32::to_le_bytes);
        let mut offset = 12;
        for column in &columns {
            if let Some(attribute) = column.find(mesh.attributes()) {
                column.fill(attribute, rows, row, offset);
            }
            offset += column.bytes();
        }
    }

    // 3. The faces.
    out.reserve(rows.face_count * (1 + 3 * size_of::<u32>()));
    rows.for_each_face(drawings, model, |face, base| {
        if count_type == "uint" {
            out.extend_from_slice(&(face.len() as u32).to_le_bytes());
        } else {
            out.push(face.len() as u8);
        }
        for v in face {
            out.extend_from_slice(&(v + base).to_le_bytes());
        }
    });

    // 4. The strips.
    for strip in &rows.strips {
        out.extend_from_slice(&(strip.len() as u32).to_le_bytes());
        append(&mut out, strip, u32::to_le_bytes);
    }
    Ok(out)
}

/// Lists the data of a model that PLY cannot represent.
pub(crate) fn losses(model: &Model) -> Vec<String> {
    let mut out = Vec::new();
    if model.parts.len() > 1 {
        out.push(format!("parts joined into one: {}", model.parts.len()));
    }
    let materials = model.parts.iter().filter(|part| part.material.is_some()).count();
    if materials > 0 {
        out.push(format!("material names not written: {materials}"));
    }
    out.extend(columns(model).1);
    out.extend(join::scene_losses(model));
    out
}

/// The rows after the vertices.
struct IndexRows {
    /// Rows of `tristrips`, with [`RESTART`] between strips.
    strips: Vec<Vec<u32>>,
    face_count: usize,
    largest_face: usize,
    bases: Vec<u32>,
}

impl IndexRows {
    fn new(drawings: &[Drawing], model: &Model, layout: Layout, bases: &[u32]) -> Result<Self, Error> {
        let mut rows = Self { strips: Vec::new(), face_count: 0, largest_face: 0, bases: bases.to_vec() };
        for (drawing, &base) in drawings.iter().zip(bases) {
            let Drawing::Strips(strips) = drawing else { continue };
            if strips.is_empty() {
                continue;
            }
            let shift = |v: u32| if v == RESTART { v } else { v + base };
            match layout {
                Layout::List => {}
                Layout::Restart => {
                    let row = strips.to_restart(RESTART).into_iter().map(shift);
                    // The strips of all parts form one row, as in other software.
                    match rows.strips.first_mut() {
                        Some(first) => {
                            first.push(RESTART);
                            first.extend(row);
                        }
                        None => rows.strips.push(row.collect()),
                    }
                }
                Layout::Degenerate => {
                    rows.strips.push(strips.to_degenerate().into_iter().map(shift).collect());
                }
                Layout::Separate => {
                    rows.strips.extend(strips.iter().map(|strip| strip.iter().copied().map(shift).collect()));
                }
            }
        }
        if let Some(row) = rows.strips.iter().find(|row| row.len() > i32::MAX as usize) {
            let (what, found) = ("vertices of a strip row", row.len() as u64);
            return Err(MeshError::LimitExceeded { what, found, limit: i32::MAX as u64 }.into());
        }
        let as_list = layout == Layout::List;
        for (part, drawing) in model.parts.iter().zip(drawings) {
            match drawing {
                Drawing::Faces => {
                    let faces = part.mesh.faces();
                    rows.face_count += faces.face_count();
                    let largest = if faces.as_triangles().is_some() {
                        3
                    } else {
                        faces.iter().map(<[u32]>::len).max().unwrap_or(0)
                    };
                    rows.largest_face = rows.largest_face.max(largest);
                }
                Drawing::Strips(strips) if as_list => rows.face_count += strips.triangles().count(),
                Drawing::Strips(_) => {}
            }
        }
        Ok(rows)
    }

    /// Calls `face` with the corners of each face and the index of its part's first vertex.
    fn for_each_face(&self, drawings: &[Drawing], model: &Model, mut face: impl FnMut(&[u32], u32)) {
        if self.face_count == 0 {
            return;
        }
        let as_list = self.strips.is_empty();
        for ((part, drawing), &base) in model.parts.iter().zip(drawings).zip(&self.bases) {
            match drawing {
                Drawing::Faces => part.mesh.faces().iter().for_each(|corners| face(corners, base)),
                Drawing::Strips(strips) if as_list => strips.triangles().for_each(|t| face(&t, base)),
                Drawing::Strips(_) => {}
            }
        }
    }
}

/// A written attribute, and the names of its properties.
struct WrittenAttribute {
    name: String,
    names: Vec<String>,
    like: Attribute,
}

impl WrittenAttribute {
    /// Checks whether the values are written as floats. Normalized integers other than colours are,
    /// because PLY has no type for them.
    fn as_floats(attribute: &Attribute) -> bool {
        let colour =
            is_colour(attribute) && matches!(attribute.data, AttributeData::U8(_) | AttributeData::U16(_));
        matches!(attribute.data, AttributeData::F32(_)) || (attribute.normalized && !colour)
    }

    fn kind(&self) -> &'static str {
        if Self::as_floats(&self.like) {
            return "float";
        }
        match self.like.data {
            AttributeData::F32(_) => "float",
            AttributeData::F64(_) => "double",
            AttributeData::U8(_) => "uchar",
            AttributeData::I8(_) => "char",
            AttributeData::U16(_) => "ushort",
            AttributeData::I16(_) => "short",
            AttributeData::U32(_) => "uint",
            AttributeData::I32(_) => "int",
        }
    }

    fn find<'a>(&self, attributes: &'a [Attribute]) -> Option<&'a Attribute> {
        attributes.iter().find(|attribute| alike(attribute, &self.like))
    }

    /// Returns the number of bytes per vertex.
    fn bytes(&self) -> usize {
        let each = match self.kind() {
            "char" | "uchar" => 1,
            "short" | "ushort" => 2,
            "double" => 8,
            _ => 4,
        };
        each * self.names.len()
    }

    /// Writes the values of all vertices into rows of `stride` bytes.
    fn fill(&self, attribute: &Attribute, rows: &mut [u8], stride: usize, offset: usize) {
        let n = self.names.len();
        if Self::as_floats(attribute) && !matches!(attribute.data, AttributeData::F32(_)) {
            let floats: Vec<f32> = (0..attribute.data.len()).filter_map(|i| attribute.float(i)).collect();
            return fill_rows(rows, stride, offset, &floats, n, f32::to_le_bytes);
        }
        match &attribute.data {
            AttributeData::F32(v) => fill_rows(rows, stride, offset, v, n, f32::to_le_bytes),
            AttributeData::F64(v) => fill_rows(rows, stride, offset, v, n, f64::to_le_bytes),
            AttributeData::U8(v) => fill_rows(rows, stride, offset, v, n, u8::to_le_bytes),
            AttributeData::I8(v) => fill_rows(rows, stride, offset, v, n, i8::to_le_bytes),
            AttributeData::U16(v) => fill_rows(rows, stride, offset, v, n, u16::to_le_bytes),
            AttributeData::I16(v) => fill_rows(rows, stride, offset, v, n, i16::to_le_bytes),
            AttributeData::U32(v) => fill_rows(rows, stride, offset, v, n, u32::to_le_bytes),
            AttributeData::I32(v) => fill_rows(rows, stride, offset, v, n, i32::to_le_bytes),
        }
    }
}

fn is_colour(attribute: &Attribute) -> bool {
    attribute.name == "COLOR_0" && matches!(attribute.components, 3 | 4)
}

fn alike(a: &Attribute, b: &Attribute) -> bool {
    let shape = |a: &Attribute| (a.components, a.normalized, std::mem::discriminant(&a.data));
    a.name == b.name && shape(a) == shape(b)
}

/// Returns the attributes that every part has, and notes on the others.
fn columns(model: &Model) -> (Vec<WrittenAttribute>, Vec<String>) {
    let mut columns: Vec<WrittenAttribute> = Vec::new();
    let mut left_out: Vec<String> = Vec::new();
    let mut taken: Vec<String> = ["x", "y", "z"].map(str::to_owned).to_vec();
    for attribute in model.parts.iter().flat_map(|part| part.mesh.attributes()) {
        let known = columns.iter().any(|column| column.name == attribute.name);
        let loss = format!("attribute {} not written: some parts lack it", clean(&attribute.name));
        if known || left_out.contains(&loss) {
            continue;
        }
        if !model.parts.iter().all(|part| part.mesh.attributes().iter().any(|a| alike(a, attribute))) {
            left_out.push(loss);
            continue;
        }
        let names = property_names(attribute, &mut taken);
        let like = Attribute {
            data: match &attribute.data {
                AttributeData::F32(_) => AttributeData::F32(Vec::new()),
                AttributeData::F64(_) => AttributeData::F64(Vec::new()),
                AttributeData::U8(_) => AttributeData::U8(Vec::new()),
                AttributeData::I8(_) => AttributeData::I8(Vec::new()),
                AttributeData::U16(_) => AttributeData::U16(Vec::new()),
                AttributeData::I16(_) => AttributeData::I16(Vec::new()),
                AttributeData::U32(_) => AttributeData::U32(Vec::new()),
                AttributeData::I32(_) => AttributeData::I32(Vec::new()),
            },
            name: attribute.name.clone(),
            ..*attribute
        };
        columns.push(WrittenAttribute { name: attribute.name.clone(), names, like });
    }
    (columns, left_out)
}

/// Returns the property names of an attribute: the usual PLY names if there are any, else the
/// attribute's name with numbers.
fn property_names(attribute: &Attribute, taken: &mut Vec<String>) -> Vec<String> {
    let wanted: Vec<String> = match (attribute.name.as_str(), attribute.components) {
        ("NORMAL", 3) => ["nx", "ny", "nz"].map(str::to_owned).to_vec(),
        ("TEXCOORD_0", 2) => ["s", "t"].map(str::to_owned).to_vec(),
        ("COLOR_0", n @ (3 | 4)) => {
            ["red", "green", "blue", "alpha"].iter().take(n.into()).map(|&name| name.to_owned()).collect()
        }
        (name, n) => {
            let name: String = clean(name).split_whitespace().collect::<Vec<_>>().join("_");
            let name = if name.is_empty() { "attribute".to_owned() } else { name };
            if n <= 1 { vec![name] } else { (0..n).map(|i| format!("{name}_{i}")).collect() }
        }
    };
    let mut names = Vec::new();
    for mut name in wanted {
        while taken.contains(&name) {
            name.push('_');
        }
        taken.push(name.clone());
        names.push(name);
    }
    names
}

fn line(header: &mut String, text: std::fmt::Arguments) {
    // Writing to a string cannot fail.
    let _ = writeln!(header, "{text}");
}
