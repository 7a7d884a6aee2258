//! Scaling: the time of `sequential` per triangle while a model is subdivided, from its own size to
//! more than eight million triangles.
//!
//! # Algorithm
//! Each triangle becomes four over the midpoints of its edges, which neighbours share. The four are
//! stored together, so the memory order is equally coherent at every level.
//!
//! ```text
//!        c
//!       / \
//!     ca───bc     (a, ab, ca)  (ab, b, bc)  (ca, bc, c)  (ab, bc, ca)
//!     / \ / \
//!    a───ab──b
//! ```

use std::time::Instant;

use serde::Serialize;
use tristrip::verify::verify;
use tristrip::{DualGraph, Faces, Mesh, Method, StripifyOptions, stripify};

use crate::failure::Failure;
use crate::measure::median;

/// The number of triangles for which the time per triangle has a target.
pub const LARGE: usize = 8_000_000;
/// The number of triangles of the level that it is compared with.
pub const SMALL: usize = 100_000;

/// One level of a subdivided model.
#[derive(Debug, Clone, Serialize)]
pub struct ScalingLevel {
    /// The number of triangles.
    pub triangles: usize,
    /// The number of indices with restarts per triangle.
    pub indices_restart_per_triangle: f64,
    /// The median time per triangle, in nanoseconds.
    pub nanoseconds_per_triangle: f64,
}

/// The levels of a model.
#[derive(Debug, Clone, Serialize)]
pub struct Scaling {
    /// The name of the model.
    pub model: String,
    /// The levels, from the model itself to the first level of at least [`LARGE`] triangles.
    pub levels: Vec<ScalingLevel>,
}

impl Scaling {
    /// Returns the time per triangle of the last level relative to the level nearest to [`SMALL`].
    pub fn ratio(&self) -> Option<f64> {
        let far = |level: &ScalingLevel| (level.triangles as f64 / SMALL as f64).ln().abs();
        let small = self.levels.iter().min_by(|a, b| far(a).total_cmp(&far(b)))?;
        let large = self.levels.last().filter(|level| level.triangles >= LARGE)?;
        Some(large.nanoseconds_per_triangle / small.nanoseconds_per_triangle)
    }
}

/// Measures a triangle mesh at every level.
///
/// # Errors
/// A result is not proven, or a level has more vertices than ids.
pub fn scale(model: &str, mesh: Mesh, rounds: usize) -> Result<Scaling, Failure> {
    let options = StripifyOptions::default().with_method(Method::Sequential);
    let mut levels = Vec::new();
    let mut mesh = mesh;
    loop {
        let triangles = mesh.faces().face_count();
        let strips = stripify(&mesh, &options)?;
        verify(&mesh, &strips).map_err(|error| format!("{model}, {triangles} triangles: {error}"))?;
        let cost = strips.vertices_sent() + strips.len() - 1;
        drop(strips);
        let mut times = Vec::new();
        for _ in 0..rounds {
            let start = Instant::now();
            stripify(&mesh, &options)?;
            times.push(start.elapsed().as_secs_f64());
        }
        levels.push(ScalingLevel {
            triangles,
            indices_restart_per_triangle: cost as f64 / triangles as f64,
            nanoseconds_per_triangle: 1e9 * median(times) / triangles as f64,
        });
        if triangles >= LARGE {
            return Ok(Scaling { model: model.into(), levels });
        }
        mesh = subdivide(&mesh)?;
    }
}

/// Subdivides every triangle into four.
///
/// # Errors
/// The mesh has faces other than triangles, or the result has more vertices than ids.
pub fn subdivide(mesh: &Mesh) -> Result<Mesh, Failure> {
    let corners = mesh.faces().as_triangles().ok_or("only triangles are subdivided")?;
    let graph = DualGraph::new(mesh.faces());
    let twins: Vec<_> = graph.half_edge_twins().collect();
    let mut positions = mesh.positions().to_vec();
    let mut midpoints = vec![0_u32; corners.len()];
    for h in 0..corners.len() {
        let twin = twins[h].map(|twin| twin.0 as usize);
        midpoints[h] = match twin {
            Some(twin) if twin < h => midpoints[twin],
            _ => {
                let to = if h % 3 == 2 { h - 2 } else { h + 1 };
                let [a, b] = [corners[h], corners[to]].map(|v| mesh.positions()[v as usize]);
                positions.push([0, 1, 2].map(|axis| 0.5 * a[axis] + 0.5 * b[axis]));
                positions.len() as u32 - 1
            }
        };
    }
    let mut fine = Vec::with_capacity(4 * corners.len());
    for (t, m) in corners.chunks_exact(3).zip(midpoints.chunks_exact(3)) {
        fine.extend([t[0], m[0], m[2], m[0], t[1], m[1], m[2], m[1], t[2], m[0], m[1], m[2]]);
    }
    Ok(Mesh::new(positions, Faces::from_triangles(fine)?)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_share_midpoints() {
        let positions = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [2.0, 2.0, 0.0]];
        let mesh = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2, 2, 1, 3]).unwrap()).unwrap();
        let fine = subdivide(&mesh).unwrap();
        assert_eq!((fine.vertex_count(), fine.faces().face_count()), (9, 8));
        let graph = DualGraph::new(fine.faces());
        let open = graph.half_edge_twins().filter(Option::is_none).count();
        assert_eq!(open, 8, "each of the four boundary edges was split in two");
    }
}
