//! The searches: how few strips `fewest` and `eta` come to, and how cheap `best` becomes, next to lower bounds, to the best of all
//! peers and to what was published.
//!
//! A search takes seconds, so that its first run is timed; short ones run twice more, and the median counts. Every answer is proven
//! before its time is kept.

use std::collections::BTreeMap;
use std::time::Instant;

use serde::Serialize;
use tristrip::strip::{Cost, Metrics};
use tristrip::stripify::EtaOptions;
use tristrip::stripify::bound::Bound;
use tristrip::verify::verify;
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip::{DualGraph, Mesh, Method, PreparedFaces, StripifyOptions, stripify};

use crate::Failure;
use crate::measure::{Row, median};
use crate::memory::extra_bytes;
use crate::methods::Named;
use crate::models::{Fed, Source, load};
use crate::papers;
use crate::peers::{Best, Peers};
use crate::rivals::{Pipeline, strips_of};

/// The costs that peers were measured by.
pub const PEER_COSTS: [Cost; 3] = [Cost::Restart, Cost::OpenGl, Cost::Degenerate];
/// Models of polygons on which `best` also searches for vertices.
pub const POLYGONS: [&str; 3] = ["skyscraper", "triceratops", "power_lines"];
/// The model on which efforts are compared.
pub const LADDER: &str = "bunny";
/// Rounds in which efforts and the reference take turns.
const LADDER_ROUNDS: usize = 3;
/// Runs of less time than this are repeated.
const SHORT: f64 = 0.3;
/// Above so many triangles the effort of `best` is one level less, which keeps it within the same seconds,
const MEDIUM: usize = 80_000;
/// and above so many it is two.
const LARGE: usize = 300_000;

/// The efforts of a run.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Depth {
    /// Of `fewest`.
    pub fewest: u8,
    /// Of `best` on models that are not large.
    pub best: u8,
    /// Efforts that are compared.
    pub ladder: [u8; 4],
}

impl Depth {
    /// For the tables: seconds for a model, a quarter of a minute for the largest.
    pub const FULL: Self = Self { fewest: 5, best: 7, ladder: [1, 3, 5, 7] };
    /// To see that everything works.
    pub const SMOKE: Self = Self { fewest: 0, best: 1, ladder: [0, 1, 1, 2] };

    /// The effort of `best` by the number of triangles.
    fn best(self, triangles: usize) -> u8 {
        let less = u8::from(triangles > MEDIUM) + u8::from(triangles > LARGE);
        self.best.saturating_sub(less)
    }
}

/// What a paper reports of a model.
#[derive(Debug, Clone, Serialize)]
pub struct Published {
    /// Time.
    pub seconds: f64,
    /// Strips.
    pub strips: f64,
    /// Strips of one triangle.
    pub isolated: f64,
    /// Misses per triangle of a buffer of 32 vertices.
    pub acmr_32: f64,
    /// Vertices sent, a triangle.
    pub vertices_per_triangle: f64,
}

