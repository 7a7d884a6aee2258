//! Reads rows into a mesh: vertices with attributes, faces, and the triangles of strips.

use tristrip::MAX_COUNT;
use tristrip::strip_triangles;
use tristrip::text::counted;
use tristrip::{Attribute, Mesh};

use super::columns::{VertexColumn, columns};
use super::fixed_rows::FixedRows;
use super::header::{self, Element, PlyEncoding, PlyHeader, Property, Scalar};
use super::rows::{AsciiRows, BinaryRows, Rows};
use crate::error::Error;
use crate::model::{Model, Part, StoredStrips};
use crate::polygons::Polygons;

/// The restart index of `tristrips`. No vertex has this index, because a mesh has fewer vertices.
const RESTART: u32 = u32::MAX;

/// The restart index as a signed and as an unsigned number.
const RESTARTS: [i64; 2] = [-1, RESTART as i64];

/// Reads a PLY file.
pub(crate) fn read(bytes: &[u8]) -> Result<Model, Error> {
    let header = header::read(bytes)?;
    match header.encoding {
        PlyEncoding::Ascii => {
            PlyReader::new(AsciiRows::new(&bytes[header.body..], header.body_line)).run(&header)
        }
        PlyEncoding::Little => PlyReader::new(BinaryRows::<false>::new(bytes, header.body)).run(&header),
        PlyEncoding::Big => PlyReader::new(BinaryRows::<true>::new(bytes, header.body)).run(&header),
    }
}

struct PlyReader<R> {
    rows: R,
    vertex_count: u32,
    positions: Vec<[f32; 3]>,
    attributes: Vec<Attribute>,
    polygons: Polygons,
    /// The rows of strips, if there are any.
    strips: Option<StoredStrips>,
    notes: Vec<String>,
}

impl<R: Rows> PlyReader<R> {
    fn new(rows: R) -> Self {
        Self {
            rows,
            vertex_count: 0,
            positions: Vec::new(),
            attributes: Vec::new(),
            polygons: Polygons::default(),
            strips: None,
            notes: Vec::new(),
        }
    }

    fn run(mut self, header: &PlyHeader) -> Result<Model, Error> {
        // Faces may precede the vertices, so the header provides the bound of their indices.
        let Some(vertices) = header.elements.iter().find(|element| element.name == "vertex") else {
            return Err(Error::format(
                format!("line {}", header.body_line - 1),
                "no element `vertex`",
                "one",
            ));
        };
        if vertices.row_count > MAX_COUNT as u64 {
            let (at, found) = (vertices.position(), vertices.row_count);
            return Err(Error::LimitExceeded { at, found, limit: MAX_COUNT as u64 });
        }
        self.vertex_count = vertices.row_count as u32;
        for element in &header.elements {
            let most = self.rows.rows_left(&element.properties);
            if element.row_count > most && !element.properties.is_empty() {
                let found = format!("{} of element `{}`", counted(element.row_count, "row"), element.name);
                let left = counted(self.rows.bytes_left(), "byte");
                let expected = format!("at most {most} in the remaining {left}");
                return Err(Error::format(element.position(), found, expected));
            }
            match element.name.as_str() {
                "vertex" => self.read_vertices(element)?,
                "face" => self.read_faces(element)?,
                "tristrips" => self.read_strips(element)?,
                _ => self.skip(element)?,
            }
        }
        self.rows.end()?;
        let mut mesh = Mesh::new(self.positions, self.polygons.finish()?)?;
        for attribute in self.attributes {
            mesh = mesh.with_attribute(attribute)?;
        }
        // A file with both faces and strips keeps its polygons.
        let has_faces = header.elements.iter().any(|element| element.name == "face" && element.row_count > 0);
        let stored = self.strips.filter(|_| !has_faces);
        let part = Part { name: None, material: None, mesh, stripped: stored.is_some(), stored };
        Ok(Model { parts: vec![part], notes: self.notes, ..Model::default() })
    }

