//! New vertices of a part: copies of old ones with some values replaced.

use std::sync::Arc;

use tristrip::{Attribute, AttributeData, Faces, Mesh};

use crate::error::Error;

/// New vertices of a part.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NewVertices {
    /// The old vertex that each new vertex is copied from.
    pub sources: Vec<u32>,
    /// The unit normals; empty to copy the normals of the old vertices.
    pub normals: Vec<[f32; 3]>,
    /// The tangents, as in glTF: a unit vector and the sign of the bitangent. Empty to copy the
    /// tangents of the old vertices.
    pub tangents: Vec<[f32; 4]>,
    /// The positions; empty to copy the positions of the old vertices.
    pub positions: Vec<[f32; 3]>,
}

/// The values of new vertices that differ from the old ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NewValues {
    /// Normals and tangents.
    Directions,
    /// Positions.
    Positions,
}

impl NewValues {
    /// Returns the glTF attributes of these values.
    pub(crate) fn names(self) -> &'static [&'static str] {
        match self {
            Self::Directions => &["NORMAL", "TANGENT"],
            Self::Positions => &["POSITION"],
        }
    }
}

impl NewVertices {
    /// Returns a mesh with the old vertices followed by the new ones, without faces.
    ///
    /// # Errors
    /// A source is not a vertex of the mesh, or there are too many vertices.
    ///
    /// ```
    /// use tristrip_io::{Format, NewVertices, read};
    /// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nf 1//1 2//1 3//1\n", Format::Obj)?;
    /// let normals = vec![[0.0, 0.0, 1.0]];
    /// let new = NewVertices { sources: vec![2], normals, ..NewVertices::default() };
    /// let mesh = new.behind(&model.parts[0].mesh)?;
    /// assert_eq!(mesh.positions()[3], [0.0, 1.0, 0.0]);
    /// assert_eq!(mesh.attributes()[0].float(11), Some(1.0));
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn behind(&self, mesh: &Mesh) -> Result<Mesh, Error> {
        let first = mesh.vertex_count() as u32;
        let sources: Vec<u32> = (0..first).chain(self.sources.iter().copied()).collect();
        with_values(&mesh.select_vertices(&sources)?, &[(first, self)], &[(first, self)])
    }
}

/// Replaces normals, tangents and positions. Each entry has the first replaced vertex and the new
/// values.
pub(crate) fn with_values(
    mesh: &Mesh,
    directions: &[(u32, &NewVertices)],
    positions: &[(u32, &NewVertices)],
) -> Result<Mesh, Error> {
    let mut all = mesh.shared_positions();
    for &(first, new) in positions.iter().filter(|(_, new)| !new.positions.is_empty()) {
        let slots = Arc::make_mut(&mut all)[first as usize..].iter_mut();
        slots.zip(&new.positions).for_each(|(slot, new)| *slot = *new);
    }
    let mut replaced = Mesh::new(all, Faces::default())?;
    for attribute in mesh.attributes() {
        let mut attribute = attribute.clone();
        for &(first, new) in directions {
            let at = first as usize * usize::from(attribute.components);
            match (attribute.name.as_str(), attribute.components) {
                ("NORMAL", 3) => set(&mut attribute, at, new.normals.as_flattened()),
                ("TANGENT", 4) => set(&mut attribute, at, new.tangents.as_flattened()),
                _ => (),
            }
        }
        replaced = replaced.with_attribute(attribute)?;
    }
    Ok(replaced)
}

/// Sets values between −1 and 1, starting at `first`.
fn set(attribute: &mut Attribute, first: usize, values: &[f32]) {
    fn replace<T>(data: &mut [T], values: &[f32], value: impl Fn(f32) -> T) {
        data.iter_mut().zip(values).for_each(|(slot, &x)| *slot = value(x));
    }
    let most = |highest: i32| f64::from(highest);
    let fraction = |x: f32, highest: i32| (f64::from(x) * most(highest)).round();
    match &mut attribute.data {
        AttributeData::F32(data) => replace(&mut data[first..], values, |x| x),
        AttributeData::F64(data) => replace(&mut data[first..], values, f64::from),
        AttributeData::I8(data) => replace(&mut data[first..], values, |x| fraction(x, i8::MAX.into()) as i8),
        AttributeData::I16(data) => {
            replace(&mut data[first..], values, |x| fraction(x, i16::MAX.into()) as i16);
        }
        AttributeData::I32(data) => replace(&mut data[first..], values, |x| fraction(x, i32::MAX) as i32),
        AttributeData::U8(_) | AttributeData::U16(_) | AttributeData::U32(_) => (),
    }
}

/// Returns whether the type of an attribute can represent values from −1 to 1.
pub(crate) fn can_hold_directions(attribute: &Attribute) -> bool {
    match attribute.data {
        AttributeData::F32(_) | AttributeData::F64(_) => true,
        AttributeData::I8(_) | AttributeData::I16(_) | AttributeData::I32(_) => attribute.normalized,
        AttributeData::U8(_) | AttributeData::U16(_) | AttributeData::U32(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_stored_in_the_type_that_there_is() {
        let of = |data| Attribute { name: "NORMAL".into(), components: 3, normalized: true, data };
        let values = [-1.0, 0.0, 0.5];
        for (data, expected) in [
            (AttributeData::I8(vec![7; 6]), AttributeData::I8(vec![7, 7, 7, -127, 0, 64])),
            (AttributeData::I16(vec![7; 6]), AttributeData::I16(vec![7, 7, 7, -32767, 0, 16384])),
            (AttributeData::F64(vec![7.0; 6]), AttributeData::F64(vec![7.0, 7.0, 7.0, -1.0, 0.0, 0.5])),
        ] {
            let mut attribute = of(data);
            assert!(can_hold_directions(&attribute));
            set(&mut attribute, 3, &values);
            assert_eq!(attribute.data, expected);
        }
        assert!(!can_hold_directions(&of(AttributeData::U8(vec![0; 3]))));
    }
}
