//! Index statistics of a part of a file, as stored.
//!
//! Restarts separate strips, and degenerate triangles join them. Joined strips count as separate
//! strips. The vertex caches are simulated with the indices as stored. Polygons are drawn as
//! triangle fans.

use std::borrow::Cow;
use std::collections::HashMap;

use serde::Serialize;
use tristrip::Metrics;
use tristrip::Strips;
use tristrip::split_joined;
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip_io::Part;

/// How a part is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum DrawMode {
    /// As a triangle list, polygons as fans.
    List,
    /// As strips.
    Strips,
    /// As fans.
    Fans,
    /// The parts differ.
    Mixed,
}

impl DrawMode {
    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::List => "list",
            Self::Strips => "strips",
            Self::Fans => "fans",
            Self::Mixed => "mixed",
        }
    }
}

/// The index statistics of a part, or the sum over all parts. The field names are the keys of the
/// JSON report. Strip statistics are `None` if there are no strips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct StoredIndices {
    /// How the triangles are stored; `mixed` if parts differ.
    pub drawn: DrawMode,
    /// The number of triangles drawn, without degenerate ones.
    pub triangles: usize,
    /// The number of vertices in use.
    pub vertices: usize,
    /// The number of indices as stored, including restarts. A glTF primitive without indices counts
    /// its vertices, and a polygon counts as a fan of triangles.
    pub indices: usize,
    /// The number of restart indices.
    pub restarts: usize,
    /// The number of triangles with a repeated vertex: swaps, winding repeats, joins of strips and
    /// degenerate faces.
    pub degenerate: usize,
    /// The number of strips, split where degenerate triangles join them; `None` if there are no
    /// strips.
    pub strips: Option<usize>,
    /// The number of strips of one triangle; `None` if there are no strips.
    pub isolated: Option<usize>,
    /// The number of vertices repeated inside a strip or at its start; `None` if there are no
    /// strips.
    pub swaps: Option<usize>,
    /// The sum of the strip lengths, without joins; `None` if there are no strips.
    pub vertices_sent: Option<usize>,
}

/// A histogram of strip lengths: bin k counts the strips of 2ᵏ to 2ᵏ⁺¹ − 1 triangles.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct StripLengths(Vec<LengthBin>);

/// The strips of a range of lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LengthBin {
    /// The minimum number of triangles per strip.
    pub from: usize,
    /// The maximum number of triangles per strip.
    pub to: usize,
    /// The number of strips of these lengths.
    pub strips: usize,
    /// The number of triangles in these strips.
    pub triangles: usize,
}

impl StripLengths {
    fn of(strips: &Strips) -> Self {
        let mut lengths = Self::default();
        for strip in strips.iter() {
            lengths.add(tristrip::strip_triangles(strip).count(), 1);
        }
        lengths
    }

    /// Adds strips of one bin, with their total number of triangles.
    fn add(&mut self, triangles: usize, strips: usize) {
        let Some(k) = (triangles / strips.max(1)).checked_ilog2() else { return };
        while self.0.len() <= k as usize {
            let from = 1 << self.0.len();
            self.0.push(LengthBin { from, to: 2 * from - 1, ..LengthBin::default() });
        }
        let bin = &mut self.0[k as usize];
        bin.strips += strips;
        bin.triangles += triangles;
    }

    /// Returns the bins, the shortest strips first.
    pub(super) fn into_bins(self) -> Vec<LengthBin> {
        self.0
    }
}

impl LengthBin {
    /// Returns the range of lengths as text.
    pub fn name(&self) -> String {
        if self.from == self.to { self.from.to_string() } else { format!("{}–{}", self.from, self.to) }
    }
}

/// A part with the data that all vertex caches share.
#[derive(Debug)]
pub(crate) struct MeasuredPart<'a> {
    part: &'a Part,
    /// The indices of a list.
    list: Cow<'a, [u32]>,
    /// The strips, split where they are joined by degenerate triangles.
    strips: Strips,
    pub(super) stored: StoredIndices,
    pub(super) lengths: StripLengths,
}

