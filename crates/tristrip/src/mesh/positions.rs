//! Positions in the caller's memory: arrays of points from any library, or vertices with
//! interleaved attributes.
//!
//! ```text
//! InterleavedPositions    offset
//!                        ├───────┤
//!                         x  y  u  v  px py pz   x  y  u  v  px py pz      one stride per vertex
//! ```

use crate::error::{Error, MeshProblem};
use crate::ids::check_count;
use crate::text::counted;

/// Vertex positions, in any storage.
///
/// Implemented for slices, vectors and arrays of every type that converts to `[f32; 3]`: points and
/// vectors of `glam`, `mint`, `nalgebra` and other crates in any version, and your own vertex
/// types. Use [`InterleavedPositions`] for a buffer of numbers or bytes.
///
/// ```
/// use tristrip::Positions;
/// #[derive(Clone, Copy)]
/// struct Vertex { at: [f32; 3], colour: u32 }
/// impl From<Vertex> for [f32; 3] {
///     fn from(vertex: Vertex) -> Self {
///         vertex.at
///     }
/// }
/// let vertices = [Vertex { at: [0.0; 3], colour: 7 }, Vertex { at: [1.0, 2.0, 3.0], colour: 8 }];
/// assert_eq!((vertices.vertex_count(), vertices.position(1)), (2, Some([1.0, 2.0, 3.0])));
/// assert_eq!(vertices[0].colour, 7);
/// ```
pub trait Positions {
    /// Counts the vertices.
    ///
    /// ```
    /// use tristrip::Positions;
    /// assert_eq!([[0.0; 3], [1.0; 3]].vertex_count(), 2);
    /// ```
    fn vertex_count(&self) -> usize;

    /// Returns the position of a vertex in mesh units, or `None` if there is no such vertex.
    ///
    /// ```
    /// use tristrip::Positions;
    /// fn height<P: Positions>(positions: &P) -> f32 {
    ///     (0..positions.vertex_count()).filter_map(|v| positions.position(v)).map(|p| p[1]).fold(0.0, f32::max)
    /// }
    /// assert_eq!(height(&vec![[0.0, 1.0, 0.0], [0.0, 3.0, 0.0], [0.0, 2.0, 0.0]]), 3.0);
    /// ```
    fn position(&self, vertex: usize) -> Option<[f32; 3]>;
}

impl<P: Copy + Into<[f32; 3]>> Positions for [P] {
    fn vertex_count(&self) -> usize {
        self.len()
    }

    #[inline]
    fn position(&self, vertex: usize) -> Option<[f32; 3]> {
        self.get(vertex).map(|&position| position.into())
    }
}

impl<P: Copy + Into<[f32; 3]>> Positions for Vec<P> {
    fn vertex_count(&self) -> usize {
        self.len()
    }

    #[inline]
    fn position(&self, vertex: usize) -> Option<[f32; 3]> {
        self[..].position(vertex)
    }
}

impl<P: Copy + Into<[f32; 3]>, const N: usize> Positions for [P; N] {
    fn vertex_count(&self) -> usize {
        N
    }

    #[inline]
    fn position(&self, vertex: usize) -> Option<[f32; 3]> {
        self[..].position(vertex)
    }
}

/// Positions interleaved with other values of each vertex, as in a vertex buffer. Nothing is
/// copied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterleavedPositions<'a> {
    values: FloatSource<'a>,
    stride: usize,
    offset: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum FloatSource<'a> {
    Floats(&'a [f32]),
    Bytes(&'a [u8]),
}

impl<'a> InterleavedPositions<'a> {
    /// Borrows positions from floats. The three coordinates of vertex i start at index
    /// `i * stride + offset`.
    ///
    /// # Errors
    /// The position does not fit within the stride, the number of floats is not a multiple of the
    /// stride, or there are too many vertices for 32-bit indices.
    ///
    /// ```
    /// use tristrip::{InterleavedPositions, Positions};
    /// // Texture coordinates, then a position.
    /// let vertices = [0.5, 0.5, 1.0, 2.0, 3.0, 0.0, 1.0, 4.0, 5.0, 6.0];
    /// let positions = InterleavedPositions::from_floats(&vertices, 5, 2)?;
    /// assert_eq!((positions.vertex_count(), positions.position(1)), (2, Some([4.0, 5.0, 6.0])));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn from_floats(floats: &'a [f32], stride: usize, offset: usize) -> Result<Self, Error> {
        check_stride(floats.len(), stride, offset, 3)?;
        Ok(Self { values: FloatSource::Floats(floats), stride, offset })
    }

    /// Borrows positions from bytes. The coordinates of vertex i are three 32-bit floats in native
    /// byte order, starting at byte `i * stride + offset`.
    ///
    /// # Errors
    /// The position does not fit within the stride, the number of bytes is not a multiple of the
    /// stride, or there are too many vertices for 32-bit indices.
    ///
    /// ```
    /// use tristrip::{InterleavedPositions, Positions};
    /// let mut buffer = vec![0_u8; 2 * 16];
    /// for (i, x) in [1.0_f32, 2.0, 3.0].into_iter().enumerate() {
    ///     buffer[16 + 4 * i..][..4].copy_from_slice(&x.to_ne_bytes());
    /// }
    /// let positions = InterleavedPositions::from_bytes(&buffer, 16, 0)?;
    /// assert_eq!(positions.position(1), Some([1.0, 2.0, 3.0]));
    /// assert!(InterleavedPositions::from_bytes(&buffer, 16, 5).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn from_bytes(bytes: &'a [u8], stride: usize, offset: usize) -> Result<Self, Error> {
        check_stride(bytes.len(), stride, offset, 12)?;
        Ok(Self { values: FloatSource::Bytes(bytes), stride, offset })
    }
}

