//! Simplification by half-edge collapses, cheapest first, to any level of detail.
//!
//! The result contains the requested mesh and all finer levels as a [`CollapseSequence`]. Level 0
//! is the requested mesh, and the highest level is the input mesh. No vertex is created or moved,
//! so every level is drawn with the vertices of the full mesh.
//!
//! Vertices at the same position form one point. If their attributes differ, the point lies on a
//! seam: its vertices collapse together along the seam or not at all. Holes are not closed and
//! components are not merged. If no more collapses are allowed, simplification stops above the
//! target triangle count, and [`Stopped`] gives the reasons. On non-manifold surfaces, points on
//! edges with three or more triangles move along these edges. Triangles attached only by such an
//! edge can be removed. Components are removed only if the caller gives the error of their removal.
//! Permissive simplification can close holes and move seams onto other seams.
//!
//! # Algorithm
//! By default, quadrics in a local frame determine an initial order of the collapses. The price of
//! a collapse is then computed from the distances of all removed vertices to the triangles
//! (`order/decimate`). [`Price::Quadric`] runs the published algorithm (`order/queue`). With the
//! feature `rayon`, several threads compute prices; the result is the same.
//!
//! # References
//! Garland, Heckbert: *Surface Simplification Using Quadric Error Metrics*, 1997. Kim, Park, Yang,
//! Neelamkavil: *A Rendering-Efficient Progressive Transmission of 3D Meshes*, 2005, section 5,
//! which defines the collapses. Kobbelt, Campagna, Seidel: *A General Framework for Mesh
//! Decimation*, 1998 (half-edge collapses).
//!
//! # Complexity
//! O(n log n) time. 270 bytes per triangle during simplification, 30 of them for the result. Priced
//! attributes add 92 bytes per vertex and 36 bytes per value.

mod options;
mod order;
mod price;
mod surface;
#[cfg(test)]
mod tests;

use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::ids::vertices_of;
use crate::index::Index;
use crate::mesh::{Faces, Mesh, Positions, attribute_bits, check_positions};
use crate::prepare::PreparedFaces;
pub use crate::vector::nearest_in_triangle;
pub use options::{AttributeWeights, Price, SimplifyOptions};
use order::decimate::Decimation;
pub use order::joined::{JoinedSimplification, SurfaceSimplifier, simplify_joined};
pub use order::merge_tree::{MergeOrder, MergeTree, merge_tree, refinement_batches};
pub use order::stopped::Stopped;
use price::attributes::PricedAttributes;

/// The collapses of a simplification.
#[derive(Debug, Clone, PartialEq)]
pub struct Simplification {
    /// The collapses from the input mesh to the requested mesh.
    pub sequence: CollapseSequence,
    /// Why the mesh has more triangles than requested; `None` if the target was reached.
    pub stopped: Option<Stopped>,
}

/// A simplified mesh.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Simplified {
    /// The simplified mesh. It contains only the vertices that it uses, with their attributes.
    pub mesh: Mesh,
    /// For each vertex of `mesh`, its index in the input mesh; ascending.
    pub vertices: Vec<u32>,
    /// The collapses over the vertices of the input mesh, and the reasons if they stopped early.
    pub simplification: Simplification,
}

/// Simplifies a mesh by half-edge collapses. Polygons are triangulated; degenerate faces and unused
/// vertices are removed.
///
/// # Errors
/// There are more than 2²⁷ triangles; the error limit is negative or NaN; another option is out of
/// range; an option has more per-vertex values than the mesh has vertices.
///
/// ```
/// use tristrip::{Faces, Mesh, simplify::{SimplifyOptions, simplify}};
/// // A flat fan of four triangles around vertex 4, which one collapse removes.
/// let corners = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 0.0]];
/// let mesh = Mesh::new(corners, Faces::from_triangles(vec![0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4])?)?;
/// let simple = simplify(&mesh, &SimplifyOptions::default().with_triangles(2))?;
/// assert_eq!((simple.mesh.faces().face_count(), simple.mesh.vertex_count()), (2, 4));
/// assert_eq!(simple.vertices, [0, 1, 2, 3]);
/// assert_eq!(simple.simplification.sequence.len(), 1);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn simplify(mesh: &Mesh, options: &SimplifyOptions) -> Result<Simplified, Error> {
    let prepared = PreparedFaces::new(mesh, false);
    let simplification = simplify_triangles(mesh, prepared.faces().fans().into_owned(), options)?;
    let base = Faces::from_triangles(simplification.sequence.drawn(0)?.into_flattened())?;
    let (mesh, vertices) = mesh.with_faces(base)?.without_unused_vertices();
    Ok(Simplified { mesh, vertices, simplification })
}

