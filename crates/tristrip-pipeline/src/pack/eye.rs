//! Weights errors by their apparent size from a viewpoint.

use tristrip::Mesh;

use crate::places::Place;

/// The weight of an error where the surface faces away from the eye. Such an error is visible only
/// at silhouettes, or when the eye moves.
const FACING_AWAY: f64 = 0.5;
/// The minimum distance from the eye, relative to the maximum. Nearer vertices have the same
/// weight.
const MIN_DISTANCE: f64 = 1.0 / 64.0;

/// Returns the weight of an error at each vertex of a mesh, seen from a position in the scene.
/// Weights depend on distance and facing; with several instances, the largest weight is used.
pub(super) fn error_factors(mesh: &Mesh, places: &[Place], eye: [f32; 3]) -> Vec<f32> {
    let eye = eye.map(f64::from);
    let normals = vertex_normals(mesh);
    let towards = |place: &Place, p: [f32; 3]| {
        let at = place.at(p);
        [0, 1, 2].map(|k| eye[k] - at[k])
    };
    let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let all = || mesh.positions().iter().flat_map(|&p| places.iter().map(move |place| (place, p)));
    let farthest = all().map(|(place, p)| length(towards(place, p))).fold(0.0, f64::max);
    if !(farthest > 0.0 && farthest.is_finite()) {
        return Vec::new();
    }
    let factor = |(&p, &normal): (&[f32; 3], &[f32; 3])| {
        let in_place = |place: &Place| {
            let towards = towards(place, p);
            let facing: f64 = place.turned(normal).iter().zip(towards).map(|(a, b)| a * b).sum();
            let near = farthest / length(towards).max(farthest * MIN_DISTANCE);
            place.scale() * if facing < 0.0 { near * FACING_AWAY } else { near }
        };
        places.iter().map(in_place).fold(0.0, f64::max) as f32
    };
    mesh.positions().iter().zip(&normals).map(factor).collect()
}

/// Returns the normal of each vertex, weighted by area and not normalized.
fn vertex_normals(mesh: &Mesh) -> Vec<[f32; 3]> {
    let mut normals = vec![[0.0_f32; 3]; mesh.vertex_count()];
    for triangle in mesh.faces().corners().chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| mesh.positions()[triangle[i] as usize]);
        let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        for &corner in triangle {
            (0..3).for_each(|k| normals[corner as usize][k] += normal[k]);
        }
    }
    normals
}
