//! The searches: the strips of `fewest` and `guided-tunnels` and the costs of `best`, compared with
//! lower bounds, with the best peers, and with published results.
//!
//! Searches take seconds, so the first run is timed. A short search runs twice more, and the median
//! counts. Every result is proven before its time is kept.

use std::collections::BTreeMap;
use std::time::Instant;

use serde::Serialize;
use tristrip::stripify::TunnelOptions;
use tristrip::stripify::bound::Bound;
use tristrip::verify::verify;
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip::{Cost, Metrics};
use tristrip::{DualGraph, Mesh, Method, PreparedFaces, StripifyOptions, stripify};

use crate::failure::Failure;
use crate::measure::{MethodRow, median};
use crate::memory::extra_bytes;
use crate::meshoptimizer::{Pipeline, strips_of};
use crate::methods::NamedMethod;
use crate::models::{LoadedModel, Source, load};
use crate::papers;
use crate::peers::{PeerBest, Peers};

/// The costs for which the peers were measured.
pub const PEER_COSTS: [Cost; 3] = [Cost::Restart, Cost::OpenGl, Cost::Degenerate];
/// Models with polygons on which `best` also minimizes the vertices sent.
pub const POLYGONS: [&str; 3] = ["skyscraper", "triceratops", "power_lines"];
/// The model on which efforts are compared.
pub const LADDER: &str = "bunny";
/// The number of rounds in which the efforts and the reference alternate.
const LADDER_ROUNDS: usize = 3;
/// Runs shorter than this time in seconds are repeated.
const SHORT: f64 = 0.3;
/// Above this number of triangles, the effort of `best` is one level lower, which takes about the
/// same time.
const MEDIUM: usize = 80_000;
/// Above this number of triangles, it is two levels lower.
const LARGE: usize = 300_000;

/// The efforts of a run.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct SearchEffort {
    /// The effort of `fewest`.
    pub fewest: u8,
    /// The effort of `best` on models that are not large.
    pub best: u8,
    /// The efforts of `best` that are compared on one model.
    pub ladder: [u8; 4],
}

impl SearchEffort {
    /// The efforts for the published tables: seconds per model, 15 seconds for the largest.
    pub const FULL: Self = Self { fewest: 5, best: 7, ladder: [1, 3, 5, 7] };
    /// The efforts for a smoke run.
    pub const SMOKE: Self = Self { fewest: 0, best: 1, ladder: [0, 1, 1, 2] };

    /// Returns the effort of `best` for a number of triangles.
    fn best(self, triangles: usize) -> u8 {
        let less = u8::from(triangles > MEDIUM) + u8::from(triangles > LARGE);
        self.best.saturating_sub(less)
    }
}

/// The values that a paper reports for a model.
#[derive(Debug, Clone, Serialize)]
pub struct PublishedFigures {
    /// The time in seconds.
    pub seconds: f64,
    /// The number of strips.
    pub strips: f64,
    /// The number of strips of one triangle.
    pub isolated: f64,
    /// The misses per triangle with a vertex cache of 32 entries.
    pub acmr_32: f64,
    /// The vertices sent per triangle.
    pub vertices_per_triangle: f64,
}

/// Reads the published values of ETA, by model.
///
/// # Errors
/// The data of the paper is malformed.
pub fn published() -> Result<BTreeMap<String, PublishedFigures>, Failure> {
    let table = |name| move |column| papers::column(papers::ETA_2006, name, column);
    let (quality, times) = (table("table 3"), table("table 2"));
    let (isolated, acmr) = (quality("isolated")?, quality("ACMR 32")?);
    let (vertices, seconds) = (quality("vertices/T")?, times("seconds")?);
    let strips = quality("strips")?;
    let published = strips.iter().filter_map(|(model, &strips)| {
        let published = PublishedFigures {
            seconds: *seconds.get(model)?,
            strips,
            isolated: *isolated.get(model)?,
            acmr_32: *acmr.get(model)?,
            vertices_per_triangle: *vertices.get(model)?,
        };
        Some((model.clone(), published))
    });
    Ok(published.collect())
}

/// The result of one search on a model.
#[derive(Debug, Clone, Serialize)]
pub struct SearchRow {
    /// Its metrics.
    pub row: MethodRow,
    /// The misses per triangle with a vertex cache of 32 entries.
    pub acmr_fifo_32: f64,
}

