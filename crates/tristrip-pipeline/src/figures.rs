//! Measures a whole model: the metrics of strips and meshes, summed over its parts.

use std::collections::HashMap;

use serde::Serialize;
use tristrip::MeshReport;
use tristrip::Metrics;
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip::{Mesh, Method, StripifyOptions, Strips};

use crate::error::Error;
use crate::metrics::{StripMetrics, rounded};
use crate::parts::{PreparedPart, check_vertices, map};
use crate::text::counted;

/// The metrics that decide how a part is drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PartMetrics {
    pub(crate) metrics: Metrics,
    pub(crate) fifo_16: VertexCacheStatistics,
}

impl StripMetrics {
    /// Measures the strips of all parts, drawn one part after the other. Each item has the strips
    /// of a part and its number of vertices.
    ///
    /// # Errors
    /// Strips refer to a vertex that their part does not have.
    ///
    /// ```
    /// use tristrip::{StripifyOptions, Strips};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// let figures = tristrip_pipeline::StripMetrics::of(&[(&strips, 4)], &StripifyOptions::default())?;
    /// assert_eq!((figures.triangles, figures.misses_fifo_16), (2, 4));
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn of(parts: &[(&Strips, usize)], options: &StripifyOptions) -> Result<Self, Error> {
        Ok(Self::with_parts(parts, options)?.0)
    }

    /// Measures strips like [`StripMetrics::of`], and also returns the metrics of each part.
    pub(crate) fn with_parts(
        parts: &[(&Strips, usize)],
        options: &StripifyOptions,
    ) -> Result<(Self, Vec<PartMetrics>), Error> {
        check_vertices(parts)?;
        let optimized_cache = (options.method == Method::Cache).then_some(options.vertex_cache);
        let caches: Vec<_> =
            [VertexCache::fifo(16), VertexCache::fifo(32)].into_iter().chain(optimized_cache).collect();
        let measured = map(parts, |&(strips, _)| {
            let simulate = || VertexCacheStatistics::of_each(strips, &caches, FlushPolicy::Keep);
            let (metrics, used) = rayon::join(|| Metrics::of(strips), simulate);
            (metrics, used[0], used[1], used.get(2).copied())
        });
        let metrics: Metrics = measured.iter().map(|m| m.0).sum();
        let fifo_16: VertexCacheStatistics = measured.iter().map(|m| m.1).sum();
        let fifo_32: VertexCacheStatistics = measured.iter().map(|m| m.2).sum();
        let optimized: VertexCacheStatistics = measured.iter().filter_map(|m| m.3).sum();
        let of_parts = measured.iter().map(|m| PartMetrics { metrics: m.0, fifo_16: m.1 }).collect();
        let figures = Self {
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
            acmr: optimized_cache.map(|_| rounded(optimized.acmr())),
            atvr: optimized_cache.map(|_| rounded(optimized.atvr())),
            optimized_cache: optimized_cache.map(|cache| (cache, optimized.misses)),
            misses_fifo_16: fifo_16.misses,
            misses_fifo_32: fifo_32.misses,
        };
        Ok((figures, of_parts))
    }
}

/// The vertex, edge and face counts of a model's mesh. The field names are the keys of the JSON
/// report.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MeshProperties {
    /// The number of vertices, used or not; vertices that parts share are counted once.
    pub vertices: usize,
    /// The number of faces, including degenerate ones.
    pub faces: usize,
    /// The number of triangles of the prepared faces: k − 2 per face of k corners.
    pub triangles: usize,
    /// The number of connected components of the dual graph.
    pub components: usize,
    /// The number of edges with exactly one face.
    pub boundary_edges: usize,
    /// The number of edges with more than two faces.
    pub non_manifold_edges: usize,
    /// The number of edges between two faces with opposite winding.
    pub inconsistent_edges: usize,
    /// The number of faces that share no edge with another face.
    pub isolated_faces: usize,
    /// The number of faces that draw nothing. They are dropped.
    pub degenerate_faces: usize,
    /// The number of faces with the corners and winding of an earlier face. They are drawn as often
    /// as they occur.
    pub duplicate_faces: usize,
    /// The number of vertices that no face uses.
    pub unreferenced_vertices: usize,
    /// The number of non-convex polygons that were triangulated before stripification.
    pub cut_polygons: usize,
    /// The number of `cut_polygons` that were cut into fans, because ear clipping failed, the
    /// polygon has more than 4096 corners, or there are too many such polygons.
    pub fanned_polygons: usize,
    /// The number of vertices in use that were replaced by an equal vertex.
    pub welded_vertices: usize,
}

impl MeshProperties {
    /// Sums the counts of all parts. Vertices that several parts share are counted once; edges and
    /// components do not cross parts.
    pub(crate) fn of(parts: &[PreparedPart<'_>]) -> Self {
        let reports = map(parts, |part| MeshReport::of(part.mesh, &part.surface, &part.graph));
        let mut sum = Self::default();
        for report in &reports {
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
        (sum.vertices, sum.unreferenced_vertices) = count_vertices(parts, &reports);
        sum
    }
}

impl MeshProperties {
    /// Returns a note per kind of faces or vertices that were dropped, changed or unusual.
    pub(crate) fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let mut add = |n: usize, noun: &str, rest: &str| {
            if n > 0 {
                remarks.push(format!("{}{rest}", counted(n, noun)));
            }
        };
        add(self.degenerate_faces, "degenerate face", " dropped (no area)");
        add(self.duplicate_faces, "duplicate face", " kept: each is drawn");
        add(self.cut_polygons, "non-convex polygon", " triangulated in advance");
        add(self.fanned_polygons, "polygon", " triangulated as a fan, because ear clipping failed");
        add(self.welded_vertices, "vertex", " welded to others with the same bits");
        add(self.unreferenced_vertices, "vertex", " not used by any face");
        remarks
    }
}

/// Returns the number of vertices of all parts, and of those that no part uses. Vertices that parts
/// share are counted once.
fn count_vertices(parts: &[PreparedPart<'_>], reports: &[MeshReport]) -> (usize, usize) {
    let mut by_positions: HashMap<*const [f32; 3], Vec<usize>> = HashMap::new();
    for (number, part) in parts.iter().enumerate() {
        by_positions.entry(part.mesh.positions().as_ptr()).or_default().push(number);
    }
    let unused = |sharing: &Vec<usize>| match sharing[..] {
        [one] => reports[one].unreferenced_vertices,
        _ => unused_by_all(sharing.iter().map(|&number| parts[number].mesh)),
    };
    let vertices = by_positions.values().map(|sharing| reports[sharing[0]].vertices).sum();
    (vertices, by_positions.values().map(unused).sum())
}

/// Counts the vertices that are unused by all of several meshes over the same vertices.
fn unused_by_all<'a>(meshes: impl Iterator<Item = &'a Mesh>) -> usize {
    let mut used = Vec::new();
    for mesh in meshes {
        used.resize(mesh.vertex_count(), false);
        mesh.faces().corners().iter().for_each(|&v| used[v as usize] = true);
    }
    used.iter().filter(|&&is_used| !is_used).count()
}
