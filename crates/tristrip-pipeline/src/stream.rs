//! A mesh as a stream: the input of the chunk encoder, for any mesh.
//!
//! # Algorithm
//! 1. Weld equal vertices. Triangulate polygons, and drop triangles with two corners at one
//!    position, because they draw nothing.
//! 2. Find the collapses in batches. Where a surface touches itself or attributes differ, a stream
//!    cannot undo some collapses. Lock the vertices of these collapses and search again. Repeat
//!    this a few times.
//! 3. The base mesh keeps the vertices of collapses that still cannot be undone.

use tristrip::Mesh;
use tristrip::PreparedFaces;
use tristrip::simplify::{MergeTree, SimplifyOptions, refinement_batches};
use tristrip::stream::{EncodedStream, StreamOptions, encode, unsplittable};

use crate::error::Error;

/// The maximum number of searches for collapses. The test models need up to five.
const MAX_SEARCHES: usize = 8;

/// A mesh as a stream, with counts.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct StreamedMesh {
    /// The chunks.
    pub stream: EncodedStream,
    /// The number of triangles of the full mesh.
    pub triangles: usize,
    /// The number of used vertices, after welding.
    pub vertices: usize,
    /// The number of triangles that were dropped because two corners have the same position.
    pub dropped_triangles: usize,
    /// The number of batches of collapses.
    pub batches: usize,
    /// The number of locked vertices: their collapses could not be undone, or they touch other
    /// meshes.
    pub locked_vertices: usize,
}

/// Encodes a mesh as the mesh with index `number` of a stream.
///
/// # Errors
/// The mesh is too large, or an attribute value cannot be encoded.
///
/// ```
/// use tristrip::stream::{Decoder, StreamLimits, StreamOptions};
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::stream_of_mesh;
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
/// let streamed = stream_of_mesh(&model.parts[0].mesh, 0, &StreamOptions::default())?;
/// let mut decoder = Decoder::new(StreamLimits::default());
/// decoder.update(&streamed.stream.bytes()).map_err(|error| tristrip_pipeline::Error::unproven(error.to_string()))?;
/// assert_eq!(decoder.part(0).map(|part| part.triangle_count()), Some(4));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn stream_of_mesh(mesh: &Mesh, number: u32, options: &StreamOptions) -> Result<StreamedMesh, Error> {
    stream_with(mesh, &SimplifyOptions::default(), number, options)
}

/// Encodes a mesh like [`stream_of_mesh`], with collapse options: the vertices that stay in the
/// base mesh, and the weights of errors.
pub(crate) fn stream_with(
    mesh: &Mesh,
    simplify: &SimplifyOptions,
    number: u32,
    options: &StreamOptions,
) -> Result<StreamedMesh, Error> {
    let (triangles, dropped_triangles) = drawn_triangles(mesh);
    let (tree, locked) = splittable_batches(mesh, &triangles, simplify)?;
    Ok(StreamedMesh {
        stream: encode(mesh, &tree.sequence, &tree.level_ends, number, options)?,
        triangles: triangles.len() / 3,
        vertices: used_vertices(&triangles),
        dropped_triangles,
        batches: tree.level_ends.len(),
        locked_vertices: locked.into_iter().filter(|&is_locked| is_locked).count(),
    })
}

/// Returns the triangles of a mesh over welded vertices, and the number of dropped triangles that
/// draw nothing.
pub(crate) fn drawn_triangles(mesh: &Mesh) -> (Vec<u32>, usize) {
    let prepared = PreparedFaces::new(mesh, true);
    let all = prepared.faces().fans();
    // −0 and 0 are the same position.
    let place = |v: u32| mesh.positions()[v as usize].map(|x| (x + 0.0).to_bits());
    let draws = |t: &&[u32]| {
        let [a, b, c] = [t[0], t[1], t[2]].map(place);
        a != b && b != c && c != a
    };
    let drawn: Vec<u32> = all.chunks_exact(3).filter(draws).flatten().copied().collect();
    // The preparation drops faces, too: those whose corners are equal after welding.
    let dropped = mesh.faces().fans().len().saturating_sub(drawn.len()) / 3;
    (drawn, dropped)
}

