//! Orders strips for a vertex cache, and counts its misses. Run with
//! `cargo run --release -p tristrip --example vertex_cache`.
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip::{Method, StripifyOptions, stripify_indices_with};

fn main() -> Result<(), tristrip::Error> {
    // A grid of 200 × 200 quadrilaterals, two triangles each.
    let quad = |i: u32| [i, i + 1, i + 201, i + 201, i + 1, i + 202];
    let cells = (0..200).flat_map(|y| (0..200).map(move |x| 201 * y + x));
    let indices: Vec<u32> = cells.flat_map(quad).collect();
    let vertex_count = 201 * 201;

    let cache = VertexCache::fifo(24);
    let list = VertexCacheStatistics::of_list(indices.as_chunks().0, cache);
    println!("the list: {:.3} misses per triangle ({cache})", list.acmr());
    for method in [Method::Best, Method::Cache] {
        let options = StripifyOptions::default().with_method(method).with_vertex_cache(cache);
        let strips = stripify_indices_with(&indices, vertex_count, &options)?;
        let misses = VertexCacheStatistics::of(&strips, cache, FlushPolicy::Keep);
        println!(
            "{method}: {:.3} misses per triangle, {} vertices sent",
            misses.acmr(),
            strips.vertices_sent()
        );
    }
    Ok(())
}
