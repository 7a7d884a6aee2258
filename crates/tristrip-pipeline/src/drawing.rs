//! Chooses how a file draws each part: as strips or as a list, whichever takes the fewest indices.
//! By default, a file never has more indices than its source.
//!
//! Strips are shorter than a list only if triangles share edges. A strip of one triangle takes four
//! indices with its restart, or six if degenerate triangles join it. In a list, the triangle takes
//! three. A flat-shaded model, in which every edge is a seam, is smaller as a list.
//!
//! # Algorithm
//! Each part is drawn by the candidate with the fewest indices: the strips of the method, in the
//! layout of the file; the strips stored in the source, in the same layout; or the faces as a list,
//! if the options allow it. In a tie, the first candidate wins.
//!
//! # Complexity
//! Linear time; 4 bytes per vertex while the vertex cache of a part is simulated.

use serde::Serialize;
use tristrip::Metrics;
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip::{Layout, Mesh, Strips};
use tristrip_io::{Drawing, Format, Model, Part};

use crate::encode;
use crate::figures::PartMetrics;
use crate::metrics::rounded;
use crate::parts::map;
use crate::text::counted;

/// The vertex cache that reports use.
const CACHE: VertexCache = VertexCache::fifo(16);

/// How a part is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum DrawnAs {
    /// The strips that a method found.
    Found,
    /// The strips that the source stores.
    Stored,
    /// The faces, as a list.
    List,
}

/// The index count and the vertex-cache misses of a model, summed over its parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct IndexCost {
    /// The number of indices, including restarts and degenerate triangles. Polygons count as fans.
    pub indices: usize,
    /// The number of triangles, without degenerate ones.
    pub triangles: usize,
    /// The misses of a FIFO vertex cache of 16 entries, empty at the start of each part.
    pub misses: usize,
}

impl IndexCost {
    /// Returns the misses per triangle.
    pub(crate) fn acmr(&self) -> f64 {
        if self.triangles == 0 { 0.0 } else { self.misses as f64 / self.triangles as f64 }
    }

    /// Measures a mesh drawn as a triangle list, polygons as fans.
    fn of_faces(mesh: &Mesh) -> Self {
        let list = mesh.faces().fans();
        let used = VertexCacheStatistics::of_list(list.as_chunks().0, CACHE);
        Self { indices: list.len(), triangles: used.triangles, misses: used.misses }
    }

    /// Returns the cost of strips from their metrics, which were measured with the same vertex
    /// cache.
    fn of_found(figures: &PartMetrics, layout: Layout) -> Self {
        let PartMetrics { metrics, fifo_16 } = figures;
        let indices = index_count(metrics, layout);
        Self { indices, triangles: metrics.triangles, misses: fifo_16.misses }
    }

    /// Measures strips.
    fn of_strips(strips: &Strips, indices: usize) -> Self {
        let used = VertexCacheStatistics::of(strips, CACHE, FlushPolicy::Keep);
        Self { indices, triangles: used.triangles, misses: used.misses }
    }

    /// Measures a part as its file draws it.
    fn of_source(part: &Part, list: Self) -> Self {
        let Some(stored) = &part.stored else { return list };
        let used = Self::of_strips(&stored.runs, stored.indices());
        // The simulation counts the triangles of a fan as if it were a strip.
        Self { triangles: part.mesh.faces().face_count(), ..used }
    }
}

impl std::iter::Sum for IndexCost {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |a, b| Self {
            indices: a.indices + b.indices,
            triangles: a.triangles + b.triangles,
            misses: a.misses + b.misses,
        })
    }
}

/// The index statistics and the size of a file. The field names are the keys of the JSON report.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FileCost {
    /// The number of indices, including restarts and degenerate triangles. Polygons count as fans,
    /// except in a PLY file that was written, where their corners count.
    pub indices: usize,
    /// Misses per triangle in a FIFO vertex cache of 16 entries, empty at the start of each part.
    pub acmr_fifo_16: f64,
    /// The size in bytes; `None` for standard input, and for a `.gltf`, because its buffers may be
    /// in other files.
    pub bytes: Option<u64>,
}

