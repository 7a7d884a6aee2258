//! Simplification by half-edge collapses, cheapest first, to any level of detail.
//!
//! The result is not one mesh but all levels: a [`CollapseSequence`], whose level 0 is the requested mesh and whose highest level is the
//! input mesh. No vertex is created or moved, so that every level is drawn from the vertices of the full mesh.
//!
//! Vertices of one position are one point. If their attributes differ they are on a seam, and collapse together along the seam or not at
//! all. If the triangles around a point are not arranged like a disk or half of one, the point stays: non-manifold edges do not change. Holes
//! do not close, and components do not merge or vanish: a mesh that allows no more collapses stops above the target triangle count, and
//! [`Stopped`] gives the reasons. Only a face that is attached by a non-manifold edge alone may be removed from that edge.
//!
//! # Algorithm
//! See the module `decimate`: quadrics in a local frame for a first order of the collapses, the distance to the new triangles for
//! their price.
//!
//! # References
//! Garland, Heckbert: *Surface Simplification Using Quadric Error Metrics*, 1997. Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient
//! Progressive Transmission of 3D Meshes*, 2005, section 5, which defines the collapses. Kobbelt, Campagna, Seidel: *A General Framework for
//! Mesh Decimation*, 1998 (half-edge collapses).
//!
//! # Complexity
//! O(n log n) time; 260 bytes per triangle while it runs, 30 of them for the result.

mod decimate;
mod frame;
mod quadric;
mod queue;
mod stopped;
#[cfg(test)]
mod tests;
mod topology;

use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::mesh::Mesh;
use decimate::Decimation;
pub use stopped::Stopped;
use topology::MOST_TRIANGLES;

/// The limits of a simplification. Without a limit a mesh is simplified as far as its topology allows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SimplifyOptions {
    triangle_count: usize,
    error: Option<f32>,
    locked: Vec<bool>,
}

impl SimplifyOptions {
    /// Stops at this number of triangles, or one fewer: a collapse drops up to two.
    #[must_use]
    pub fn with_triangles(mut self, triangle_count: usize) -> Self {
        self.triangle_count = triangle_count;
        self
    }

    /// Allows no collapse with a larger error, in mesh units; see [`Collapse::error`](crate::collapse::Collapse::error).
    #[must_use]
    pub fn with_error(mut self, error: f32) -> Self {
        self.error = Some(error);
        self
    }

    /// Locks vertices, one value per vertex; vertices after the last value are not locked.
    #[must_use]
    pub fn with_locked(mut self, locked: Vec<bool>) -> Self {
        self.locked = locked;
        self
    }
}

/// The result of a simplification.
#[derive(Debug, Clone, PartialEq)]
pub struct Simplification {
    /// The collapses from the input mesh to the requested mesh.
    pub sequence: CollapseSequence,
    /// The reasons for which there are more triangles than requested, if there are.
    pub stopped: Option<Stopped>,
}

/// Simplifies triangles over the vertices of a mesh by half-edge collapses. The mesh's own faces are ignored, so that polygons may
/// be triangulated in any way.
///
/// Triangles with a repeated vertex draw nothing and do not count; those between vertices of one position are never dropped.
///
/// # Errors
/// The number of indices is not a multiple of three, or an index is out of range; there are more than 2²⁷ triangles; the error limit is
/// negative or not a number; there are more values for locked vertices than vertices.
///
/// ```
/// use tristrip::{Faces, Mesh, simplify, simplify::SimplifyOptions};
/// // A flat grid of 4 × 4 quadrilaterals, each cut into two triangles.
/// let at = |i: u32| [(i % 5) as f32, (i / 5) as f32, 0.0];
/// let quad = |i: u32| [i, i + 1, i + 5, i + 5, i + 1, i + 6];
/// let triangles: Vec<u32> = (0..4).flat_map(|y| (0..4).flat_map(move |x| quad(5 * y + x))).collect();
/// let mesh = Mesh::new((0..25).map(at).collect::<Vec<_>>(), Faces::from_triangles(triangles.clone())?)?;
/// let simple = simplify::simplify(&mesh, triangles, &SimplifyOptions::default().with_triangles(2))?;
/// assert!(simple.stopped.is_none());
/// assert_eq!(simple.sequence.triangle_count(0)?, 2);
/// assert!(simple.sequence.error(0)? < 1e-6);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn simplify(
    mesh: &Mesh,
    triangles: Vec<u32>,
    options: &SimplifyOptions,
) -> Result<Simplification, Error> {
    if let Some(error) = options.error.filter(|error| error.is_nan() || *error < 0.0) {
        return Err(Error::Parameter { name: "error", found: error.to_string(), expected: "0 or more" });
    }
    if triangles.len() / 3 > MOST_TRIANGLES {
        let (found, limit) = (triangles.len() as u64 / 3, MOST_TRIANGLES as u64);
        return Err(Error::LimitExceeded { what: "triangles to simplify", found, limit });
    }
    if options.locked.len() > mesh.vertex_count() {
        let found = format!("{} values for {} vertices", options.locked.len(), mesh.vertex_count());
        return Err(Error::Parameter { name: "locked", found, expected: "at most one value per vertex" });
    }
    let mut sequence = CollapseSequence::new(mesh.vertex_count(), triangles)?;
    let mut decimation = Decimation::new(mesh, sequence.triangles(), &options.locked, options.error);
    decimation.run(options.triangle_count, &mut sequence);
    let reached = sequence.triangles_at(0);
    let stopped = (reached > options.triangle_count).then(|| decimation.stopped());
    Ok(Simplification { sequence, stopped })
}
