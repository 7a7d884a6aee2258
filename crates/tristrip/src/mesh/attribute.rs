//! Vertex attributes other than the position: normals, texture coordinates, colours and others.

use std::mem::discriminant;

use crate::error::{Error, MeshProblem};
use crate::ids::index_out_of_range;
use crate::text::counted;

/// The values of one vertex attribute, with `components` values per vertex.
#[derive(Debug, Clone, PartialEq)]
pub enum AttributeData {
    /// 32-bit floats.
    F32(Vec<f32>),
    /// 64-bit floats.
    F64(Vec<f64>),
    /// Unsigned bytes.
    U8(Vec<u8>),
    /// Signed bytes.
    I8(Vec<i8>),
    /// Unsigned 16-bit integers.
    U16(Vec<u16>),
    /// Signed 16-bit integers.
    I16(Vec<i16>),
    /// Unsigned 32-bit integers.
    U32(Vec<u32>),
    /// Signed 32-bit integers.
    I32(Vec<i32>),
}

impl AttributeData {
    /// Counts the values, over all vertices and components.
    ///
    /// ```
    /// // The normals of two vertices.
    /// let normals = tristrip::AttributeData::F32(vec![0.0, 0.0, 1.0, 0.0, 1.0, 0.0]);
    /// assert_eq!(normals.len(), 6);
    /// ```
    pub fn len(&self) -> usize {
        match self {
            Self::F32(v) => v.len(),
            Self::F64(v) => v.len(),
            Self::U8(v) => v.len(),
            Self::I8(v) => v.len(),
            Self::U16(v) => v.len(),
            Self::I16(v) => v.len(),
            Self::U32(v) => v.len(),
            Self::I32(v) => v.len(),
        }
    }

    /// Returns whether there are no values.
    ///
    /// ```
    /// use tristrip::AttributeData;
    /// assert!(AttributeData::U16(vec![]).is_empty() && !AttributeData::U16(vec![0]).is_empty());
    /// ```
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A vertex attribute: one value of one or more components per vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct Attribute {
    /// The glTF name if there is one (`NORMAL`, `TEXCOORD_0`, `COLOR_0`), otherwise the name in the
    /// file.
    pub name: String,
    /// Number of components per vertex, at least 1.
    pub components: u8,
    /// Whether integers are normalized, as in glTF: they represent fractions of their range.
    pub normalized: bool,
    /// The values, in vertex order.
    pub data: AttributeData,
}

impl Attribute {
    /// Returns the values of the given vertices, in their order.
    ///
    /// # Errors
    /// A vertex is out of range, or the attribute has zero components.
    ///
    /// ```
    /// use tristrip::{Attribute, AttributeData};
    /// let data = AttributeData::U8(vec![0, 1, 10, 11, 20, 21]);
    /// let pairs = Attribute { name: "pairs".into(), components: 2, normalized: false, data };
    /// assert_eq!(pairs.of_vertices(&[2, 0])?.data, AttributeData::U8(vec![20, 21, 0, 1]));
    /// assert!(pairs.of_vertices(&[3]).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of_vertices(&self, vertices: &[u32]) -> Result<Self, Error> {
        self.check_components()?;
        let vertex_count = self.data.len() / usize::from(self.components);
        match vertices.iter().position(|&v| v as usize >= vertex_count) {
            Some(at) => Err(index_out_of_range(at, vertices[at], vertex_count)),
            None => Ok(self.select(vertices)),
        }
    }