/// Simplifies triangles over the vertices of a mesh by half-edge collapses. The mesh's own faces
/// are ignored, so the caller can triangulate polygons in any way.
///
/// Triangles with a repeated vertex draw nothing and are not counted. Triangles between different
/// vertices at the same position are never dropped.
///
/// # Errors
/// The number of indices is not a multiple of three; an index is out of range; there are more than
/// 2²⁷ triangles; the error limit is negative or NaN; another option is out of range; an option has
/// more per-vertex values than the mesh has vertices.
///
/// ```
/// use tristrip::{Faces, Mesh, simplify::{SimplifyOptions, simplify_triangles}};
/// // A flat grid of 4 × 4 quads, each split into two triangles.
/// let at = |i: u32| [(i % 5) as f32, (i / 5) as f32, 0.0];
/// let quad = |i: u32| [i, i + 1, i + 5, i + 5, i + 1, i + 6];
/// let triangles: Vec<u32> = (0..4).flat_map(|y| (0..4).flat_map(move |x| quad(5 * y + x))).collect();
/// let mesh = Mesh::new((0..25).map(at).collect::<Vec<_>>(), Faces::from_triangles(triangles.clone())?)?;
/// let simple = simplify_triangles(&mesh, triangles, &SimplifyOptions::default().with_triangles(2))?;
/// assert!(simple.stopped.is_none());
/// assert_eq!(simple.sequence.triangle_count(0)?, 2);
/// assert!(simple.sequence.error(0)? < 1e-6);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn simplify_triangles(
    mesh: &Mesh,
    triangles: Vec<u32>,
    options: &SimplifyOptions,
) -> Result<Simplification, Error> {
    options.check(mesh.vertex_count(), triangles.len())?;
    let sequence = CollapseSequence::new(mesh.vertex_count(), triangles)?;
    let bits = |v| attribute_bits(mesh, v as usize);
    let priced = |triangles: &[u32], unit| PricedAttributes::new(mesh, triangles, unit, options.weights);
    Ok(run(sequence, mesh.positions(), bits, priced, options))
}

/// Simplifies the triangles of an index buffer by half-edge collapses. Indices are 8, 16 or 32 bits
/// wide or `usize`, three per triangle. Positions are not changed. Vertices that share a position
/// are assumed to differ in other attributes, so they are kept together as a seam.
///
/// # Errors
/// The number of indices is not a multiple of three; an index is out of range; there are more than
/// 2²⁷ triangles; an option is invalid; a position is not finite.
///
/// ```
/// use tristrip::InterleavedPositions;
/// use tristrip::simplify::{SimplifyOptions, simplify_indices};
/// // Four floats per vertex: a position and a shade. A flat fan of four triangles around vertex 4.
/// let vertices = [0., 0., 0., 9., 2., 0., 0., 9., 2., 2., 0., 9., 0., 2., 0., 9., 1., 1., 0., 9.];
/// let indices = [0_u16, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4];
/// let positions = InterleavedPositions::from_floats(&vertices, 4, 0)?;
/// let simple = simplify_indices(&indices, &positions, &SimplifyOptions::default().with_triangles(2))?;
/// assert_eq!(simple.sequence.drawn(0)?.len(), 2);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn simplify_indices<I: Index, P: Positions + ?Sized>(
    indices: &[I],
    positions: &P,
    options: &SimplifyOptions,
) -> Result<Simplification, Error> {
    options.check(positions.vertex_count(), indices.len())?;
    let sequence = CollapseSequence::new(positions.vertex_count(), vertices_of(indices)?)?;
    check_positions(sequence.triangles(), positions)?;
    Ok(run(sequence, positions, |v| v.to_le_bytes().to_vec(), |_, _| None, options))
}

/// Simplifies a sequence that has no collapses yet.
fn run<P: Positions + ?Sized>(
    mut sequence: CollapseSequence,
    positions: &P,
    attribute_bits: impl Fn(u32) -> Vec<u8>,
    priced: impl FnOnce(&[u32], f64) -> Option<PricedAttributes>,
    options: &SimplifyOptions,
) -> Simplification {
    let mut decimation =
        Decimation::new(positions, attribute_bits, sequence.triangles(), priced, options, &[]);
    let is_reached = decimation.run(options.triangle_count, &mut sequence);
    let stopped = (!is_reached).then(|| decimation.stopped());
    decimation.finish(options.triangle_count, &mut sequence);
    Simplification { sequence, stopped }
}