    fn read_vertices(&mut self, element: &Element) -> Result<(), Error> {
        let axes = ["x", "y", "z"].map(|axis| element.find(axis));
        let [Some(x), Some(y), Some(z)] = axes else {
            return Err(Error::format(
                element.position(),
                "an element `vertex` without x, y or z",
                "all three",
            ));
        };
        if let Some(list) = [x, y, z].map(|axis| &element.properties[axis]).iter().find(|p| p.count.is_some())
        {
            let found = format!("a list for `{}`", list.name);
            return Err(Error::format(element.position(), found, "a number"));
        }
        let row_count = element.row_count as usize;
        let mut columns = columns(element, [x, y, z]);
        if let Some(rows) = self.rows.fixed_rows(&element.properties, row_count) {
            let (positions, rounded) = positions(&rows, element, [x, y, z])?;
            self.positions = positions;
            columns.iter_mut().for_each(|column| column.gather(&rows));
            self.note_vertices(rounded, columns);
            return Ok(());
        }
        for column in &mut columns {
            column.reserve(row_count);
        }
        self.positions.reserve_exact(row_count);
        let mut row = vec![0.0; element.properties.len()];
        let (mut rounded, mut list_values) = (0u64, 0u64);
        for _ in 0..row_count {
            for (i, (property, value)) in element.properties.iter().zip(&mut row).enumerate() {
                if property.count.is_some() {
                    list_values += self.skip_list(property)?;
                    continue;
                }
                *value = self.rows.value(property.value, &property.name)?;
                let is_position = i == x || i == y || i == z;
                if is_position && !(*value as f32).is_finite() {
                    let expected = format!("a finite 32-bit number for `{}`", property.name);
                    return Err(Error::format(self.rows.position(), format!("{value:?}"), expected));
                }
            }
            self.rows.end_row(element)?;
            let position = [row[x], row[y], row[z]];
            let narrow = position.map(|value| value as f32);
            rounded += u64::from(
                narrow.iter().zip(position).any(|(&x, wide)| f64::from(x).to_bits() != wide.to_bits()),
            );
            self.positions.push(narrow);
            for column in &mut columns {
                column.push(&row);
            }
        }
        for property in element.properties.iter().filter(|property| property.count.is_some()) {
            self.notes.push(format!("list property `{}` of vertices dropped", property.name));
        }
        if list_values > 0 {
            self.notes.push(format!("values in vertex lists dropped: {list_values}"));
        }
        self.note_vertices(rounded, columns);
        Ok(())
    }

    /// Stores the vertex attributes and adds notes on changed values.
    fn note_vertices(&mut self, rounded: u64, columns: Vec<VertexColumn>) {
        if rounded > 0 {
            self.notes.push(format!("vertices rounded to 32-bit floats: {rounded}"));
        }
        for column in columns {
            if column.replaced > 0 {
                let (name, n) = (&column.attribute.name, column.replaced);
                self.notes.push(format!("values of {name} that are not finite, replaced by 0: {n}"));
            }
            self.attributes.push(column.attribute);
        }
    }

    fn read_faces(&mut self, element: &Element) -> Result<(), Error> {
        let index = index_list(element)?;
        let Some(index) = index else { return Ok(()) };
        // Capacity for triangles. The remaining bytes limit what a wrong count can allocate.
        let most = self.rows.values_left(element.properties[index].value);
        let capacity = (3 * element.row_count).min(most) as usize;
        if self.polygons.face_count() == 0 {
            self.polygons = Polygons::with_capacity(capacity);
        }
        let mut row = 0;
        while row < element.row_count {
            if let [list] = &element.properties[..] {
                let most = element.row_count - row;
                row += self.rows.push_triangles(list, most, self.vertex_count, &mut self.polygons);
                if row == element.row_count {
                    break;
                }
            }
            for (i, property) in element.properties.iter().enumerate() {
                if i == index {
                    let count = self.list_count(property)?;
                    let (bound, out) = (self.vertex_count, &mut self.polygons);
                    if !self.rows.push_indices(property.value, count as usize, bound, out) {
                        for _ in 0..count {
                            let value = self.rows.value(property.value, &property.name)?;
                            let vertex = self.vertex(value)?;
                            self.polygons.push(vertex);
                        }
                    }
                    self.polygons.end_face();
                } else {
                    self.skip_property(property)?;
                }
            }
            self.rows.end_row(element)?;
            row += 1;
        }
        self.note_dropped(element, index);
        Ok(())
    }

    fn read_strips(&mut self, element: &Element) -> Result<(), Error> {
        let index = index_list(element)?;
        let Some(index) = index else { return Ok(()) };
        let mut stored = StoredStrips::default();
        let mut short = 0u64;
        for _ in 0..element.row_count {
            for (i, property) in element.properties.iter().enumerate() {
                if i != index {
                    self.skip_property(property)?;
                    continue;
                }
                let count = self.list_count(property)?;
                let row = match self.rows.strip_row(property.value, count as usize, self.vertex_count) {
                    Some(row) => row,
                    None => self.strip_row(property, count)?,
                };
                self.polygons.reserve(3 * row.len());
                for (r, run) in row.split(|&index| index == RESTART).enumerate() {
                    stored.restarts += usize::from(r > 0);
                    short += u64::from(self.add_strip(run, &mut stored));
                }
                if stored.indices() > MAX_COUNT {
                    let (at, found) = (element.position(), stored.indices() as u64);
                    return Err(Error::LimitExceeded { at, found, limit: MAX_COUNT as u64 });
                }
            }
            self.rows.end_row(element)?;
        }
        self.strips = Some(stored);
        if short > 0 {
            self.notes.push(format!("strips of fewer than three vertices, without triangles: {short}"));
        }
        self.note_dropped(element, index);
        Ok(())
    }

    /// Reads the indices of a row of strips one by one.
    fn strip_row(&mut self, property: &Property, count: u64) -> Result<Vec<u32>, Error> {
        let mut row = Vec::new();
        for _ in 0..count {
            let value = self.rows.value(property.value, &property.name)?;
            let is_restart = RESTARTS.contains(&(value as i64));
            row.push(if is_restart { RESTART } else { self.vertex(value)? });
        }
        Ok(row)
    }

