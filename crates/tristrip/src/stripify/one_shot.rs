//! Strips in one call: from a mesh, from an index buffer without positions, or from polygons over
//! positions in the caller's memory.

use super::{StripifyOptions, Watch, plan_known};
use crate::dual::DualGraph;
use crate::error::Error;
use crate::ids::vertices_of;
use crate::index::Index;
use crate::mesh::{Faces, Mesh, Positions, SPARSE, VertexSubset, check_corners};
use crate::prepare::PreparedFaces;
use crate::strip::Strips;

/// Computes triangle strips for a mesh. Runs all stages from faces to strips.
///
/// # Errors
/// An option is invalid for the method.
///
/// ```
/// use tristrip::{Faces, Mesh, StripifyOptions, stripify, verify::verify};
/// let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = Mesh::new(corners, Faces::from_polygons([[0, 1, 2, 3]])?)?;
/// let strips = stripify(&mesh, &StripifyOptions::default())?;
/// assert_eq!(strips.vertices_sent(), 4);
/// assert!(verify(&mesh, &strips).is_ok());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn stripify(mesh: &Mesh, options: &StripifyOptions) -> Result<Strips, Error> {
    let prepared = PreparedFaces::new(mesh, options.weld);
    let graph = DualGraph::new(prepared.faces());
    Ok(plan_known(&prepared, &graph, options, &())?.strips())
}

/// Computes triangle strips for an index buffer with three indices per triangle, with the default
/// options. Indices are integers of 8, 16 or 32 bits or `usize`. Triangles with a repeated vertex
/// draw nothing and are omitted.
///
/// # Errors
/// The number of indices is not a multiple of three, or an index is not less than `vertex_count`.
///
/// ```
/// use tristrip::Layout;
/// let indices: [u16; 12] = [0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5];
/// let strips = tristrip::stripify_indices(&indices, 6)?;
/// let buffer: Vec<u16> = strips.to_indices(Layout::Restart)?;
/// assert_eq!(buffer.len(), 6);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn stripify_indices<I: Index>(indices: &[I], vertex_count: usize) -> Result<Strips, Error> {
    stripify_indices_with(indices, vertex_count, &StripifyOptions::default())
}

/// Computes triangle strips for an index buffer like [`stripify_indices`], with options.
///
/// # Errors
/// The number of indices is not a multiple of three, an index is not less than `vertex_count`, an
/// option is invalid for the method, or welding is requested (welding needs positions).
///
/// ```
/// use tristrip::{Method, StripifyOptions, stripify_indices_with};
/// let options = StripifyOptions::default().with_method(Method::Cache);
/// let strips = stripify_indices_with(&[0_u32, 1, 2, 2, 1, 3], 4, &options)?;
/// assert_eq!(strips.vertices_sent(), 4);
/// assert!(stripify_indices_with(&[0_u32, 1, 2], 2, &options).is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn stripify_indices_with<I: Index>(
    indices: &[I],
    vertex_count: usize,
    options: &StripifyOptions,
) -> Result<Strips, Error> {
    stripify_indices_watched(indices, vertex_count, options, &())
}

/// Computes triangle strips for an index buffer like [`stripify_indices_with`], and reports the
/// progress of the search to `watch`, which may stop the search.
///
/// # Errors
/// The number of indices is not a multiple of three, an index is not less than `vertex_count`, an
/// option is invalid for the method, or welding is requested (welding needs positions).
///
/// ```
/// use tristrip::stripify::Progress;
/// use tristrip::{StripifyOptions, stripify_indices_watched};
/// let stop_at_once = |_: Progress| false;
/// let strips = stripify_indices_watched(&[0_u32, 1, 2, 2, 1, 3], 4, &StripifyOptions::default(), &stop_at_once)?;
/// assert_eq!(strips.triangles().count(), 2);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn stripify_indices_watched<I: Index>(
    indices: &[I],
    vertex_count: usize,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> Result<Strips, Error> {
    check_no_weld(options)?;
    let faces = Faces::from_triangles(vertices_of(indices)?)?;
    check_corners(faces.corners(), vertex_count)?;
    let highest = faces.corners().iter().max().map_or(0, |&v| v as usize);
    if highest / SPARSE < faces.corner_count() {
        return strips_of(&PreparedFaces::of_triangles(&faces, highest + 1), options, watch);
    }
    // Few of the vertices are used: renumber them in order, because some methods allocate arrays
    // per vertex.
    let used = VertexSubset::of(faces.corners());
    let faces = faces.renamed(used.numbers(faces.corners()));
    let strips = strips_of(&PreparedFaces::of_triangles(&faces, used.len()), options, watch)?;
    Ok(strips.map_vertices(|v| used.vertices()[v as usize]))
}