    /// Appends the values of an attribute with the same name, type and number of components.
    ///
    /// # Errors
    /// The attributes differ in name, type, number of components or normalization.
    ///
    /// ```
    /// use tristrip::{Attribute, AttributeData};
    /// let of = |data| Attribute { name: "shade".into(), components: 1, normalized: true, data };
    /// let mut shade = of(AttributeData::U8(vec![1, 2]));
    /// shade.append(&of(AttributeData::U8(vec![3])))?;
    /// assert_eq!(shade.data, AttributeData::U8(vec![1, 2, 3]));
    /// assert!(shade.append(&of(AttributeData::I8(vec![4]))).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn append(&mut self, more: &Self) -> Result<(), Error> {
        if (&self.name, self.components, self.normalized) != (&more.name, more.components, more.normalized)
            || discriminant(&self.data) != discriminant(&more.data)
        {
            let found = format!("attribute `{}` of {}", more.name, counted(more.components, "component"));
            return Err(Error::Parameter { name: "attributes", found, expected: "one name and type" });
        }
        match (&mut self.data, &more.data) {
            (AttributeData::F32(all), AttributeData::F32(more)) => all.extend(more),
            (AttributeData::F64(all), AttributeData::F64(more)) => all.extend(more),
            (AttributeData::U8(all), AttributeData::U8(more)) => all.extend(more),
            (AttributeData::I8(all), AttributeData::I8(more)) => all.extend(more),
            (AttributeData::U16(all), AttributeData::U16(more)) => all.extend(more),
            (AttributeData::I16(all), AttributeData::I16(more)) => all.extend(more),
            (AttributeData::U32(all), AttributeData::U32(more)) => all.extend(more),
            (AttributeData::I32(all), AttributeData::I32(more)) => all.extend(more),
            // The types are the same.
            _ => (),
        }
        Ok(())
    }

    /// Returns value `i` of the data as a float, or `None` if it is out of range. Normalized
    /// integers are converted to the fraction that they represent.
    ///
    /// ```
    /// use tristrip::{Attribute, AttributeData};
    /// let data = AttributeData::U8(vec![0, 255, 51]);
    /// let red = Attribute { name: "red".into(), components: 1, normalized: true, data };
    /// assert_eq!([1, 2, 3].map(|i| red.float(i)), [Some(1.0), Some(0.2), None]);
    /// ```
    pub fn float(&self, i: usize) -> Option<f32> {
        let fraction = |value: f32, most: f32| if self.normalized { (value / most).max(-1.0) } else { value };
        match &self.data {
            AttributeData::F32(v) => v.get(i).copied(),
            AttributeData::F64(v) => v.get(i).map(|&x| x as f32),
            AttributeData::U8(v) => v.get(i).map(|&x| fraction(x.into(), u8::MAX.into())),
            AttributeData::I8(v) => v.get(i).map(|&x| fraction(x.into(), i8::MAX.into())),
            AttributeData::U16(v) => v.get(i).map(|&x| fraction(x.into(), u16::MAX.into())),
            AttributeData::I16(v) => v.get(i).map(|&x| fraction(x.into(), i16::MAX.into())),
            AttributeData::U32(v) => v.get(i).map(|&x| fraction(x as f32, u32::MAX as f32)),
            AttributeData::I32(v) => v.get(i).map(|&x| fraction(x as f32, i32::MAX as f32)),
        }
    }

    /// Checks that there is one value per vertex, with at least one component.
    pub(crate) fn check(&self, vertex_count: usize) -> Result<(), Error> {
        self.check_components()?;
        let components = usize::from(self.components);
        if Some(self.data.len()) == vertex_count.checked_mul(components) {
            return Ok(());
        }
        let found = (self.data.len() / components) as u64;
        let (name, expected) = (self.name.clone(), vertex_count as u64);
        Err(MeshProblem::AttributeLength { name, found, expected }.into())
    }

    fn check_components(&self) -> Result<(), Error> {
        if self.components > 0 {
            return Ok(());
        }
        let found = format!("0 of attribute `{}`", self.name);
        Err(Error::Parameter { name: "components", found, expected: "at least 1" })
    }

    /// Returns the values of the given vertices, in their order. The vertices must be in range.
    pub(crate) fn select(&self, vertices: &[u32]) -> Self {
        let n = usize::from(self.components.max(1));
        let data = match &self.data {
            AttributeData::F32(values) => AttributeData::F32(select(values, n, vertices)),
            AttributeData::F64(values) => AttributeData::F64(select(values, n, vertices)),
            AttributeData::U8(values) => AttributeData::U8(select(values, n, vertices)),
            AttributeData::I8(values) => AttributeData::I8(select(values, n, vertices)),
            AttributeData::U16(values) => AttributeData::U16(select(values, n, vertices)),
            AttributeData::I16(values) => AttributeData::I16(select(values, n, vertices)),
            AttributeData::U32(values) => AttributeData::U32(select(values, n, vertices)),
            AttributeData::I32(values) => AttributeData::I32(select(values, n, vertices)),
        };
        Self { name: self.name.clone(), data, ..*self }
    }

    /// Appends the bits of a vertex's values to a key.
    pub(crate) fn append_bits(&self, vertex: usize, key: &mut Vec<u8>) {
        let n = usize::from(self.components.max(1));
        let range = vertex * n..(vertex + 1) * n;
        match &self.data {
            AttributeData::F32(d) => d[range].iter().for_each(|x| key.extend(x.to_bits().to_le_bytes())),
            AttributeData::F64(d) => d[range].iter().for_each(|x| key.extend(x.to_bits().to_le_bytes())),
            AttributeData::U8(d) => key.extend(&d[range]),
            AttributeData::I8(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
            AttributeData::U16(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
            AttributeData::I16(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
            AttributeData::U32(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
            AttributeData::I32(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
        }
    }
}

/// Returns the values of the given vertices, `components` each, in the order of `vertices`.
pub(crate) fn select<T: Copy>(values: &[T], components: usize, vertices: &[u32]) -> Vec<T> {
    if components == 1 {
        return vertices.iter().map(|&v| values[v as usize]).collect();
    }
    let mut selected = Vec::with_capacity(components * vertices.len());
    for &v in vertices {
        let first = v as usize * components;
        selected.extend_from_slice(&values[first..first + components]);
    }
    selected
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_vertices_and_components_are_refused() {
        let attribute = |components, length| Attribute {
            name: "a".into(),
            components,
            normalized: false,
            data: AttributeData::F32(vec![f32::NAN; length]),
        };
        let pairs = attribute(2, 5);
        assert_eq!(pairs.of_vertices(&[1, 0]).unwrap().data.len(), 4);
        let message = "parameter `indices`: found index 2 at 1, over 2 vertices, expected less than the number of vertices";
        assert_eq!(pairs.of_vertices(&[0, 2]).unwrap_err().to_string(), message);
        assert!(pairs.of_vertices(&[u32::MAX]).is_err());
        let message = "parameter `components`: found 0 of attribute `a`, expected at least 1";
        assert_eq!(attribute(0, 2).of_vertices(&[]).unwrap_err().to_string(), message);
        assert!(
            pairs.check(usize::MAX).is_err()
                && pairs.check(2).is_err()
                && attribute(255, 510).check(2).is_ok()
        );
    }
}