/// Counts the vertices that triangles use.
pub(crate) fn used_vertices(triangles: &[u32]) -> usize {
    let mut used = triangles.to_vec();
    used.sort_unstable();
    used.dedup();
    used.len()
}

/// Finds collapses that a stream can undo, and returns the vertices that had to be locked.
fn splittable_batches(
    mesh: &Mesh,
    triangles: &[u32],
    simplify: &SimplifyOptions,
) -> Result<(MergeTree, Vec<bool>), Error> {
    let mut locked = simplify.locked.clone();
    locked.resize(mesh.vertex_count(), false);
    let batches = |locked: &[bool]| {
        let options = simplify.clone().with_locked(locked.to_vec());
        refinement_batches(mesh, triangles.to_vec(), &options)
    };
    for _ in 1..MAX_SEARCHES {
        let tree = batches(&locked)?;
        let found = unsplittable(&tree.sequence);
        if found.is_empty() {
            return Ok((tree, locked));
        }
        found.into_iter().for_each(|vertex| locked[vertex as usize] = true);
    }
    Ok((batches(&locked)?, locked))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::stream::{Decoder, StreamLimits};
    use tristrip::{Attribute, AttributeData, Faces};

    /// A grid with a striped texture: the vertices between two stripes have two texture
    /// coordinates.
    fn striped(n: u32) -> Mesh {
        let (mut positions, mut texture, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        for y in 0..n {
            for x in 0..n {
                let first = positions.len() as u32;
                for [u, v] in [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]] {
                    positions.push([u as f32, v as f32, (u * v % 3) as f32 * 0.1]);
                    texture.extend([u as f32 + (x / 4 * 100) as f32, v as f32]);
                }
                triangles.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
                // A triangle that draws nothing.
                triangles.extend([first, first + 1, first]);
            }
        }
        let mesh = Mesh::new(positions, Faces::from_triangles(triangles).unwrap()).unwrap();
        let data = AttributeData::F32(texture);
        mesh.with_attribute(Attribute { name: "TEXCOORD_0".into(), components: 2, normalized: false, data })
            .unwrap()
    }

    #[test]
    fn seams_of_meshes_without_shared_vertices_are_refined() {
        let mesh = striped(16);
        let streamed = stream_of_mesh(&mesh, 0, &StreamOptions::default()).unwrap();
        assert_eq!(streamed.triangles, 2 * 16 * 16);
        assert!(streamed.stream.base.len() / 3 < 100, "{}", streamed.stream.base.len() / 3);
        let mut decoder = Decoder::new(StreamLimits::default());
        decoder.update(&streamed.stream.bytes()).unwrap();
        let full = decoder.part(0).unwrap();
        // 17 columns of 17 vertices, and three duplicated columns.
        assert_eq!((full.triangle_count(), full.vertex_count()), (512, 20 * 17));
        let again = full.mesh().unwrap();
        let uv = &again.attributes()[0];
        for (v, p) in again.positions().iter().enumerate() {
            let u = uv.float(2 * v).unwrap();
            assert!((u.rem_euclid(100.0) - p[0]).abs() < 0.1, "{u} at {p:?}");
        }
    }

    #[test]
    fn triangles_within_one_position_are_left_out() {
        // Two vertices at one position with different shades, and a triangle between them.
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -0.0, 0.0]];
        let mesh = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2, 0, 3, 1]).unwrap()).unwrap();
        let data = AttributeData::U8(vec![1, 2, 3, 4]);
        let mesh =
            mesh.with_attribute(Attribute { name: "shade".into(), components: 1, normalized: true, data });
        let streamed = stream_of_mesh(&mesh.unwrap(), 0, &StreamOptions::default()).unwrap();
        assert_eq!((streamed.triangles, streamed.dropped_triangles), (1, 1));
    }
}
