//! The collapses of a simplification in order, with the triangles of the full mesh.
//!
//! A half-edge collapse renames one vertex, the *removed* one, to a neighbour, the *kept* one.
//! Triangles that contain both vertices become degenerate and are dropped. A point on an attribute
//! seam has several vertices at one position. They are renamed together in one collapse. Nothing
//! else changes: every level of detail is the full mesh with some vertices renamed, so only the
//! collapses are stored.
//!
//! ```text
//!  level 0                                                level n
//!  base mesh ─ split 0 ─▶ level 1 ─ split 1 ─▶ … ─ split n−1 ─▶ full mesh
//!            ◀ collapse 0 ─      ◀ collapse 1 ─     ◀ collapse n−1 ─
//! ```
//!
//! Collapse i leads from level i + 1 to level i, and vertex split i undoes it. The first collapse
//! of a simplification is therefore collapse n − 1.
//!
//! # Complexity
//! 12 bytes per triangle of the full mesh, plus 32 bytes per collapse that renames one vertex and
//! drops two triangles.
//!
//! # References
//! Hoppe: *Progressive Meshes*, 1996. Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient
//! Progressive Transmission of 3D Meshes*, 2005, section 3.

mod merge;
#[cfg(test)]
mod tests;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::error::Error;
use crate::ids::check_count;
use crate::mesh::{SPARSE, check_corners, check_triangles, is_degenerate, triangles_of};
use merge::MergedVertices;

/// The replacement of one vertex by another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Rename {
    /// The vertex that is no longer drawn.
    pub removed: u32,
    /// The vertex that replaces it.
    pub kept: u32,
}

/// One collapse of a sequence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collapse<'a> {
    /// The renamed vertices: a single vertex, or all vertices at a position if their attributes
    /// differ.
    pub renames: &'a [Rename],
    /// The indices of the dropped triangles in the full mesh, ascending.
    pub dropped: &'a [u32],
    /// The local error relative to the full surface, in mesh units. It is the maximum of two
    /// values: the distance of the removed vertex from the triangles that replace its triangles,
    /// and the RMS distance of the kept vertex to the planes of the full mesh that the removed
    /// vertex represents. With `simplify::Price::Quadric` it is the square root of the sum of the
    /// squared distances to the planes of both vertices, and the planes along borders have a weight
    /// of 1000.
    pub error: f32,
}

/// A simplification from the full mesh (level n) to the base mesh (level 0). It can be replayed in
/// both directions.
///
/// ```
/// use tristrip::{CollapseSequence, Rename};
/// // Two triangles; vertex 3 collapses to vertex 2.
/// let rename = [Rename { removed: 3, kept: 2 }];
/// let sequence = CollapseSequence::from_collapses(4, vec![0, 1, 2, 2, 1, 3], [(&rename[..], 0.5)])?;
/// assert_eq!(sequence.len(), 1);
/// assert_eq!(sequence.drawn(1)?, [[0, 1, 2], [2, 1, 3]]);
/// assert_eq!(sequence.drawn(0)?, [[0, 1, 2]]);
/// assert_eq!(sequence.collapse(0)?.dropped, [1]);
/// assert!(sequence.drawn(2).is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CollapseSequence {
    vertex_count: usize,
    triangles: Vec<u32>,
    /// The number of degenerate triangles in the full mesh.
    degenerate_count: usize,
    // The arrays below are in the order of the collapses, starting from the full mesh.
    errors: Vec<f32>,
    /// The running maximum of `errors`.
    largest_errors: Vec<f32>,
    renames: Vec<Rename>,
    rename_ends: Vec<u32>,
    dropped: Vec<u32>,
    dropped_ends: Vec<u32>,
}