/// Computes triangle strips for faces of any size over positions in the caller's memory. Positions
/// are not copied.
///
/// # Errors
/// A face refers to a vertex without a finite position, an option is invalid for the method, or
/// welding is requested (welding needs all attributes).
///
/// ```
/// use tristrip::{Faces, StripifyOptions, InterleavedPositions, stripify_faces};
/// // Two quadrilaterals; each vertex has a position and a shade.
/// let vertices: Vec<f32> = (0..6).flat_map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0, 9.0]).collect();
/// let positions = InterleavedPositions::from_floats(&vertices, 4, 0)?;
/// let faces = Faces::from_polygons([[0, 2, 3, 1], [2, 4, 5, 3]])?;
/// let strips = stripify_faces(&faces, &positions, &StripifyOptions::default())?;
/// assert_eq!((strips.len(), strips.vertices_sent()), (1, 6));
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn stripify_faces<P: Positions + ?Sized>(
    faces: &Faces,
    positions: &P,
    options: &StripifyOptions,
) -> Result<Strips, Error> {
    check_no_weld(options)?;
    strips_of(&PreparedFaces::of_faces(faces, positions)?, options, &())
}

/// Computes the strips of prepared faces.
fn strips_of(
    prepared: &PreparedFaces<'_>,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> Result<Strips, Error> {
    let graph = DualGraph::new(prepared.faces());
    Ok(plan_known(prepared, &graph, options, watch)?.strips())
}

/// Checks that welding is not requested; it needs a mesh.
fn check_no_weld(options: &StripifyOptions) -> Result<(), Error> {
    if options.weld {
        let found = "true for vertices without attributes".into();
        return Err(Error::Parameter { name: "weld", found, expected: "false, or a mesh" });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::stripify::{Method, generated_meshes, stripify};
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 4))]

        /// An index buffer has the same strips as the mesh with its triangles.
        #[test]
        fn indices_get_the_strips_of_their_mesh(polygons in generated_meshes::polygons(true, 1..4)) {
            let list: Vec<u32> = polygons.iter().filter(|p| p.len() == 3).flatten().copied().collect();
            let vertex_count = list.iter().max().map_or(0, |&v| v as usize + 1);
            let mesh = Mesh::new(vec![[0.0; 3]; vertex_count], Faces::from_triangles(list.clone()).unwrap()).unwrap();
            for method in Method::ALL {
                let options = StripifyOptions::default().with_method(*method);
                let found = stripify_indices_with(&list, vertex_count, &options).unwrap();
                prop_assert_eq!(found, stripify(&mesh, &options).unwrap());
            }
        }
    }

    #[test]
    fn faces_over_borrowed_positions_get_the_strips_of_their_mesh() {
        let positions = [[0.0; 3], [2.0, 1.0, 0.0], [0.0, 2.0, 0.0], [0.5, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let faces = Faces::from_polygons([vec![0, 1, 2, 3], vec![0, 3, 2, 4], vec![4, 4, 0]]).unwrap();
        let mesh = Mesh::new(positions.to_vec(), faces.clone()).unwrap();
        let options = StripifyOptions::default();
        let found = stripify_faces(&faces, &positions, &options).unwrap();
        assert_eq!(found, stripify(&mesh, &options).unwrap());
        assert!(crate::verify::verify(&mesh, &found).is_ok());
        assert!(stripify_faces(&faces, &positions[1..], &options).is_err());
        assert!(stripify_faces(&faces, &positions.map(|_| [f32::NAN; 3]), &options).is_err());
        assert!(stripify_faces(&faces, &positions, &options.with_weld(true)).is_err());
    }

    #[test]
    fn wrong_buffers_are_refused_with_the_place() {
        let message = |result: Result<Strips, Error>| result.unwrap_err().to_string();
        assert_eq!(
            message(stripify_indices(&[0_u8, 1, 2, 1, 9, 2], 9)),
            "face 1, corner 1: found vertex index 9, expected less than 9"
        );
        assert_eq!(
            message(stripify_indices(&[0_u16, 1], 9)),
            "faces: number of corners: found 2, expected a multiple of 3"
        );
        let weld = StripifyOptions::default().with_weld(true);
        assert!(message(stripify_indices_with(&[0_u16, 1, 2], 3, &weld)).starts_with("parameter `weld`"));
        assert!(stripify_indices::<usize>(&[], 0).unwrap().is_empty());
        #[cfg(target_pointer_width = "64")]
        assert_eq!(
            message(stripify_indices(&[0, 1, usize::MAX], 9)),
            "parameter `indices`: found 18446744073709551615 at 2, expected indices of at most 32 bits"
        );
    }
}