impl Positions for InterleavedPositions<'_> {
    fn vertex_count(&self) -> usize {
        let length = match self.values {
            FloatSource::Floats(floats) => floats.len(),
            FloatSource::Bytes(bytes) => bytes.len(),
        };
        length / self.stride
    }

    fn position(&self, vertex: usize) -> Option<[f32; 3]> {
        let start = vertex.checked_mul(self.stride)?.checked_add(self.offset)?;
        match self.values {
            FloatSource::Floats(floats) => floats.get(start..)?.first_chunk().copied(),
            FloatSource::Bytes(bytes) => {
                let (floats, _) = bytes.get(start..)?.as_chunks::<4>();
                floats.first_chunk().map(|position| position.map(f32::from_ne_bytes))
            }
        }
    }
}

/// Checks that the length is a multiple of the stride, and that a position of `size` values fits
/// within a stride.
fn check_stride(length: usize, stride: usize, offset: usize, size: usize) -> Result<(), Error> {
    if offset.checked_add(size).is_none_or(|end| end > stride) {
        let found = format!("{stride} with an offset of {offset}");
        return Err(Error::Parameter {
            name: "stride",
            found,
            expected: "a stride that contains the position",
        });
    }
    if !length.is_multiple_of(stride) {
        let found = format!("{} with a stride of {stride}", counted(length, "value"));
        return Err(Error::Parameter { name: "positions", found, expected: "a multiple of the stride" });
    }
    check_count("vertices", length / stride)
}

/// Checks that the vertices of all corners have finite positions.
pub(crate) fn check_positions<P: Positions + ?Sized>(corners: &[u32], positions: &P) -> Result<(), Error> {
    for (at, &vertex) in corners.iter().enumerate() {
        let position = positions.position(vertex as usize);
        let position =
            position.ok_or_else(|| crate::ids::index_out_of_range(at, vertex, positions.vertex_count()))?;
        if let Some(found) = position.into_iter().find(|x| !x.is_finite()) {
            return Err(MeshProblem::NotFinite { vertex, found }.into());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_strides_and_vertices_are_refused() {
        let floats = [f32::NAN; 12];
        for (stride, offset) in [(0, 0), (2, 0), (3, 1), (4, 2), (5, 0), (3, usize::MAX), (usize::MAX, 0)] {
            assert!(InterleavedPositions::from_floats(&floats, stride, offset).is_err(), "{stride} {offset}");
        }
        let bytes = [0_u8; 48];
        for (stride, offset) in [(0, 0), (11, 0), (12, 1), (13, 0), (16, 5), (usize::MAX, usize::MAX - 12)] {
            assert!(InterleavedPositions::from_bytes(&bytes, stride, offset).is_err(), "{stride} {offset}");
        }
        let of_floats = InterleavedPositions::from_floats(&floats, 4, 1).unwrap();
        let of_bytes = InterleavedPositions::from_bytes(&bytes, 16, 4).unwrap();
        for positions in [of_floats, of_bytes] {
            assert_eq!(positions.vertex_count(), 3);
            assert!((0..3).all(|v| positions.position(v).is_some()));
            assert_eq!([3, usize::MAX / 16, usize::MAX].map(|v| positions.position(v)), [None; 3]);
        }
        assert!(
            check_positions(&[2, 3], &of_bytes).is_err() && check_positions(&[u32::MAX], &of_bytes).is_err()
        );
        assert!(matches!(
            check_positions(&[1], &of_floats),
            Err(Error::Mesh(MeshProblem::NotFinite { vertex: 1, .. }))
        ));
        assert!(check_positions(&[2, 0], &of_bytes).is_ok());
    }
}