/// Reads what was published of ETA, by model.
///
/// # Errors
/// The data of the paper are broken.
pub fn published() -> Result<BTreeMap<String, Published>, Failure> {
    let table = |name| move |column| papers::column(papers::ETA_2006, name, column);
    let (quality, times) = (table("table 3"), table("table 2"));
    let (isolated, acmr) = (quality("isolated")?, quality("ACMR 32")?);
    let (vertices, seconds) = (quality("vertices/T")?, times("seconds")?);
    let strips = quality("strips")?;
    let published = strips.iter().filter_map(|(model, &strips)| {
        let published = Published {
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

/// A search on a model.
#[derive(Debug, Clone, Serialize)]
pub struct Search {
    /// Its figures.
    pub row: Row,
    /// Misses per triangle of a buffer of 32 vertices.
    pub acmr_fifo_32: f64,
}

/// Everything that was searched on a model.
#[derive(Debug, Clone, Serialize)]
pub struct Searched {
    /// The model's name.
    pub model: String,
    /// Triangles.
    pub triangles: usize,
    /// Whether every edge has two triangles and all are connected.
    pub is_closed: bool,
    /// The least number of strips that may be possible.
    pub bound: usize,
    /// `fewest`.
    pub fewest: Search,
    /// `eta`, on the models of its paper.
    pub eta: Option<Search>,
    /// What the paper says.
    pub published: Option<Published>,
    /// `best` for each of [`PEER_COSTS`].
    pub best: Vec<Search>,
    /// `best` for vertices on polygons, on models of [`POLYGONS`].
    pub polygons: Option<Search>,
    /// `best` at rising efforts, on the model [`LADDER`].
    pub ladder: Vec<Search>,
    /// The best of all peers.
    pub peers: Option<Peers>,
}

impl Searched {
    /// Strips beyond the bound, by the strips.
    pub fn gap(&self) -> f64 {
        (self.fewest.row.strips - self.bound.min(self.fewest.row.strips)) as f64
            / self.fewest.row.strips.max(1) as f64
    }

    /// Gives a cost of a search, and the best of all peers by the same, both a triangle.
    pub fn pair(&self, search: &Search, cost: Cost) -> Option<(f64, &Best)> {
        Some((per_triangle(&search.row, self.triangles, cost), best_of(self.peers.as_ref()?, cost)))
    }
}

/// Gives a cost a triangle.
pub fn per_triangle(row: &Row, triangles: usize, cost: Cost) -> f64 {
    match cost {
        Cost::Degenerate => row.indices_degenerate_per_triangle,
        Cost::OpenGl => row.vertices_sent as f64 / triangles as f64,
        Cost::Gl => row.gl_cost as f64 / triangles as f64,
        _ => row.indices_restart_per_triangle,
    }
}

fn best_of(peers: &Peers, cost: Cost) -> &Best {
    match cost {
        Cost::Degenerate => &peers.indices_degenerate_per_triangle,
        Cost::OpenGl => &peers.vertices_per_triangle,
        _ => &peers.indices_restart_per_triangle,
    }
}

/// Searches a model in every way.
///
/// # Errors
/// The model cannot be read, or a result is not proven.
pub fn search(
    source: &Source,
    depth: Depth,
    peers: Option<&Peers>,
    published: Option<&Published>,
) -> Result<Searched, Failure> {
    let Fed { triangles: mesh, polygons } = load(source)?;
    let run = |mesh: &Mesh, named: Named| {
        once(mesh, &named).map_err(|error| format!("{}, {}: {error}", source.name, named.name))
    };
    let count = mesh.faces().face_count();
    let name = source.name.as_str();
    let best = PEER_COSTS.map(|cost| run(&mesh, Named::search(Method::Best, depth.best(count), cost)));
    let eta = StripifyOptions::default().with_method(Method::Eta(EtaOptions::default()));
    let eta = published.map(|_| run(&mesh, Named { name: "eta".into(), options: eta })).transpose()?;
    let vertices = Named::search(Method::Best, depth.best(count), Cost::OpenGl);
    let polygons = polygons.filter(|_| POLYGONS.contains(&name));
    let surface = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(surface.faces());
    Ok(Searched {
        model: name.into(),
        triangles: count,
        is_closed: is_closed(&mesh) && graph.components().1 == 1,
        bound: Bound::of_surface(&surface, &graph).strips,
        fewest: run(&mesh, Named::search(Method::Fewest, depth.fewest, Cost::Restart))?,
        eta,
        published: published.cloned(),
        best: best.into_iter().collect::<Result<Vec<_>, _>>()?,
        polygons: polygons.map(|mesh| run(&mesh, vertices)).transpose()?,
        ladder: if name == LADDER { ladder(&mesh, depth)? } else { Vec::new() },
        peers: peers.cloned(),
    })
}

/// Tells whether every edge has two triangles.
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

/// Runs a search, proves what it gives, and repeats it where it is short.
fn once(mesh: &Mesh, named: &Named) -> Result<Search, Failure> {
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
            return Err("a second run gave another answer".into());
        }
    }
    let metrics = Metrics::of(&strips);
    let buffer =
        VertexCacheStatistics::of(&strips, VertexCache::fifo(32), FlushPolicy::Keep, mesh.vertex_count());
    let row = Row {
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
    Ok(Search { row, acmr_fifo_32: buffer.acmr() })
}

/// Runs `best` at rising efforts in turns with the reference, whose time is the unit.
fn ladder(mesh: &Mesh, depth: Depth) -> Result<Vec<Search>, Failure> {
    verify(mesh, &strips_of(&Pipeline::StripCache.run(mesh)?)).map_err(|e| format!("the reference: {e}"))?;
    let (mut unit, mut times) = (Vec::new(), vec![Vec::new(); depth.ladder.len()]);
    let mut searches = Vec::new();
    for round in 0..LADDER_ROUNDS {
        for (at, &effort) in depth.ladder.iter().enumerate() {
            // The reference is short, so that it has as many turns as all efforts together.
            let start = Instant::now();
            Pipeline::StripCache.run(mesh)?;
            unit.push(start.elapsed().as_secs_f64());
            let search = once(mesh, &Named::search(Method::Best, effort, Cost::Restart))?;
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
        let searched = search(&source, Depth::SMOKE, None, published().unwrap().get("goblet")).unwrap();
        assert!(searched.bound >= 1 && searched.bound <= searched.fewest.row.strips);
        assert!(searched.eta.is_some_and(|eta| eta.row.strips >= searched.bound));
        assert_eq!(searched.best.len(), PEER_COSTS.len());
        assert!(searched.best.iter().all(|s| s.row.proven && s.row.seconds > 0.0 && s.acmr_fifo_32 > 0.0));
    }
}