impl<'a> MeasuredPart<'a> {
    /// Counts the triangles, indices and strips of a part.
    pub(super) fn of(part: &'a Part) -> Self {
        let mut strips = Strips::default();
        let mut list = Cow::default();
        let mut found = StoredIndices {
            drawn: DrawMode::List,
            triangles: 0,
            vertices: 0,
            indices: 0,
            restarts: 0,
            degenerate: 0,
            strips: None,
            isolated: None,
            swaps: None,
            vertices_sent: None,
        };
        if let Some(stored) = &part.stored {
            found.indices = stored.indices();
            found.restarts = stored.restarts;
            found.triangles = part.mesh.faces().face_count();
            found.vertices = VertexCacheStatistics::of(&stored.runs, ANY_CACHE, FlushPolicy::Keep).vertices;
            let drawn: usize = stored.runs.iter().map(|run| run.len().saturating_sub(2)).sum();
            found.degenerate = drawn.saturating_sub(found.triangles);
            found.drawn = if stored.fans { DrawMode::Fans } else { DrawMode::Strips };
            if !stored.fans {
                stored.runs.iter().flat_map(split_joined).for_each(|strip| strips.push(strip));
                let metrics = Metrics::of(&strips);
                found.strips = Some(metrics.strips);
                found.isolated = Some(metrics.isolated);
                found.swaps = Some(metrics.swaps);
                found.vertices_sent = Some(metrics.vertices_sent);
            }
        } else {
            list = part.mesh.faces().fans();
            found.indices = list.len();
            let used = VertexCacheStatistics::of_list(list.as_chunks().0, ANY_CACHE);
            (found.triangles, found.vertices) = (used.triangles, used.vertices);
            found.degenerate = list.len() / 3 - found.triangles;
        }
        let lengths = StripLengths::of(&strips);
        Self { part, list, strips, stored: found, lengths }
    }

    /// Returns the vertices of the indices, in order.
    fn sent(&self) -> &[u32] {
        self.part.stored.as_ref().map_or(&*self.list, |stored| stored.runs.vertices())
    }

    /// Simulates each vertex cache. With a flush between strips, the degenerate triangles that join
    /// strips are skipped.
    pub(super) fn simulate(
        &self,
        caches: &[VertexCache],
        flush_policy: FlushPolicy,
    ) -> Vec<VertexCacheStatistics> {
        let mut each = match &self.part.stored {
            None => VertexCacheStatistics::of_list_each(self.list.as_chunks().0, caches),
            Some(stored) if stored.fans || flush_policy == FlushPolicy::Keep => {
                VertexCacheStatistics::of_each(&stored.runs, caches, flush_policy)
            }
            Some(_) => VertexCacheStatistics::of_each(&self.strips, caches, flush_policy),
        };
        // The simulation counts the triangles of a fan as if it were a strip.
        each.iter_mut().for_each(|used| used.triangles = self.stored.triangles);
        each
    }
}

/// Counts the vertices that parts use. Vertices that parts share are counted once.
pub(super) fn vertices_of(parts: &[MeasuredPart<'_>]) -> usize {
    let mut used: HashMap<*const [f32; 3], Vec<bool>> = HashMap::new();
    for part in parts {
        let positions = part.part.mesh.positions();
        let used = used.entry(positions.as_ptr()).or_insert_with(|| vec![false; positions.len()]);
        part.sent().iter().for_each(|&vertex| used[vertex as usize] = true);
    }
    used.values().map(|used| used.iter().filter(|&&used| used).count()).sum()
}

/// Sums over parts; shared vertices are counted once per part.
impl std::iter::Sum for StoredIndices {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        let add = |a: Option<usize>, b: Option<usize>| a.map_or(b, |a| Some(a + b.unwrap_or(0)));
        let both = |a: Self, b: Self| Self {
            drawn: if a.drawn == b.drawn { a.drawn } else { DrawMode::Mixed },
            triangles: a.triangles + b.triangles,
            vertices: a.vertices + b.vertices,
            indices: a.indices + b.indices,
            restarts: a.restarts + b.restarts,
            degenerate: a.degenerate + b.degenerate,
            strips: add(a.strips, b.strips),
            isolated: add(a.isolated, b.isolated),
            swaps: add(a.swaps, b.swaps),
            vertices_sent: add(a.vertices_sent, b.vertices_sent),
        };
        parts.reduce(both).unwrap_or_else(|| MeasuredPart::of(&Part::default()).stored)
    }
}

/// Sums over parts.
impl std::iter::Sum for StripLengths {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        let mut sum = Self::default();
        for bin in parts.flat_map(|part| part.0) {
            sum.add(bin.triangles, bin.strips);
        }
        sum
    }
}

/// A vertex cache for statistics that do not depend on it.
const ANY_CACHE: VertexCache = VertexCache::fifo(1);
