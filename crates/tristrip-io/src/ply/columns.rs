//! Groups the properties of a vertex other than its position into attributes.

use tristrip::{Attribute, AttributeData};

use super::fixed_rows::FixedRows;
use super::header::{Element, Scalar};

/// A vertex attribute during reading.
pub(super) struct VertexColumn {
    pub(super) attribute: Attribute,
    /// The properties of its components.
    from: Vec<usize>,
    /// Whether values that are not finite become 0, as in normals, texture coordinates and colours.
    finite: bool,
    /// The number of replaced values.
    pub(super) replaced: u64,
}

impl VertexColumn {
    /// Reserves capacity. The caller has checked that the file can contain `row_count` rows.
    pub(super) fn reserve(&mut self, row_count: usize) {
        let n = row_count * self.from.len();
        match &mut self.attribute.data {
            AttributeData::F32(v) => v.reserve_exact(n),
            AttributeData::F64(v) => v.reserve_exact(n),
            AttributeData::U8(v) => v.reserve_exact(n),
            AttributeData::I8(v) => v.reserve_exact(n),
            AttributeData::U16(v) => v.reserve_exact(n),
            AttributeData::I16(v) => v.reserve_exact(n),
            AttributeData::U32(v) => v.reserve_exact(n),
            AttributeData::I32(v) => v.reserve_exact(n),
        }
    }

    /// Appends the values of rows of fixed size.
    pub(super) fn gather(&mut self, rows: &FixedRows<'_>) {
        let from = &self.from;
        match (&mut self.attribute.data, rows.kind(from[0])) {
            // Attributes with glTF names are 32-bit floats.
            (AttributeData::F32(v), Scalar::F64) => rows.gather(from, v, |b| f64::from_le_bytes(b) as f32),
            (AttributeData::F32(v), _) => rows.gather(from, v, f32::from_le_bytes),
            (AttributeData::F64(v), _) => rows.gather(from, v, f64::from_le_bytes),
            (AttributeData::U8(v), _) => rows.gather(from, v, u8::from_le_bytes),
            (AttributeData::I8(v), _) => rows.gather(from, v, i8::from_le_bytes),
            (AttributeData::U16(v), _) => rows.gather(from, v, u16::from_le_bytes),
            (AttributeData::I16(v), _) => rows.gather(from, v, i16::from_le_bytes),
            (AttributeData::U32(v), _) => rows.gather(from, v, u32::from_le_bytes),
            (AttributeData::I32(v), _) => rows.gather(from, v, i32::from_le_bytes),
        }
        if let (true, AttributeData::F32(values)) = (self.finite, &mut self.attribute.data) {
            for value in values.iter_mut().filter(|value| !value.is_finite()) {
                (*value, self.replaced) = (0.0, self.replaced + 1);
            }
        }
    }

    /// Appends the values of a row.
    #[allow(clippy::cast_sign_loss, reason = "a property's values are in the range of its type")]
    pub(super) fn push(&mut self, row: &[f64]) {
        for &i in &self.from {
            let mut value = row[i];
            if self.finite && !(value as f32).is_finite() {
                (value, self.replaced) = (0.0, self.replaced + 1);
            }
            match &mut self.attribute.data {
                AttributeData::F32(v) => v.push(value as f32),
                AttributeData::F64(v) => v.push(value),
                AttributeData::U8(v) => v.push(value as u8),
                AttributeData::I8(v) => v.push(value as i8),
                AttributeData::U16(v) => v.push(value as u16),
                AttributeData::I16(v) => v.push(value as i16),
                AttributeData::U32(v) => v.push(value as u32),
                AttributeData::I32(v) => v.push(value as i32),
            }
        }
    }
}

/// Groups the properties of a vertex into attributes, under glTF names if there are any, else under
/// their own.
pub(super) fn columns(element: &Element, position: [usize; 3]) -> Vec<VertexColumn> {
    let mut taken = position.to_vec();
    let mut columns: Vec<VertexColumn> = Vec::new();
    let mut group = |name: &str, properties: &[&str], allowed: &[Scalar]| -> bool {
        let found: Vec<usize> = properties.iter().filter_map(|name| element.find(name)).collect();
        let kinds = || found.iter().map(|&i| &element.properties[i]);
        let fits = found.len() == properties.len()
            && kinds().all(|p| p.count.is_none() && allowed.contains(&p.value))
            && kinds().all(|p| p.value == element.properties[found[0]].value)
            && !columns.iter().any(|column| column.attribute.name == name);
        if fits {
            let kind = element.properties[found[0]].value;
            // These attributes are stored as 32-bit floats, like positions.
            let kind = if kind == Scalar::F64 { Scalar::F32 } else { kind };
            taken.extend(&found);
            columns.push(VertexColumn { finite: true, ..column(name, found, kind) });
        }
        fits
    };
    let floats = [Scalar::F32, Scalar::F64];
    group("NORMAL", &["nx", "ny", "nz"], &floats);
    for pair in [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]] {
        group("TEXCOORD_0", &pair, &floats);
    }
    let colours = [Scalar::U8, Scalar::U16, Scalar::F32, Scalar::F64];
    for prefix in ["", "diffuse_"] {
        let names = ["red", "green", "blue", "alpha"].map(|name| format!("{prefix}{name}"));
        let [r, g, b, a] = [&names[0], &names[1], &names[2], &names[3]];
        if !group("COLOR_0", &[r, g, b, a], &colours) {
            group("COLOR_0", &[r, g, b], &colours);
        }
    }
    for (i, property) in element.properties.iter().enumerate() {
        if property.count.is_none() && !taken.contains(&i) {
            columns.push(column(&property.name, vec![i], property.value));
        }
    }
    columns
}

fn column(name: &str, from: Vec<usize>, kind: Scalar) -> VertexColumn {
    let data = match kind {
        Scalar::I8 => AttributeData::I8(Vec::new()),
        Scalar::U8 => AttributeData::U8(Vec::new()),
        Scalar::I16 => AttributeData::I16(Vec::new()),
        Scalar::U16 => AttributeData::U16(Vec::new()),
        Scalar::I32 => AttributeData::I32(Vec::new()),
        Scalar::U32 => AttributeData::U32(Vec::new()),
        Scalar::F32 => AttributeData::F32(Vec::new()),
        Scalar::F64 => AttributeData::F64(Vec::new()),
    };
    let normalized = name == "COLOR_0" && from.len() > 1 && !kind.is_float();
    let components = from.len() as u8;
    let attribute = Attribute { name: name.to_owned(), components, normalized, data };
    VertexColumn { attribute, from, finite: false, replaced: 0 }
}