/// The results of all searches on a model.
#[derive(Debug, Clone, Serialize)]
pub struct SearchResults {
    /// The model's name.
    pub model: String,
    /// The number of triangles.
    pub triangles: usize,
    /// Whether the mesh is closed and connected: every edge has two triangles.
    pub is_closed: bool,
    /// The lower bound on the number of strips.
    pub bound: usize,
    /// The result of `fewest`.
    pub fewest: SearchRow,
    /// The result of `guided-tunnels`, on the models of the paper that it is based on.
    pub guided_tunnels: Option<SearchRow>,
    /// The published values of the paper.
    pub published: Option<PublishedFigures>,
    /// The results of `best` for each of [`PEER_COSTS`].
    pub best: Vec<SearchRow>,
    /// The result of `best` for vertices sent, with polygons as input, on the models of
    /// [`POLYGONS`].
    pub polygons: Option<SearchRow>,
    /// The results of `best` at increasing efforts, on the model [`LADDER`].
    pub ladder: Vec<SearchRow>,
    /// The best peers.
    pub peers: Option<Peers>,
}

impl SearchResults {
    /// Returns the gap between the strips and their bound, as a fraction of the strips.
    pub fn gap(&self) -> f64 {
        (self.fewest.row.strips - self.bound.min(self.fewest.row.strips)) as f64
            / self.fewest.row.strips.max(1) as f64
    }

    /// Returns a cost of a search and that of the best peer, both per triangle.
    pub fn pair(&self, search: &SearchRow, cost: Cost) -> Option<(f64, &PeerBest)> {
        Some((per_triangle(&search.row, self.triangles, cost), best_of(self.peers.as_ref()?, cost)))
    }
}

/// Returns a cost per triangle.
pub fn per_triangle(row: &MethodRow, triangles: usize, cost: Cost) -> f64 {
    match cost {
        Cost::Degenerate => row.indices_degenerate_per_triangle,
        Cost::OpenGl => row.vertices_sent as f64 / triangles as f64,
        Cost::Gl => row.gl_cost as f64 / triangles as f64,
        _ => row.indices_restart_per_triangle,
    }
}

fn best_of(peers: &Peers, cost: Cost) -> &PeerBest {
    match cost {
        Cost::Degenerate => &peers.indices_degenerate_per_triangle,
        Cost::OpenGl => &peers.vertices_per_triangle,
        _ => &peers.indices_restart_per_triangle,
    }
}

/// Runs all searches on a model.
///
/// # Errors
/// The model cannot be read, or a result is not proven.
pub fn search(
    source: &Source,
    depth: SearchEffort,
    peers: Option<&Peers>,
    published: Option<&PublishedFigures>,
) -> Result<SearchResults, Failure> {
    let LoadedModel { triangles: mesh, polygons } = load(source)?;
    let run = |mesh: &Mesh, named: NamedMethod| {
        once(mesh, &named).map_err(|error| format!("{}, {}: {error}", source.name, named.name))
    };
    let count = mesh.faces().face_count();
    let name = source.name.as_str();
    let best = PEER_COSTS.map(|cost| run(&mesh, NamedMethod::search(Method::Best, depth.best(count), cost)));
    let guided = StripifyOptions::default().with_method(Method::GuidedTunnels(TunnelOptions::default()));
    let guided = NamedMethod { name: "guided-tunnels".into(), options: guided };
    let guided_tunnels = published.map(|_| run(&mesh, guided)).transpose()?;
    let vertices = NamedMethod::search(Method::Best, depth.best(count), Cost::OpenGl);
    let polygons = polygons.filter(|_| POLYGONS.contains(&name));
    let surface = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(surface.faces());
    Ok(SearchResults {
        model: name.into(),
        triangles: count,
        is_closed: is_closed(&mesh) && graph.components().1 == 1,
        bound: Bound::of_prepared(&surface, &graph)?.strips,
        fewest: run(&mesh, NamedMethod::search(Method::Fewest, depth.fewest, Cost::Restart))?,
        guided_tunnels,
        published: published.cloned(),
        best: best.into_iter().collect::<Result<Vec<_>, _>>()?,
        polygons: polygons.map(|mesh| run(&mesh, vertices)).transpose()?,
        ladder: if name == LADDER { ladder(&mesh, depth)? } else { Vec::new() },
        peers: peers.cloned(),
    })
}

