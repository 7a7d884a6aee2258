//! The figures of a model: the library's metrics summed over its parts, and their text.

use std::collections::HashMap;

use serde::Serialize;
use tristrip::mesh::MeshReport;
use tristrip::strip::{Between, Buffer, BufferUse, Metrics};
use tristrip::{Method, Options, Strips};

use crate::stages::{Pool, Prepared};
use crate::text::{count, counted, table};

/// The metrics of the strips of a model; the keys are those of the JSON report.
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
    /// With the vertex cache that the method optimizes for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) acmr: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) atvr: Option<f64>,
    #[serde(skip)]
    pub(crate) optimized_cache: Option<(Buffer, usize)>,
    #[serde(skip)]
    pub(crate) misses_fifo_16: usize,
    #[serde(skip)]
    pub(crate) misses_fifo_32: usize,
}

impl Figures {
    /// Measures the strips of all parts, drawn one part after the other.
    pub(crate) fn of(pool: &Pool, parts: &[Prepared<'_>], strips: &[Strips], options: &Options) -> Self {
        let optimized_cache = (options.method() == Method::Cache).then(|| options.buffer());
        let pairs: Vec<_> = parts.iter().zip(strips).collect();
        let measured = pool.map(&pairs, |(part, strips)| {
            let vertices = part.mesh.vertex_count();
            let simulate = |cache| BufferUse::of(strips, cache, Between::Keep, vertices);
            let (fifo_16, fifo_32) = (simulate(Buffer::fifo(16)), simulate(Buffer::fifo(32)));
            (Metrics::of(strips), fifo_16, fifo_32, optimized_cache.map(simulate))
        });
        let metrics: Metrics = measured.iter().map(|m| m.0).sum();
        let fifo_16: BufferUse = measured.iter().map(|m| m.1).sum();
        let fifo_32: BufferUse = measured.iter().map(|m| m.2).sum();
        let optimized: BufferUse = measured.iter().filter_map(|m| m.3).sum();
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
            acmr: optimized_cache.map(|_| rounded(optimized.acmr())),
            atvr: optimized_cache.map(|_| rounded(optimized.atvr())),
            optimized_cache: optimized_cache.map(|cache| (cache, optimized.misses)),
            misses_fifo_16: fifo_16.misses,
            misses_fifo_32: fifo_32.misses,
        }
    }
}

/// Rounds a ratio to six decimals, the precision of reports.
pub(crate) fn rounded(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

/// The counts of a model's mesh; the keys are those of the JSON report.
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
    /// Sums the counts of all parts. Vertices that several parts share are counted once; edges and components do not cross parts.
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

impl Figures {
    /// Returns a table of the metrics, compared with the plain triangle list.
    pub(crate) fn summary(&self) -> String {
        let per_triangle = |n: usize| n as f64 / self.triangles.max(1) as f64;
        let row =
            |name: &str, n: usize, remark: String| vec![format!("  {name}"), count(n), String::new(), remark];
        let ratio = |name: &str, n: usize, remark: String| {
            vec![format!("  {name}"), count(n), format!("{:.3}", per_triangle(n)), remark]
        };
        let list = 3 * self.triangles;
        let of_list = |n: usize| format!("{:.1} % of the list", 100.0 * n as f64 / list.max(1) as f64);
        let triangles_per_strip = self.triangles as f64 / self.strips.max(1) as f64;
        let mut rows = vec![
            vec![String::new(), "total".into(), "per triangle".into(), String::new()],
            row("triangles", self.triangles, String::new()),
            ratio("indices, plain list", list, String::new()),
            ratio("indices, restart", self.indices_restart, of_list(self.indices_restart)),
            ratio("indices, degenerate", self.indices_degenerate, of_list(self.indices_degenerate)),
            ratio("vertices sent (OpenGL)", self.vertices_sent, String::new()),
            ratio("with free swaps (GL)", self.gl_cost, String::new()),
            row("strips", self.strips, format!("{triangles_per_strip:.1} triangles per strip")),
            row("isolated triangles", self.isolated, String::new()),
            row("swaps", self.swaps, String::new()),
            ratio("misses, FIFO 16 (ACMR)", self.misses_fifo_16, format!("ATVR {:.3}", self.atvr_fifo_16)),
            ratio("misses, FIFO 32 (ACMR)", self.misses_fifo_32, format!("ATVR {:.3}", self.atvr_fifo_32)),
        ];
        if let (Some((cache, misses)), Some(atvr)) = (self.optimized_cache, self.atvr)
            && ![Buffer::fifo(16), Buffer::fifo(32)].contains(&cache)
        {
            rows.push(ratio(&format!("misses, {cache} (ACMR)"), misses, format!("ATVR {atvr:.3}")));
        }
        table(&rows, 1..3)
    }
}

impl MeshFigures {
    /// Returns a line on the components and the edges of the mesh.
    pub(crate) fn line(&self, parts: usize) -> String {
        let mut words = Vec::new();
        if parts != 1 {
            words.push(counted(parts, "part"));
        }
        words.push(counted(self.components, "component"));
        words.push(match self.boundary_edges {
            0 => "closed".into(),
            n => counted(n, "boundary edge"),
        });
        if self.non_manifold_edges > 0 {
            words.push(counted(self.non_manifold_edges, "non-manifold edge"));
        }
        if self.inconsistent_edges > 0 {
            words.push(counted(self.inconsistent_edges, "inconsistently wound edge"));
        }
        words.join(", ")
    }

    /// Returns a note on each kind of faces or vertices that were dropped, changed or unusual.
    pub(crate) fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let mut add = |n: usize, noun: &str, rest: &str| {
            if n > 0 {
                remarks.push(format!("{}{rest}", counted(n, noun)));
            }
        };
        add(self.degenerate_faces, "degenerate face", " dropped: they draw nothing");
        add(self.duplicate_faces, "duplicate face", " kept: each is drawn");
        add(self.cut_polygons, "non-convex polygon", " triangulated in advance");
        add(self.fanned_polygons, "polygon", " triangulated as a fan, because ear clipping failed");
        add(self.welded_vertices, "vertex", " welded to others with the same bits");
        add(self.unreferenced_vertices, "vertex", " not used by any face");
        remarks
    }
}

/// Counts the vertices of all parts, and those that no part uses. Vertices that parts share are counted once.
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
