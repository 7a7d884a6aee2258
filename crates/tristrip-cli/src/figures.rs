//! The metrics of strips and meshes as text.

use tristrip::vertex_cache::VertexCache;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{MeshProperties, StripMetrics};
use tristrip_render::text::table;

/// Returns a table of the metrics, compared with a plain triangle list.
pub(crate) fn summary(figures: &StripMetrics) -> String {
    let per_triangle = |n: usize| n as f64 / figures.triangles.max(1) as f64;
    let row =
        |name: &str, n: usize, remark: String| vec![format!("  {name}"), count(n), String::new(), remark];
    let ratio = |name: &str, n: usize, remark: String| {
        vec![format!("  {name}"), count(n), format!("{:.3}", per_triangle(n)), remark]
    };
    let list = 3 * figures.triangles;
    let of_list = |n: usize| format!("{:.1} % of the list", 100.0 * n as f64 / list.max(1) as f64);
    let triangles_per_strip = figures.triangles as f64 / figures.strips.max(1) as f64;
    let mut rows = vec![
        vec![String::new(), "total".into(), "per triangle".into(), String::new()],
        row("triangles", figures.triangles, String::new()),
        ratio("indices, plain list", list, String::new()),
        ratio("indices, restart", figures.indices_restart, of_list(figures.indices_restart)),
        ratio("indices, degenerate", figures.indices_degenerate, of_list(figures.indices_degenerate)),
        ratio("vertices sent (OpenGL)", figures.vertices_sent, String::new()),
        ratio("with free swaps (GL)", figures.gl_cost, String::new()),
        row("strips", figures.strips, format!("{triangles_per_strip:.1} triangles per strip")),
        row("isolated triangles", figures.isolated, String::new()),
        row("swaps", figures.swaps, String::new()),
        ratio("misses, FIFO 16 (ACMR)", figures.misses_fifo_16, format!("ATVR {:.3}", figures.atvr_fifo_16)),
        ratio("misses, FIFO 32 (ACMR)", figures.misses_fifo_32, format!("ATVR {:.3}", figures.atvr_fifo_32)),
    ];
    if let (Some((cache, misses)), Some(atvr)) = (figures.optimized_cache, figures.atvr)
        && ![VertexCache::fifo(16), VertexCache::fifo(32)].contains(&cache)
    {
        rows.push(ratio(&format!("misses, {cache} (ACMR)"), misses, format!("ATVR {atvr:.3}")));
    }
    table(&rows, 1..3)
}

/// Returns a line with the vertices, components and edges of the mesh.
pub(crate) fn mesh_line(mesh: &MeshProperties) -> String {
    let mut words = vec![counted(mesh.vertices, "vertex"), counted(mesh.components, "component")];
    words.push(match mesh.boundary_edges {
        0 => "closed".into(),
        n => counted(n, "boundary edge"),
    });
    if mesh.non_manifold_edges > 0 {
        words.push(counted(mesh.non_manifold_edges, "non-manifold edge"));
    }
    if mesh.inconsistent_edges > 0 {
        words.push(counted(mesh.inconsistent_edges, "inconsistently wound edge"));
    }
    words.join(", ")
}