    /// Stores a strip and its triangles. Returns whether it is too short for a triangle.
    fn add_strip(&mut self, run: &[u32], stored: &mut StoredStrips) -> bool {
        strip_triangles(run).for_each(|triangle| self.polygons.push_face(&triangle));
        if !run.is_empty() {
            stored.runs.push(run);
        }
        (1..3).contains(&run.len())
    }

    /// Skips an element that a mesh cannot represent.
    fn skip(&mut self, element: &Element) -> Result<(), Error> {
        if !element.properties.is_empty() {
            for _ in 0..element.row_count {
                for property in &element.properties {
                    self.skip_property(property)?;
                }
                self.rows.end_row(element)?;
            }
        }
        if element.row_count > 0 {
            self.notes.push(format!("rows of element `{}` dropped: {}", element.name, element.row_count));
        }
        Ok(())
    }

    fn skip_property(&mut self, property: &Property) -> Result<(), Error> {
        if property.count.is_some() {
            self.skip_list(property)?;
        } else {
            self.rows.value(property.value, &property.name)?;
        }
        Ok(())
    }

    fn skip_list(&mut self, property: &Property) -> Result<u64, Error> {
        let count = self.list_count(property)?;
        for _ in 0..count {
            self.rows.value(property.value, &property.name)?;
        }
        Ok(count)
    }

    /// Reads the count of a list and checks it against the number of remaining bytes.
    #[allow(clippy::cast_sign_loss, reason = "negative counts are rejected above")]
    fn list_count(&mut self, property: &Property) -> Result<u64, Error> {
        let value = self.rows.value(property.count.unwrap_or(Scalar::U8), &property.name)?;
        let most = self.rows.values_left(property.value);
        if value < 0.0 || value > most as f64 {
            let found = format!("a list `{}` of {value}", property.name);
            let expected = format!("0 to {most} values in the remaining bytes");
            return Err(Error::format(self.rows.position(), found, expected));
        }
        Ok(value as u64)
    }

    #[allow(clippy::cast_sign_loss, reason = "negative indices are rejected above")]
    fn vertex(&self, value: f64) -> Result<u32, Error> {
        if value < 0.0 || value >= f64::from(self.vertex_count) {
            let found = format!("vertex index {value}");
            let expected = format!("at least 0 and less than {}", self.vertex_count);
            return Err(Error::format(self.rows.position(), found, expected));
        }
        Ok(value as u32)
    }

    fn note_dropped(&mut self, element: &Element, index: usize) {
        for (i, property) in element.properties.iter().enumerate() {
            if i != index {
                let (name, row) = (&property.name, &element.name);
                self.notes.push(format!("values of {row} property `{name}` dropped: {}", element.row_count));
            }
        }
    }
}

/// Returns the positions of vertices in rows of fixed size, and the number of rounded ones.
fn positions(
    rows: &FixedRows<'_>,
    element: &Element,
    axes: [usize; 3],
) -> Result<(Vec<[f32; 3]>, u64), Error> {
    let mut rounded = 0;
    let positions = if axes.iter().all(|&axis| rows.kind(axis) == Scalar::F32) {
        rows.gather_arrays(axes, f32::from_le_bytes)
    } else {
        let [xs, ys, zs] = axes.map(|axis| rows.wide(axis));
        let wide = xs.into_iter().zip(ys).zip(zs).map(|((x, y), z)| [x, y, z]);
        let narrow = |position: [f64; 3]| {
            let narrow = position.map(|value| value as f32);
            let is_exact = |(&x, wide): (&f32, f64)| f64::from(x).to_bits() == wide.to_bits();
            rounded += u64::from(!narrow.iter().zip(position).all(is_exact));
            narrow
        };
        wide.map(narrow).collect()
    };
    let is_finite = |position: &[f32; 3]| position.iter().all(|x| x.is_finite());
    match positions.iter().position(|position| !is_finite(position)) {
        None => Ok((positions, rounded)),
        Some(row) => Err(not_finite(rows, element, axes, row)),
    }
}

/// Returns the error for the first coordinate of a row that is not finite.
fn not_finite(rows: &FixedRows<'_>, element: &Element, mut axes: [usize; 3], row: usize) -> Error {
    axes.sort_unstable();
    let found = axes.map(|axis| (axis, rows.wide(axis)[row]));
    let bad = found.into_iter().find(|(_, value)| !(*value as f32).is_finite()).unwrap_or(found[0]);
    let expected = format!("a finite 32-bit number for `{}`", element.properties[bad.0].name);
    Error::format(format!("byte {}", rows.offset(row, bad.0)), format!("{:?}", bad.1), expected)
}

/// Returns the property with the list of vertices, or `None` if the element has no rows.
fn index_list(element: &Element) -> Result<Option<usize>, Error> {
    let found = element.find("vertex_indices").or_else(|| element.find("vertex_index"));
    let list = found.filter(|&i| {
        let property = &element.properties[i];
        property.count.is_some() && !property.value.is_float()
    });
    if list.is_none() && element.row_count > 0 {
        let found = format!("no such list in element `{}`", element.name);
        return Err(Error::format(element.position(), found, "a list of integers `vertex_indices`"));
    }
    Ok(list.filter(|_| element.row_count > 0))
}
