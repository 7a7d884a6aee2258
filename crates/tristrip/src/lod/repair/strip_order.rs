//! Lists the triangles of the full mesh in the order of its strips, as input for `repair`.

use crate::collapse::CollapseSequence;
use crate::cover::priced::TRIANGLE_LIMIT;
use crate::error::Error;
use crate::lod::level::level_mesh::LevelMesh;
use crate::mesh::canonical_triangle;
use crate::strip::{Strips, strip_triangles};
use crate::text::counted;

/// Checks that corners and vertices fit into one 32-bit numbering.
pub(super) fn check_size(sequence: &CollapseSequence) -> Result<(), Error> {
    let (triangles, vertices) = (sequence.triangles().len() / 3, sequence.vertex_count());
    let over = |what, found: usize, limit: usize| {
        if found <= limit {
            Ok(())
        } else {
            Err(Error::LimitExceeded { what, found: found as u64, limit: limit as u64 })
        }
    };
    over("triangles", triangles, TRIANGLE_LIMIT)?;
    over("corners and vertices", 3 * triangles + vertices, u32::MAX as usize - 1)
}

/// A triangle of the full mesh in a strip.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct StripTriangle {
    pub(super) strip: u32,
    pub(super) triangle: u32,
    /// The half-edge where the strip enters, numbered by fours.
    pub(super) entry: u32,
}

/// Returns the triangles of the full mesh in the order in which the strips draw them.
pub(super) fn order_of(strips: &Strips, mesh: &LevelMesh) -> Result<Vec<StripTriangle>, Error> {
    let mut known: Vec<([u32; 3], u32)> = (0..mesh.triangle_count() as u32)
        .filter(|&t| mesh.is_drawn(t))
        .map(|t| (canonical_triangle(mesh.triangle(t)), t))
        .collect();
    known.sort_unstable();
    let drawn = strips.iter().zip(0..).flat_map(|(strip, s)| strip_triangles(strip).map(move |t| (t, s)));
    let mut drawn: Vec<([u32; 3], usize, u32, u32)> = drawn
        .enumerate()
        .map(|(i, (triangle, s))| (canonical_triangle(triangle), i, s, triangle[0]))
        .collect();
    drawn.sort_unstable();
    if !known.iter().map(|known| known.0).eq(drawn.iter().map(|drawn| drawn.0)) {
        return Err(Error::Parameter {
            name: "strips",
            found: format!("{}, not all of the full mesh", counted(drawn.len(), "triangle")),
            expected: "strips that draw the full mesh",
        });
    }
    let mut order = vec![StripTriangle::default(); known.len()];
    for (&(_, i, strip, first), &(_, t)) in drawn.iter().zip(&known) {
        let entry = (4 * t..).zip(mesh.triangle(t)).find(|&(_, v)| v == first).map_or(4 * t, |(h, _)| h);
        order[i] = StripTriangle { strip, triangle: t, entry };
    }
    Ok(order)
}
