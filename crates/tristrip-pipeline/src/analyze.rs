//! Index and vertex-cache statistics of a model as its file stores it. No strips are built.

mod report;
mod stored;
mod vertex_caches;

use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip_io::{Model, Part};

use crate::parts::map;
pub use report::{PartReport, VertexCacheReport};
pub use stored::{DrawMode, LengthBin, StoredFigures, StripLengths};
use stored::{StoredPart, vertices_of};
pub use vertex_caches::VertexCacheList;

/// Which vertex caches are simulated.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct AnalyzeOptions {
    /// The vertex caches.
    pub vertex_caches: VertexCacheList,
    /// Whether caches are flushed between strips.
    pub flush_policy: FlushPolicy,
}

impl AnalyzeOptions {
    /// Sets the vertex caches.
    #[must_use]
    pub fn with_vertex_caches(self, vertex_caches: VertexCacheList) -> Self {
        Self { vertex_caches, ..self }
    }

    /// Sets whether caches are flushed between strips.
    #[must_use]
    pub fn with_flush_policy(self, flush_policy: FlushPolicy) -> Self {
        Self { flush_policy, ..self }
    }
}

/// The statistics of a model.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Analysis {
    /// The sums over all parts; vertices that parts share are counted once.
    pub figures: StoredFigures,
    /// The histogram of strip lengths.
    pub lengths: StripLengths,
    /// Each vertex cache with its statistics, summed over all parts; each part starts with an empty cache.
    pub vertex_caches: Vec<(VertexCache, VertexCacheStatistics)>,
    /// The parts in their order.
    pub parts: Vec<PartAnalysis>,
}

/// The statistics of a part.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct PartAnalysis {
    /// The figures of the part.
    pub figures: StoredFigures,
    /// The misses of each vertex cache, in the order of [`Analysis::vertex_caches`].
    pub misses: Vec<usize>,
}

/// Counts triangles, strips and indices of a model as stored, and simulates vertex caches.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{AnalyzeOptions, analyze};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let options = AnalyzeOptions::default().with_vertex_caches("fifo:16".parse().unwrap_or_default());
/// let analysis = analyze(&model, &options);
/// assert_eq!((analysis.figures.indices, analysis.vertex_caches[0].1.misses), (6, 4));
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn analyze(model: &Model, options: &AnalyzeOptions) -> Analysis {
    let caches = &options.vertex_caches.0;
    let parts: Vec<&Part> = model.parts.iter().collect();
    let measured = map(&parts, |&part| {
        let stored = StoredPart::of(part);
        let statistics = stored.simulate(caches, options.flush_policy);
        (stored, statistics)
    });
    let (stored, statistics): (Vec<_>, Vec<_>) = measured.into_iter().unzip();
    let figures =
        StoredFigures { vertices: vertices_of(&stored), ..stored.iter().map(|one| one.figures).sum() };
    let parts = stored.iter().zip(&statistics).map(|(one, statistics)| PartAnalysis {
        figures: one.figures,
        misses: statistics.iter().map(|used| used.misses).collect(),
    });
    let parts: Vec<PartAnalysis> = parts.collect();
    let (triangles, vertices) = (figures.triangles, figures.vertices);
    let sum = |i: usize| {
        let misses = parts.iter().map(|part| part.misses[i]).sum();
        VertexCacheStatistics { misses, triangles, vertices }
    };
    let vertex_caches = caches.iter().enumerate().map(|(i, &cache)| (cache, sum(i))).collect();
    let lengths = stored.into_iter().map(|one| one.lengths).sum();
    Analysis { figures, lengths, vertex_caches, parts }
}