/// Checks whether every edge has exactly two triangles.
fn is_closed(mesh: &Mesh) -> bool {
    let corners = mesh.faces().corners();
    let edge = |a: u32, b: u32| (a.min(b), a.max(b));
    let mut edges: Vec<_> = corners
        .chunks_exact(3)
        .flat_map(|t| [edge(t[0], t[1]), edge(t[1], t[2]), edge(t[2], t[0])])
        .collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).all(|same| same.len() == 2)
}

/// Runs a search, proves its result, and repeats it if it is short.
fn once(mesh: &Mesh, named: &NamedMethod) -> Result<SearchRow, Failure> {
    let start = Instant::now();
    let (strips, extra) = extra_bytes(|| stripify(mesh, &named.options));
    let mut seconds = vec![start.elapsed().as_secs_f64()];
    let strips = strips?;
    verify(mesh, &strips).map_err(|error| format!("not proven: {error}"))?;
    while seconds[0] < SHORT && seconds.len() < 3 {
        let start = Instant::now();
        let again = stripify(mesh, &named.options)?;
        seconds.push(start.elapsed().as_secs_f64());
        if again != strips {
            return Err("a second run gave a different result".into());
        }
    }
    let metrics = Metrics::of(&strips);
    let cache = VertexCacheStatistics::of(&strips, VertexCache::fifo(32), FlushPolicy::Keep);
    let row = MethodRow {
        method: named.name.clone(),
        proven: true,
        strips: metrics.strips,
        isolated: metrics.isolated,
        swaps: metrics.swaps,
        vertices_sent: metrics.vertices_sent,
        gl_cost: metrics.gl_cost,
        indices_restart_per_triangle: metrics.indices_restart_per_triangle(),
        indices_degenerate_per_triangle: metrics.indices_degenerate_per_triangle(),
        seconds: median(seconds),
        time_ratio: None,
        extra_bytes_per_triangle: extra.map(|bytes| bytes as f64 / metrics.triangles.max(1) as f64),
    };
    Ok(SearchRow { row, acmr_fifo_32: cache.acmr() })
}

/// Runs `best` at increasing efforts, alternating with the reference, whose time is the unit.
fn ladder(mesh: &Mesh, depth: SearchEffort) -> Result<Vec<SearchRow>, Failure> {
    verify(mesh, &strips_of(&Pipeline::StripCache.run(mesh)?)).map_err(|e| format!("the reference: {e}"))?;
    let (mut unit, mut times) = (Vec::new(), vec![Vec::new(); depth.ladder.len()]);
    let mut searches = Vec::new();
    for round in 0..LADDER_ROUNDS {
        for (at, &effort) in depth.ladder.iter().enumerate() {
            // The reference is short, so it runs once per effort.
            let start = Instant::now();
            Pipeline::StripCache.run(mesh)?;
            unit.push(start.elapsed().as_secs_f64());
            let search = once(mesh, &NamedMethod::search(Method::Best, effort, Cost::Restart))?;
            times[at].push(search.row.seconds);
            if round == 0 {
                searches.push(search);
            }
        }
    }
    let unit = median(unit);
    for (search, times) in searches.iter_mut().zip(times) {
        search.row.seconds = median(times);
        search.row.time_ratio = Some(search.row.seconds / unit);
    }
    Ok(searches)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_search_is_proven_and_bounded() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../testdata/models/fish_control.ply");
        let source = Source { name: "fish_control".into(), path };
        let searched =
            search(&source, SearchEffort::SMOKE, None, published().unwrap().get("goblet")).unwrap();
        assert!(searched.bound >= 1 && searched.bound <= searched.fewest.row.strips);
        assert!(searched.guided_tunnels.is_some_and(|search| search.row.strips >= searched.bound));
        assert_eq!(searched.best.len(), PEER_COSTS.len());
        assert!(searched.best.iter().all(|s| s.row.proven && s.row.seconds > 0.0 && s.acmr_fifo_32 > 0.0));
    }
}
