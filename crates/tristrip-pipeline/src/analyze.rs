//! Index and vertex-cache statistics of a model, as stored in its file. No strips are built.

mod stored;
mod vertex_caches;

use serde::{Serialize, Serializer};
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip_io::{Model, Part};

use crate::error::Error;
use crate::metrics::rounded;
use crate::observer::{Observer, Stage, begin};
use crate::parts::map;
pub use stored::{DrawMode, LengthBin, StoredIndices};
use stored::{MeasuredPart, StripLengths, vertices_of};
pub use vertex_caches::VertexCacheList;

/// Options for simulating vertex caches.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Options {
    /// The vertex caches.
    pub vertex_caches: VertexCacheList,
    /// Whether caches are flushed between strips.
    pub flush_policy: FlushPolicy,
}

impl Options {
    tristrip::setters! {
        /// Sets the vertex caches.
        with_vertex_caches(vertex_caches: VertexCacheList);

        /// Sets whether caches are flushed between strips.
        with_flush_policy(flush_policy: FlushPolicy);
    }
}

/// The index and vertex-cache statistics of a model. The field names are the keys of the JSON
/// report.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// The sums over all parts; vertices that parts share are counted once.
    #[serde(flatten)]
    pub stored: StoredIndices,
    /// `indices` divided by `triangles`.
    pub indices_per_triangle: f64,
    /// The histogram of strip lengths, the shortest strips first. The bounds double from entry to
    /// entry.
    pub lengths: Vec<LengthBin>,
    /// Whether the vertex cache is flushed between strips.
    pub flushed: bool,
    /// The misses of each vertex cache, summed over all parts. The cache is empty at the start of
    /// each part.
    pub vertex_caches: Vec<CacheMisses>,
    /// The number of parts: glTF primitives or OBJ materials.
    pub parts: usize,
    /// The statistics of each part, in the order of the file.
    pub by_part: Vec<StoredPart>,
    /// Human-readable notes of the reader.
    pub notes: Vec<String>,
}

/// The misses of one vertex cache.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CacheMisses {
    /// The vertex cache, such as `fifo:16`.
    #[serde(serialize_with = "as_text")]
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub vertex_cache: VertexCache,
    /// The number of cache misses.
    pub misses: usize,
    /// Cache misses divided by `triangles`.
    pub acmr: f64,
    /// Cache misses divided by `vertices`.
    pub atvr: f64,
}

/// One part of a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct StoredPart {
    /// The name of the object, group or mesh; `None` if it has none.
    pub name: Option<String>,
    /// The name of the material; `None` if it has none.
    pub material: Option<String>,
    /// The statistics of the part.
    #[serde(flatten)]
    pub stored: StoredIndices,
    /// The misses of each vertex cache, in the order of `vertex_caches`.
    pub misses: Vec<usize>,
}

/// Counts triangles, strips and indices of a model as stored, and simulates vertex caches.
///
/// # Errors
/// The observer cancelled the operation.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::analyze;
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let options = analyze::Options::default().with_vertex_caches("fifo:16".parse().unwrap_or_default());
/// let found = analyze::run(&model, &options, &())?;
/// assert_eq!((found.stored.indices, found.vertex_caches[0].misses), (6, 4));
/// assert_eq!(found.by_part[0].stored, found.stored);
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(model: &Model, options: &Options, observer: &dyn Observer) -> Result<Outcome, Error> {
    begin(observer, Stage::Analyze)?;
    let caches = &options.vertex_caches.0;
    let parts: Vec<&Part> = model.parts.iter().collect();
    let measured = map(&parts, |&part| {
        let measured = MeasuredPart::of(part);
        let statistics = measured.simulate(caches, options.flush_policy);
        (measured, statistics)
    });
    let (measured, statistics): (Vec<_>, Vec<_>) = measured.into_iter().unzip();
    let stored =
        StoredIndices { vertices: vertices_of(&measured), ..measured.iter().map(|one| one.stored).sum() };
    let by_part = parts.iter().zip(&measured).zip(&statistics).map(|((part, one), statistics)| StoredPart {
        name: part.name.clone(),
        material: part.material.clone(),
        stored: one.stored,
        misses: statistics.iter().map(|used| used.misses).collect(),
    });
    let by_part: Vec<StoredPart> = by_part.collect();
    let (triangles, vertices) = (stored.triangles, stored.vertices);
    let sum = |(i, &vertex_cache): (usize, &VertexCache)| {
        let misses = by_part.iter().map(|part| part.misses[i]).sum();
        let used = VertexCacheStatistics { misses, triangles, vertices };
        CacheMisses { vertex_cache, misses, acmr: rounded(used.acmr()), atvr: rounded(used.atvr()) }
    };
    let per_triangle = if triangles == 0 { 0.0 } else { stored.indices as f64 / triangles as f64 };
    Ok(Outcome {
        stored,
        indices_per_triangle: rounded(per_triangle),
        vertex_caches: caches.iter().enumerate().map(sum).collect(),
        lengths: measured.into_iter().map(|one| one.lengths).sum::<StripLengths>().into_bins(),
        flushed: options.flush_policy == FlushPolicy::Flush,
        parts: by_part.len(),
        by_part,
        notes: model.notes.clone(),
    })
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde calls")]
fn as_text<S: Serializer>(cache: &VertexCache, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(cache)
}
