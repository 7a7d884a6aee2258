//! The distance of the surface of a level of detail from the full mesh.

use tristrip::{Faces, Mesh, PreparedFaces};
use tristrip_pipeline::{ChangedSurface, surface_change};

use crate::failure::Failure;

/// The number of points on each surface.
const POINTS: usize = 200_000;

/// Returns the root mean square of the distances between both surfaces, in percent of the diagonal
/// of the full mesh. `triangles` has three vertices per triangle.
///
/// # Errors
/// The level is not a valid mesh.
pub fn rms_percent(full: &Mesh, positions: &[[f32; 3]], triangles: &[u32]) -> Result<f64, Failure> {
    let prepared = PreparedFaces::new(full, false);
    let first = full.vertex_count() as u32;
    let both: Vec<[f32; 3]> = full.positions().iter().chain(positions).copied().collect();
    let before = prepared.faces().fans();
    let after: Vec<u32> = triangles.iter().map(|v| first + v).collect();
    let both = Mesh::new(both, Faces::default())?;
    let surface = ChangedSurface { mesh: &both, before: &before, after: &after, texels: None };
    Ok(100.0 * surface_change(&[surface], POINTS)?.rms / diagonal(full))
}

/// Returns the diagonal of the bounding box of the used vertices.
fn diagonal(mesh: &Mesh) -> f64 {
    let (mut least, mut most) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &v in mesh.faces().corners() {
        for (j, x) in mesh.positions()[v as usize].into_iter().map(f64::from).enumerate() {
            least[j] = least[j].min(x);
            most[j] = most[j].max(x);
        }
    }
    (0..3).map(|j| (most[j] - least[j]).powi(2)).sum::<f64>().sqrt()
}
