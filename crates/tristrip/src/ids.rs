//! Ids of faces and half-edges: numbers of 32 bits that cannot be mistaken for one another, and one that may be absent.

/// A face of the dual graph, counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FaceId(pub u32);

/// A directed edge of a face: the corner that it starts from, counted over all faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct HalfEdge(pub u32);

/// An id that may be absent, in four bytes, for packed arrays. No id reaches [`crate::mesh::MAX_COUNT`], so that one value is free.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct OptionalId(u32);

impl OptionalId {
    /// No id.
    pub(crate) const NONE: Self = Self(u32::MAX);

    /// Wraps an id, which is below `u32::MAX`.
    #[inline]
    pub(crate) const fn some(id: u32) -> Self {
        debug_assert!(id != u32::MAX);
        Self(id)
    }

    /// Returns the id, if there is one.
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
    fn an_optional_id_is_four_bytes_and_knows_absence() {
        assert_eq!(size_of::<OptionalId>(), 4);
        assert_eq!([None, Some(0), Some(7)].map(|id| OptionalId::from(id).get()), [None, Some(0), Some(7)]);
        assert!(OptionalId::default().is_none() && !OptionalId::some(3).is_none());
    }
}