impl FileCost {
    /// Combines a cost and a file size.
    pub(crate) fn of(cost: &IndexCost, bytes: Option<u64>) -> Self {
        Self { indices: cost.indices, acmr_fifo_16: rounded(cost.acmr()), bytes }
    }
}

/// The number of parts per kind of drawing. The field names are the keys of the JSON report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct DrawnParts {
    /// The number of parts drawn as the strips of the method.
    pub found: usize,
    /// The number of parts drawn as the strips that the input stores.
    pub stored: usize,
    /// The number of parts drawn as a triangle list.
    pub list: usize,
}

impl DrawnParts {
    /// Returns a note per kind of parts that are not drawn as the strips of the method.
    pub(crate) fn notes(&self) -> Vec<String> {
        let stored =
            format!("{} drawn as the strips of the input: fewer indices", counted(self.stored, "part"));
        let list = format!("{} drawn as faces, not as strips: fewer indices", counted(self.list, "part"));
        [(self.stored, stored), (self.list, list)]
            .into_iter()
            .filter(|(n, _)| *n > 0)
            .map(|(_, note)| note)
            .collect()
    }
}

/// The drawings of a model in a file, and their cost.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Drawn<'a> {
    /// The drawing of each part, in order, for the writer.
    pub drawings: Vec<Drawing<'a>>,
    /// How each part is drawn, in order.
    pub drawn_as: Vec<DrawnAs>,
    /// The cost of the source as it was read.
    pub before: IndexCost,
    /// The cost of the drawings in the layout of the file.
    pub after: IndexCost,
}

impl Drawn<'_> {
    /// Counts the parts per kind of drawing.
    pub(crate) fn parts(&self) -> DrawnParts {
        let count = |kind| self.drawn_as.iter().filter(|&&one| one == kind).count();
        DrawnParts {
            found: count(DrawnAs::Found),
            stored: count(DrawnAs::Stored),
            list: count(DrawnAs::List),
        }
    }
}

/// Chooses how each part is drawn. With `keep_found`, the strips of the method are drawn even if
/// they take more indices.
pub(crate) fn choose<'a>(
    model: &'a Model,
    (strips, figures): (&'a [Strips], &[PartMetrics]),
    options: encode::Options,
    keep_found: bool,
) -> Drawn<'a> {
    // OBJ has no strips. Its triangles are written in strip order.
    let layout = if options.format == Format::Obj { Layout::List } else { options.layout };
    let keep_found = keep_found || layout == Layout::List;
    let all: Vec<_> = model.parts.iter().zip(strips).zip(figures).collect();
    let chosen = map(&all, |&((part, found), figures)| {
        let list = IndexCost::of_faces(&part.mesh);
        let before = IndexCost::of_source(part, list);
        let mut best = (DrawnAs::Found, Drawing::Strips(found), IndexCost::of_found(figures, layout));
        let mut fewest = best.2.indices;
        if keep_found {
            return (best, before);
        }
        if let Some(stored) = part.stored.as_ref().filter(|stored| !stored.fans) {
            let indices = index_count(&Metrics::of(&stored.runs), layout);
            let cost = IndexCost::of_strips(&stored.runs, indices);
            if cost.indices < fewest {
                (best, fewest) = ((DrawnAs::Stored, Drawing::Strips(&stored.runs), cost), cost.indices);
            }
        }
        let written =
            if options.format == Format::Ply { part.mesh.faces().corner_count() } else { list.indices };
        if options.list && written < fewest {
            best = (DrawnAs::List, Drawing::Faces, IndexCost { indices: written, ..list });
        }
        (best, before)
    });
    let before = chosen.iter().map(|(_, before)| *before).sum();
    let after = chosen.iter().map(|((.., cost), _)| *cost).sum();
    let (drawn_as, drawings) = chosen.iter().map(|((kind, drawing, _), _)| (*kind, *drawing)).unzip();
    Drawn { drawings, drawn_as, before, after }
}

/// Returns the number of indices of strips in a layout.
fn index_count(metrics: &Metrics, layout: Layout) -> usize {
    match layout {
        Layout::Restart => metrics.indices_restart,
        Layout::Degenerate => metrics.indices_degenerate,
        Layout::Separate => metrics.vertices_sent,
        Layout::List => 3 * metrics.triangles,
    }
}
