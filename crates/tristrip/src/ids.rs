//! Ids: distinct 32-bit types for faces and half-edges, an optional id of four bytes, and the
//! maximum number of ids.

use crate::error::Error;
use crate::index::Index;
use crate::text::counted;

/// Maximum number of vertices, faces or corners. Ids have 32 bits, and the highest value is
/// reserved.
pub const MAX_COUNT: usize = (u32::MAX - 1) as usize;

/// Checks that a count is at most [`MAX_COUNT`].
pub(crate) fn check_count(what: &'static str, found: usize) -> Result<(), Error> {
    if found > MAX_COUNT {
        return Err(Error::LimitExceeded { what, found: found as u64, limit: MAX_COUNT as u64 });
    }
    Ok(())
}

/// Returns the error for an index that is out of range, at position `at` of an index buffer.
pub(crate) fn index_out_of_range(at: usize, vertex: u32, vertex_count: usize) -> Error {
    let found = format!("index {vertex} at {at}, over {}", counted(vertex_count, "vertex"));
    Error::Parameter { name: "indices", found, expected: "less than the number of vertices" }
}

/// Converts indices to vertices.
///
/// # Errors
/// An index needs more than 32 bits.
pub(crate) fn vertices_of<I: Index>(indices: &[I]) -> Result<Vec<u32>, Error> {
    let vertex = |(place, index): (usize, &I)| {
        index.to_vertex().ok_or_else(|| Error::Parameter {
            name: "indices",
            found: format!("{index:?} at {place}"),
            expected: "indices of at most 32 bits",
        })
    };
    indices.iter().enumerate().map(vertex).collect()
}

/// Index of a face of the dual graph, counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FaceId(pub u32);

/// A directed edge of a face: the index of the corner at which it starts, counted over all faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct HalfEdge(pub u32);

/// An optional id of four bytes, for packed arrays. Ids are below [`MAX_COUNT`], so the highest
/// value can represent a missing id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct OptionalId(u32);

impl OptionalId {
    /// No id.
    pub(crate) const NONE: Self = Self(u32::MAX);

    /// Wraps an id below `u32::MAX`.
    #[inline]
    pub(crate) const fn some(id: u32) -> Self {
        debug_assert!(id != u32::MAX);
        Self(id)
    }

    /// Returns the id, or `None`.
    #[inline]
    pub(crate) const fn get(self) -> Option<u32> {
        if self.0 == u32::MAX { None } else { Some(self.0) }
    }

    /// Returns whether there is no id.
    #[inline]
    pub(crate) const fn is_none(self) -> bool {
        self.0 == u32::MAX
    }
}

impl Default for OptionalId {
    fn default() -> Self {
        Self::NONE
    }
}

impl From<Option<u32>> for OptionalId {
    #[inline]
    fn from(id: Option<u32>) -> Self {
        id.map_or(Self::NONE, Self::some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_optional_id_takes_four_bytes() {
        assert_eq!(size_of::<OptionalId>(), 4);
        assert_eq!([None, Some(0), Some(7)].map(|id| OptionalId::from(id).get()), [None, Some(0), Some(7)]);
        assert!(OptionalId::default().is_none() && !OptionalId::some(3).is_none());
    }
}
