//! The content of an OBJ file: positions, texture coordinates, normals, and faces that refer to
//! them.

use crate::polygons::Polygons;

/// The tables of a file.
#[derive(Debug, Default)]
pub(super) struct ObjTables {
    pub(super) positions: Vec<[f32; 3]>,
    /// Empty, or one colour per position.
    pub(super) colours: Vec<[f32; 3]>,
    pub(super) texcoords: Vec<[f32; 2]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// The corners are indices of positions.
    pub(super) polygons: Polygons,
    /// The texture coordinate of each corner.
    pub(super) texcoord_of: CornerColumn,
    /// The normal of each corner.
    pub(super) normal_of: CornerColumn,
    /// In order of first use.
    pub(super) groups: Vec<MaterialGroup>,
}

/// The faces of one material.
#[derive(Debug, Default)]
pub(super) struct MaterialGroup {
    pub(super) name: Option<String>,
    pub(super) material: Option<String>,
    /// Ranges of faces, in order.
    pub(super) runs: Vec<(usize, usize)>,
}

/// An optional index into a table, in four bytes. The highest value means `None`; no table is that
/// long.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct OptionalIndex(u32);

impl OptionalIndex {
    pub(super) const NONE: Self = Self(u32::MAX);

    /// Returns the index, if there is one.
    pub(super) fn get(self) -> Option<u32> {
        (self != Self::NONE).then_some(self.0)
    }
}

impl From<u32> for OptionalIndex {
    fn from(index: u32) -> Self {
        debug_assert!(index != u32::MAX);
        Self(index)
    }
}

/// An optional index into a table per corner; empty until the first corner has an index.
#[derive(Debug, Default)]
pub(super) struct CornerColumn(Vec<OptionalIndex>);

impl CornerColumn {
    /// Checks whether no corner has an index.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Sets the index of a corner; corners are set in order.
    pub(super) fn push(&mut self, corner: usize, index: OptionalIndex) {
        if index != OptionalIndex::NONE || !self.0.is_empty() {
            self.0.resize(corner, OptionalIndex::NONE);
            self.0.push(index);
        }
    }

    /// Returns the index of a corner.
    pub(super) fn get(&self, corner: usize) -> OptionalIndex {
        self.0.get(corner).copied().unwrap_or(OptionalIndex::NONE)
    }

    /// Returns how many of `corner_count` corners have no index, or 0 if no corner has one.
    pub(super) fn missing(&self, corner_count: usize) -> usize {
        if self.is_empty() { 0 } else { corner_count - self.0.iter().filter(|i| i.get().is_some()).count() }
    }

    /// Returns the highest index.
    pub(super) fn highest(&self) -> Option<u32> {
        self.0.iter().filter_map(|index| index.get()).max()
    }
}
