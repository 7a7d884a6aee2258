//! The statistics of a model with the keys of the JSON report.

use serde::Serialize;
use tristrip::vertex_cache::{VertexCache, VertexCacheStatistics};
use tristrip_io::{Model, Part};

use super::{Analysis, PartAnalysis, StoredFigures};
use crate::figures::rounded;

/// The misses of one vertex cache, summed over all parts.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct VertexCacheReport {
    /// The vertex cache: `fifo:16`.
    pub vertex_cache: String,
    /// Vertices that must be transformed again.
    pub misses: usize,
    /// Misses per triangle.
    pub acmr: f64,
    /// Misses per used vertex.
    pub atvr: f64,
}

/// One part of a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct PartReport {
    /// The name of the object, group or mesh.
    pub name: Option<String>,
    /// The name of the material.
    pub material: Option<String>,
    /// The figures of the part.
    #[serde(flatten)]
    pub figures: StoredFigures,
    /// In the order of the report's vertex caches.
    pub misses: Vec<usize>,
}

impl VertexCacheReport {
    fn of(cache: VertexCache, used: VertexCacheStatistics) -> Self {
        let (acmr, atvr) = (rounded(used.acmr()), rounded(used.atvr()));
        Self { vertex_cache: cache.to_string(), misses: used.misses, acmr, atvr }
    }
}

impl Analysis {
    /// Returns the indices per triangle, rounded to six decimals.
    pub fn indices_per_triangle(&self) -> f64 {
        match self.figures.triangles {
            0 => 0.0,
            triangles => rounded(self.figures.indices as f64 / triangles as f64),
        }
    }

    /// Reports each vertex cache.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{AnalyzeOptions, analyze};
    /// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
    /// let analysis = analyze(&model, &AnalyzeOptions::default());
    /// assert!(analysis.cache_reports().iter().all(|cache| cache.misses == 3));
    /// assert_eq!(analysis.part_reports(&model)[0].figures, analysis.figures);
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn cache_reports(&self) -> Vec<VertexCacheReport> {
        self.vertex_caches.iter().map(|&(cache, used)| VertexCacheReport::of(cache, used)).collect()
    }

    /// Reports each part of the model.
    pub fn part_reports(&self, model: &Model) -> Vec<PartReport> {
        let report = |(part, analyzed): (&Part, &PartAnalysis)| PartReport {
            name: part.name.clone(),
            material: part.material.clone(),
            figures: analyzed.figures,
            misses: analyzed.misses.clone(),
        };
        model.parts.iter().zip(&self.parts).map(report).collect()
    }
}