impl CollapseSequence {
    /// Creates a sequence without collapses.
    ///
    /// # Errors
    /// The number of corners is not a multiple of three, a vertex index is out of range, or there
    /// are too many vertices or corners for 32-bit ids.
    pub(crate) fn new(vertex_count: usize, triangles: Vec<u32>) -> Result<Self, Error> {
        check_count("vertices", vertex_count)?;
        check_count("corners", triangles.len())?;
        check_triangles(triangles.len())?;
        check_corners(&triangles, vertex_count)?;
        let degenerate_count = triangles_of(&triangles).filter(|&t| is_degenerate(t)).count();
        Ok(Self { vertex_count, triangles, degenerate_count, ..Self::default() })
    }

    /// Builds a sequence from the triangles of the full mesh and the collapses with their errors,
    /// in order and starting at the full mesh. Memory is proportional to the number of triangles,
    /// plus the number of vertices unless the triangles use only a few of them.
    ///
    /// # Errors
    /// The number of corners is not a multiple of three; a vertex index is out of range; there are
    /// too many vertices or corners for 32-bit ids; a collapse renames an unused or already removed
    /// vertex, or renames a vertex to itself or to another removed vertex; an error is negative or
    /// NaN.
    ///
    /// ```
    /// use tristrip::{CollapseSequence, Rename};
    /// let renames = [[Rename { removed: 3, kept: 2 }], [Rename { removed: 3, kept: 1 }]];
    /// let build = |count| {
    ///     let collapses = renames[..count].iter().map(|renames| (&renames[..], 0.5));
    ///     CollapseSequence::from_collapses(4, vec![0, 1, 2, 2, 1, 3], collapses)
    /// };
    /// assert_eq!(build(1)?.drawn(0)?, [[0, 1, 2]]);
    /// // No triangle uses vertex 3 after the first collapse.
    /// assert!(build(2).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn from_collapses<'a>(
        vertex_count: usize,
        triangles: Vec<u32>,
        collapses: impl IntoIterator<Item = (&'a [Rename], f32)>,
    ) -> Result<Self, Error> {
        let mut sequence = Self::new(vertex_count, triangles)?;
        let mut merged = MergedVertices::new(vertex_count, &sequence.triangles);
        let mut removed = FxHashSet::default();
        for (renames, error) in collapses {
            if error.is_nan() || error < 0.0 {
                let found = format!("{error} of collapse {} from the full mesh", sequence.len());
                return Err(Error::Parameter { name: "error", found, expected: "0 or more" });
            }
            removed.clear();
            removed.extend(renames.iter().map(|rename| rename.removed));
            let mut dropped = Vec::new();
            for &rename in renames {
                if removed.contains(&rename.kept)
                    || merged.rename(rename.removed, rename.kept, &mut dropped).is_none()
                {
                    return Err(sequence.wrong_rename(rename));
                }
            }
            dropped.sort_unstable();
            sequence.push(renames, &dropped, error);
        }
        Ok(sequence)
    }

    /// Returns the error for a rename that is invalid in the next collapse.
    fn wrong_rename(&self, Rename { removed, kept }: Rename) -> Error {
        Error::Parameter {
            name: "collapses",
            found: format!("{removed} renamed to {kept} by collapse {} from the full mesh", self.len()),
            expected: "two vertices that are still drawn, the second not renamed itself",
        }
    }

    /// Appends the next collapse toward the base mesh. `dropped` is in ascending order.
    pub(crate) fn push(&mut self, renames: &[Rename], dropped: &[u32], error: f32) {
        self.renames.extend_from_slice(renames);
        self.rename_ends.push(self.renames.len() as u32);
        self.dropped.extend_from_slice(dropped);
        self.dropped_ends.push(self.dropped.len() as u32);
        self.errors.push(error);
        let largest = self.largest_errors.last().copied().unwrap_or(0.0);
        self.largest_errors.push(largest.max(error));
    }

