//! The figures of a model: the library's definitions, summed over its parts.

use std::collections::HashMap;

use serde::Serialize;
use tristrip::mesh::MeshReport;
use tristrip::strip::{Between, Buffer, BufferUse, Metrics};
use tristrip::{Method, Options, Strips};

use crate::stages::{Pool, Prepared};

/// What the strips of a model cost; the keys are those of the JSON report.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub(crate) struct Figures {
    pub(crate) triangles: usize,
    pub(crate) strips: usize,
    pub(crate) isolated: usize,
    pub(crate) swaps: usize,
    pub(crate) vertices_sent: usize,
    pub(crate) gl_cost: usize,
    pub(crate) indices_restart: usize,
    pub(crate) indices_degenerate: usize,
    pub(crate) vertices_per_triangle: f64,
    pub(crate) indices_restart_per_triangle: f64,
    pub(crate) indices_degenerate_per_triangle: f64,
    pub(crate) acmr_fifo_16: f64,
    pub(crate) acmr_fifo_32: f64,
    pub(crate) atvr_fifo_16: f64,
    pub(crate) atvr_fifo_32: f64,
    /// With the buffer that the method respects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) acmr: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) atvr: Option<f64>,
    #[serde(skip)]
    pub(crate) respected: Option<(Buffer, usize)>,
    #[serde(skip)]
    pub(crate) misses_fifo_16: usize,
    #[serde(skip)]
    pub(crate) misses_fifo_32: usize,
}

impl Figures {
    /// Measures the strips of all parts, as if they were drawn one part after the other.
    pub(crate) fn of(pool: &Pool, parts: &[Prepared<'_>], strips: &[Strips], options: &Options) -> Self {
        let respected = (options.method() == Method::Cache).then(|| options.buffer());
        let pairs: Vec<_> = parts.iter().zip(strips).collect();
        let measured = pool.map(&pairs, |(part, strips)| {
            let vertices = part.mesh.vertex_count();
            let used = |buffer| BufferUse::of(strips, buffer, Between::Keep, vertices);
            (Metrics::of(strips), used(Buffer::fifo(16)), used(Buffer::fifo(32)), respected.map(used))
        });
        let metrics: Metrics = measured.iter().map(|m| m.0).sum();
        let fifo_16: BufferUse = measured.iter().map(|m| m.1).sum();
        let fifo_32: BufferUse = measured.iter().map(|m| m.2).sum();
        let used: BufferUse = measured.iter().filter_map(|m| m.3).sum();
        Self {
            triangles: metrics.triangles,
            strips: metrics.strips,
            isolated: metrics.isolated,
            swaps: metrics.swaps,
            vertices_sent: metrics.vertices_sent,
            gl_cost: metrics.gl_cost,
            indices_restart: metrics.indices_restart,
            indices_degenerate: metrics.indices_degenerate,
            vertices_per_triangle: rounded(metrics.vertices_per_triangle()),
            indices_restart_per_triangle: rounded(metrics.indices_restart_per_triangle()),
            indices_degenerate_per_triangle: rounded(metrics.indices_degenerate_per_triangle()),
            acmr_fifo_16: rounded(fifo_16.acmr()),
            acmr_fifo_32: rounded(fifo_32.acmr()),
            atvr_fifo_16: rounded(fifo_16.atvr()),
            atvr_fifo_32: rounded(fifo_32.atvr()),
            acmr: respected.map(|_| rounded(used.acmr())),
            atvr: respected.map(|_| rounded(used.atvr())),
            respected: respected.map(|buffer| (buffer, used.misses)),
            misses_fifo_16: fifo_16.misses,
            misses_fifo_32: fifo_32.misses,
        }
    }
}

/// Rounds a ratio to six decimals: no more are meant.
pub(crate) fn rounded(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

/// What a model is like; the keys are those of the JSON report.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub(crate) struct MeshFigures {
    pub(crate) vertices: usize,
    pub(crate) faces: usize,
    pub(crate) triangles: usize,
    pub(crate) components: usize,
    pub(crate) boundary_edges: usize,
    pub(crate) non_manifold_edges: usize,
    pub(crate) inconsistent_edges: usize,
    pub(crate) isolated_faces: usize,
    pub(crate) degenerate_faces: usize,
    pub(crate) duplicate_faces: usize,
    pub(crate) unreferenced_vertices: usize,
    pub(crate) cut_polygons: usize,
    pub(crate) fanned_polygons: usize,
    pub(crate) welded_vertices: usize,
}

impl MeshFigures {
    /// Counts all parts. Vertices that several parts share are counted once; edges and components are those within a part.
    pub(crate) fn of(pool: &Pool, parts: &[Prepared<'_>]) -> Self {
        let reports = pool.map(parts, |part| MeshReport::of(part.mesh, &part.surface, &part.graph));
        let mut sum = Self::default();
        for report in reports {
            sum.faces += report.faces;
            sum.triangles += report.triangles;
            sum.components += report.components;
            sum.boundary_edges += report.boundary_edges;
            sum.non_manifold_edges += report.non_manifold_edges;
            sum.inconsistent_edges += report.inconsistent_edges;
            sum.isolated_faces += report.isolated_faces;
            sum.duplicate_faces += report.duplicate_faces;
            sum.degenerate_faces += report.surface.degenerate_faces;
            sum.cut_polygons += report.surface.cut_polygons;
            sum.fanned_polygons += report.surface.fanned_polygons;
            sum.welded_vertices += report.surface.welded_vertices;
        }
        (sum.vertices, sum.unreferenced_vertices) = count_vertices(parts);
        sum
    }
}

/// Counts the vertices of all parts, and those that no part uses; shared ones once.
fn count_vertices(parts: &[Prepared<'_>]) -> (usize, usize) {
    let mut used: HashMap<*const [f32; 3], Vec<bool>> = HashMap::new();
    for part in parts {
        let positions = part.mesh.positions();
        let used = used.entry(positions.as_ptr()).or_insert_with(|| vec![false; positions.len()]);
        part.mesh.faces().corners().iter().for_each(|&v| used[v as usize] = true);
    }
    let unused = used.values().map(|used| used.iter().filter(|&&u| !u).count()).sum();
    (used.values().map(Vec::len).sum(), unused)
}
