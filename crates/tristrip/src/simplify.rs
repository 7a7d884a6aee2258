//! Simplification: half-edge collapses, cheapest first, from a mesh to as coarse a one as is asked for.
//!
//! What comes out is not a mesh but all of them: a [`CollapseSequence`], whose level 0 is the mesh asked for and whose highest level is the mesh
//! given. No vertex is made or moved, so that every level draws from the vertices of the full mesh.
//!
//! Vertices of one position are one point. Where their attributes differ they lie on a seam, and go together or not at all, along it. Where triangles
//! do not lie around a point like a disk or half of one, the point stays: non-manifold edges are as they were. Holes do not close, parts
//! do not join or vanish: a mesh that allows no more stops above the number of triangles asked for, and [`Stopped`] says why. The one thing that
//! may go from a non-manifold edge is a face that hangs on it alone.
//!
//! # Algorithm
//! See the module `decimate`: quadrics in a local frame for a first order of the collapses, the distance to the new triangles for
//! their price.
//!
//! # References
//! Garland, Heckbert: *Surface Simplification Using Quadric Error Metrics*, 1997. Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient
//! Progressive Transmission of 3D Meshes*, 2005, section 5, whose collapses they are. Kobbelt, Campagna, Seidel: *A General Framework for
//! Mesh Decimation*, 1998 (half-edge collapses).
//!
//! # Complexity
//! O(n log n) time; 260 bytes a triangle while it runs, of which 30 stay.

mod decimate;
mod quadric;
mod queue;
#[cfg(test)]
mod tests;
mod topology;

use std::fmt;

use crate::collapse::CollapseSequence;
use decimate::Decimation;
use topology::MOST_TRIANGLES;

use crate::error::Error;
use crate::mesh::Mesh;

/// How far a mesh is simplified. Without a limit: as far as its topology allows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SimplifyOptions {
    triangle_count: usize,
    error: Option<f32>,
    locked: Vec<bool>,
}

impl SimplifyOptions {
    /// Stops at so many triangles, or one fewer: a collapse drops up to two.
    #[must_use]
    pub fn with_triangles(mut self, triangle_count: usize) -> Self {
        self.triangle_count = triangle_count;
        self
    }

    /// Allows no collapse with a greater error, in mesh units; see [`Collapse::error`].
    #[must_use]
    pub fn with_error(mut self, error: f32) -> Self {
        self.error = Some(error);
        self
    }

    /// Says which vertices stay, one value a vertex; those after the last value may go.
    #[must_use]
    pub fn with_locked(mut self, locked: Vec<bool>) -> Self {
        self.locked = locked;
        self
    }
}

/// What a simplification has come to.
#[derive(Debug, Clone, PartialEq)]
pub struct Simplification {
    /// The collapses, from the mesh given to the mesh asked for.
    pub sequence: CollapseSequence,
    /// Why there are more triangles than were asked for, if there are.
    pub stopped: Option<Stopped>,
}

/// What kept a simplification from going on: points that are left, by what holds them. Where several things do, by the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Stopped {
    /// The triangles that are left.
    pub triangle_count: usize,
    /// Points that the caller locked.
    pub locked: usize,
    /// Points where triangles do not lie like a disk or half of one.
    pub non_manifold: usize,
    /// Points on seams, that would tear them.
    pub seam: usize,
    /// Points that would close a hole, pinch the surface, or take away the last triangles of a component.
    pub topology: usize,
    /// Points that would turn a triangle over.
    pub fold_over: usize,
    /// Points that would exceed the error allowed.
    pub error: usize,
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "stopped at {} triangles", self.triangle_count)?;
        let reasons = [
            (self.locked, "locked"),
            (self.non_manifold, "not manifold"),
            (self.seam, "held by seams"),
            (self.topology, "held by the topology"),
            (self.fold_over, "would fold over"),
            (self.error, "would exceed the error allowed"),
        ];
        let mut separator = "; vertices left: ";
        for (count, reason) in reasons.iter().filter(|(count, _)| *count > 0) {
            write!(f, "{separator}{count} {reason}")?;
            separator = ", ";
        }
        Ok(())
    }
}

/// Simplifies triangles over the vertices of a mesh, by half-edge collapses. The mesh's own faces are not looked at, so that polygons may
/// be cut in any way.
///
/// Triangles with a vertex twice draw nothing and do not count; those between vertices of one position stay to the end.
///
/// # Errors
/// The indices are not a multiple of three, or one is of no vertex; there are more than 2²⁷ triangles; an error allowed is not a number, or
/// negative.
///
/// ```
/// use tristrip::{Faces, Mesh, simplify, simplify::SimplifyOptions};
/// // A flat grid of 4 × 4 quadrilaterals, each cut in two.
/// let at = |i: u32| [(i % 5) as f32, (i / 5) as f32, 0.0];
/// let quad = |i: u32| [i, i + 1, i + 5, i + 5, i + 1, i + 6];
/// let triangles: Vec<u32> = (0..4).flat_map(|y| (0..4).flat_map(move |x| quad(5 * y + x))).collect();
/// let mesh = Mesh::new((0..25).map(at).collect::<Vec<_>>(), Faces::from_triangles(triangles.clone())?)?;
/// let simple = simplify::simplify(&mesh, triangles, &SimplifyOptions::default().with_triangles(2))?;
/// assert!(simple.stopped.is_none());
/// assert_eq!(simple.sequence.triangle_count(0), 2);
/// assert!(simple.sequence.error(0) < 1e-6);
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
    let mut sequence = CollapseSequence::new(mesh.vertex_count(), triangles)?;
    let mut decimation = Decimation::new(mesh, sequence.triangles(), &options.locked, options.error);
    decimation.run(options.triangle_count, &mut sequence);
    let reached = sequence.triangle_count(0);
    let stopped = (reached > options.triangle_count).then(|| decimation.stopped());
    Ok(Simplification { sequence, stopped })
}