    /// Reorders the collapses. `order` lists their indices from 0 in the new order, first collapse
    /// first. Drops the collapses that follow once at most `triangle_count` triangles remain.
    pub(crate) fn reorder(&mut self, order: &[u32], triangle_count: usize) {
        let highest = self.len();
        let mut left = self.triangles_at(highest);
        let full = Self {
            vertex_count: self.vertex_count,
            triangles: std::mem::take(&mut self.triangles),
            degenerate_count: self.degenerate_count,
            ..Self::default()
        };
        let found = std::mem::replace(self, full);
        for &number in order {
            if left <= triangle_count {
                break;
            }
            let collapse = found.collapse_to(highest - 1 - number as usize);
            left -= collapse.dropped.len();
            self.push(collapse.renames, collapse.dropped, collapse.error);
        }
    }

    /// Multiplies all errors by a non-negative scale, such as the scale of the mesh in a scene.
    ///
    /// # Errors
    /// The scale is negative or NaN.
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// assert_eq!(sequence.clone().with_scaled_errors(10.0)?.error(0)?, 5.0);
    /// assert!(sequence.with_scaled_errors(-1.0).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn with_scaled_errors(mut self, scale: f64) -> Result<Self, Error> {
        if scale.is_nan() || scale < 0.0 {
            let found = scale.to_string();
            return Err(Error::Parameter { name: "scale", found, expected: "0 or more" });
        }
        // An error of 0 remains 0 even at an infinite scale, where the product would be NaN.
        let scaled = |error: &mut f32| {
            *error =
                if *error > 0.0 { (f64::from(*error) * scale).min(f64::from(f32::MAX)) as f32 } else { 0.0 };
        };
        self.errors.iter_mut().chain(&mut self.largest_errors).for_each(scaled);
        Ok(self)
    }

    /// Returns the number of collapses, which is also the level of the full mesh.
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// assert_eq!(sequence.len(), 2);
    /// assert_eq!(sequence.drawn(sequence.len())?.len(), 3);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn len(&self) -> usize {
        self.errors.len()
    }

    /// Returns whether the sequence has no collapses. The base mesh is then the full mesh.
    ///
    /// ```
    /// let sequence = tristrip::CollapseSequence::from_collapses(3, vec![0, 1, 2], [])?;
    /// assert!(sequence.is_empty() && sequence.drawn(0)?.len() == 1);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn is_empty(&self) -> bool {
        self.errors.is_empty()
    }

    /// Returns the number of vertices of the mesh, including unused vertices.
    ///
    /// ```
    /// let sequence = tristrip::CollapseSequence::from_collapses(100, vec![97, 98, 99], [])?;
    /// assert_eq!((sequence.vertex_count(), sequence.triangle_count(0)?), (100, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Returns the size of the sequence in bytes.
    pub(crate) fn memory(&self) -> usize {
        let lists = [&self.triangles, &self.rename_ends, &self.dropped, &self.dropped_ends];
        let numbers: usize = lists.map(|list| size_of_val(&list[..])).iter().sum();
        let errors = size_of_val(&self.errors[..]) + size_of_val(&self.largest_errors[..]);
        numbers + errors + size_of_val(&self.renames[..])
    }

    /// Returns the triangles of the full mesh, three vertices each.
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// assert_eq!(sequence.triangles(), [0, 1, 2, 2, 1, 3, 2, 3, 4]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn triangles(&self) -> &[u32] {
        &self.triangles
    }

    /// Returns the collapse from `level` + 1 to `level`. Split `level` undoes it.
    ///
    /// # Errors
    /// `level` is not less than [`CollapseSequence::len`].
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// let first = sequence.collapse(1)?;
    /// assert_eq!((first.renames, first.dropped), (&[Rename { removed: 4, kept: 3 }][..], &[2][..]));
    /// assert!(sequence.collapse(2).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn collapse(&self, level: usize) -> Result<Collapse<'_>, Error> {
        if level < self.len() {
            return Ok(self.collapse_to(level));
        }
        let found = format!("{level} of {}", self.len());
        Err(Error::Parameter { name: "level", found, expected: "less than the level of the full mesh" })
    }

    /// Returns the collapse that leads to a valid level.
    pub(crate) fn collapse_to(&self, level: usize) -> Collapse<'_> {
        let i = self.len() - 1 - level;
        let range = |ends: &[u32]| if i == 0 { 0 } else { ends[i - 1] as usize }..ends[i] as usize;
        Collapse {
            renames: &self.renames[range(&self.rename_ends)],
            dropped: &self.dropped[range(&self.dropped_ends)],
            error: self.errors[i],
        }
    }

    /// Iterates over the collapses from the full mesh to the base mesh.
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// let removed: Vec<u32> = sequence.iter().flat_map(|collapse| collapse.renames).map(|r| r.removed).collect();
    /// assert_eq!(removed, [4, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Collapse<'_>> + DoubleEndedIterator {
        (0..self.len()).rev().map(|level| self.collapse_to(level))
    }

    /// Returns the number of triangles at a level.
    ///
    /// # Errors
    /// `level` is greater than [`CollapseSequence::len`].
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// assert_eq!((sequence.triangle_count(0)?, sequence.triangle_count(1)?, sequence.triangle_count(2)?), (1, 2, 3));
    /// assert!(sequence.triangle_count(3).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn triangle_count(&self, level: usize) -> Result<usize, Error> {
        check_level(level, self.len()).map(|()| self.triangles_at(level))
    }

    /// Returns the number of triangles drawn at a valid level.
    pub(crate) fn triangles_at(&self, level: usize) -> usize {
        let done = self.len() - level;
        let dropped = if done == 0 { 0 } else { self.dropped_ends[done - 1] as usize };
        self.triangles.len() / 3 - self.degenerate_count - dropped
    }

    /// Returns the error of a level in mesh units: the largest error of the collapses that lead to
    /// it, or 0 for the full mesh.
    ///
    /// # Errors
    /// `level` is greater than [`CollapseSequence::len`].
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// assert_eq!((sequence.error(0)?, sequence.error(1)?, sequence.error(2)?), (0.5, 0.25, 0.0));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn error(&self, level: usize) -> Result<f32, Error> {
        check_level(level, self.len()).map(|()| self.error_at(level))
    }

    /// Returns the largest error of the collapses from the full mesh to a valid level.
    pub(crate) fn error_at(&self, level: usize) -> f32 {
        let done = self.len() - level;
        if done == 0 { 0.0 } else { self.largest_errors[done - 1] }
    }

    /// Returns the highest level with at most this many triangles, or 0 if there is none.
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// assert_eq!([0, 1, 2, 1000].map(|count| sequence.level_of_triangles(count)), [0, 0, 1, 2]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn level_of_triangles(&self, triangle_count: usize) -> usize {
        let to_drop = self.triangles_at(self.len()).saturating_sub(triangle_count);
        if to_drop == 0 {
            return self.len();
        }
        let done = self.dropped_ends.partition_point(|&dropped| (dropped as usize) < to_drop) + 1;
        self.len().saturating_sub(done)
    }

    /// Returns the coarsest level with at most this error in mesh units.
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// assert_eq!([0.0, 0.25, 0.3, 0.5].map(|error| sequence.level_of_error(error)), [2, 1, 1, 0]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn level_of_error(&self, error: f32) -> usize {
        self.len() - self.largest_errors.partition_point(|&largest| largest <= error)
    }

    /// Returns the sequence with `level` as its base mesh. Coarser levels are removed.
    ///
    /// # Errors
    /// `level` is greater than [`CollapseSequence::len`].
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// let finer = sequence.clone().with_base(1)?;
    /// assert_eq!((finer.len(), finer.drawn(0)?), (1, sequence.drawn(1)?));
    /// assert!(finer.with_base(2).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn with_base(mut self, level: usize) -> Result<Self, Error> {
        check_level(level, self.len())?;
        let done = self.len() - level;
        let last = |ends: &[u32]| if done == 0 { 0 } else { ends[done - 1] as usize };
        self.renames.truncate(last(&self.rename_ends));
        self.dropped.truncate(last(&self.dropped_ends));
        self.rename_ends.truncate(done);
        self.dropped_ends.truncate(done);
        self.errors.truncate(done);
        self.largest_errors.truncate(done);
        Ok(self)
    }

    /// Returns, for each vertex, the vertex that replaces it at a level. A vertex that is still
    /// drawn maps to itself.
    ///
    /// # Errors
    /// `level` is greater than [`CollapseSequence::len`].
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// assert_eq!(sequence.renaming(1)?, [0, 1, 2, 3, 3]);
    /// assert_eq!(sequence.renaming(0)?, [0, 1, 2, 2, 2]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn renaming(&self, level: usize) -> Result<Vec<u32>, Error> {
        let mut now: Vec<u32> = (0..self.vertex_count as u32).collect();
        for &Rename { removed, kept } in self.renames_to(level)?.iter().rev() {
            now[removed as usize] = now[kept as usize];
        }
        Ok(now)
    }

    /// Returns the renames from the full mesh to a level. When they are read in reverse order, a
    /// kept vertex has its final name before the vertices that are renamed to it.
    fn renames_to(&self, level: usize) -> Result<&[Rename], Error> {
        check_level(level, self.len())?;
        let done = self.len() - level;
        let end = if done == 0 { 0 } else { self.rename_ends[done - 1] as usize };
        Ok(&self.renames[..end])
    }

    /// Returns the triangles at a level, in the order of the full mesh: vertices are renamed, and
    /// degenerate triangles are left out. This list is the oracle in the tests of all code that
    /// draws levels of detail.
    ///
    /// # Errors
    /// `level` is greater than [`CollapseSequence::len`].
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// assert_eq!(sequence.drawn(1)?, [[0, 1, 2], [2, 1, 3]]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn drawn(&self, level: usize) -> Result<Vec<[u32; 3]>, Error> {
        if self.vertex_count / SPARSE <= self.triangles.len() {
            let now = self.renaming(level)?;
            return Ok(self.renamed(|v| now[v as usize]));
        }
        let mut now: FxHashMap<u32, u32> = FxHashMap::default();
        for &Rename { removed, kept } in self.renames_to(level)?.iter().rev() {
            now.insert(removed, now.get(&kept).copied().unwrap_or(kept));
        }
        Ok(self.renamed(|v| now.get(&v).copied().unwrap_or(v)))
    }

    /// Returns the triangles of the full mesh with renamed vertices, without degenerate ones.
    fn renamed(&self, now: impl Fn(u32) -> u32) -> Vec<[u32; 3]> {
        let renamed = triangles_of(&self.triangles).map(|triangle| triangle.map(&now));
        renamed.filter(|&triangle| !is_degenerate(triangle)).collect()
    }

    /// Replays the sequence and checks that each collapse drops exactly the triangles in its list.
    ///
    /// # Errors
    /// A collapse renames an unused or already removed vertex, or renames a vertex to itself or to
    /// another removed vertex; an error is negative or NaN; the list of dropped triangles of a
    /// collapse is wrong.
    ///
    /// ```
    #[doc = include_str!("lod/example.txt")]
    /// assert!(sequence.check().is_ok());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn check(&self) -> Result<(), Error> {
        let collapses = self.iter().map(|collapse| (collapse.renames, collapse.error));
        let done = Self::from_collapses(self.vertex_count, self.triangles.clone(), collapses)?;
        let other = done.iter().zip(self.iter()).position(|(done, stated)| done.dropped != stated.dropped);
        other.map_or(Ok(()), |i| {
            Err(Error::Parameter {
                name: "collapses",
                found: format!("other triangles dropped by collapse {i} from the full mesh"),
                expected: "those that become degenerate",
            })
        })
    }
}

/// Checks that a level exists.
pub(crate) fn check_level(level: usize, highest: usize) -> Result<(), Error> {
    if level <= highest {
        return Ok(());
    }
    let found = format!("{level} of {highest}");
    Err(Error::Parameter { name: "level", found, expected: "at most the level of the full mesh" })
}
