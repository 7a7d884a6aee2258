//! The measurements of one model: metrics of its mesh, and of the strips of each recipe, which are
//! proven first.

use std::collections::BTreeMap;
use std::sync::Mutex;

use rayon::prelude::*;
use serde::Serialize;
use tristrip::stripify::{Progress, Watch};
use tristrip::vertex_cache::{FlushPolicy, GeneralizedCost, Replacement, VertexCache, VertexCacheStatistics};
use tristrip::{StripifyOptions, Strips};
use tristrip_io::Model;
use tristrip_pipeline::{Error as PipelineError, PreparedModel, Search};

use super::components;
use super::level_figures::{self, LevelFigures};
use super::observer::ReproObserver;
use super::paper::ModelSize;
use super::recipe::{Recipe, parse_flags};
use super::recovery_figures;
use super::searches::Searches;
use super::view_data::TreeOrder;
use super::view_figures::{self, ViewFigures, ViewRequests};
use crate::error::Error;

/// The vertex caches for which misses per triangle are measured, in addition to those of every
/// report.
const CACHES: [VertexCache; 4] =
    [VertexCache::fifo(64), VertexCache::lru(16), VertexCache::lru(32), VertexCache::lru(64)];
/// The vertex-cache sizes for which generalized triangle meshes are measured.
pub(super) const CACHE_ENTRIES: std::ops::RangeInclusive<u32> = 2..=64;

/// The metric for the number of components that one strip draws.
pub(super) const ONE_STRIP_COMPONENTS: &str = "one_strip_components";

/// The measurements of a recipe in addition to the metrics of its strips.
#[allow(clippy::struct_excessive_bools, reason = "each is requested separately")]
#[derive(Debug, Clone, Default)]
pub(super) struct Extras {
    /// Generalized triangle meshes for every size of the vertex cache.
    pub(super) generalized: bool,
    /// Levels of detail.
    pub(super) levels: bool,
    /// The recovery of all levels.
    pub(super) recovery: bool,
    /// Components and their strips.
    pub(super) components: bool,
    /// Skip Strips, by the order of their merge trees.
    pub(super) views: BTreeMap<TreeOrder, ViewRequests>,
}

/// The measurements of a model.
#[derive(Debug, Default)]
pub(super) struct MeasuredModel {
    pub(super) size: ModelSize,
    pub(super) has_polygons: bool,
    mesh: BTreeMap<String, f64>,
    by_recipe: BTreeMap<Recipe, MeasuredStrips>,
}

/// The measurements of the strips of one recipe.
#[derive(Debug, Default)]
struct MeasuredStrips {
    figures: BTreeMap<String, f64>,
    /// The number of strips by node accesses, during the search; only for models of one part.
    progress: Vec<(u64, usize)>,
    /// The vertices transmitted for each of [`CACHE_ENTRIES`]: LRU and FIFO with a flush between
    /// strips, then LRU and FIFO without.
    transmitted: Vec<[usize; 4]>,
    levels: LevelFigures,
    recovery: BTreeMap<String, f64>,
    views: ViewFigures,
}

impl MeasuredModel {
    /// Measures a model with the recipes that `wanted` returns for it. The argument of `wanted` is
    /// whether the model has polygons.
    ///
    /// # Errors
    /// Strips are not proven, flags are invalid, or the user interrupts.
    pub(super) fn measure<'a>(
        model: &Model,
        name: &str,
        wanted: impl FnOnce(bool) -> Vec<(&'a Recipe, Extras)>,
        observer: &dyn ReproObserver,
    ) -> Result<Self, Error> {
        let prepared = PreparedModel::new(model, false);
        let mesh = prepared.mesh_figures();
        let has_polygons = mesh.faces < mesh.triangles;
        let mut measured = Self {
            size: ModelSize { vertices: mesh.vertices, triangles: mesh.triangles },
            has_polygons,
            mesh: numbers_of(&mesh),
            by_recipe: BTreeMap::new(),
        };
        let twos = components::of_two_triangles(&prepared) as f64;
        measured.mesh.insert("two_triangle_components".into(), twos);
        let recipes = wanted(has_polygons);
        let results = recipes.par_iter().map(|(recipe, extras)| {
            observer.recipe(&recipe.flags);
            measure_strips(&prepared, recipe, extras, observer)
        });
        let results: Vec<_> = results.collect();
        for ((recipe, _), result) in recipes.into_iter().zip(results) {
            let with_name = |error| match error {
                Error::Pipeline(PipelineError::Unproven { why, .. }) => {
                    PipelineError::unproven(format!("{name}, {}: {why}", recipe.flags)).into()
                }
                other => other,
            };
            measured.by_recipe.insert(recipe.clone(), result.map_err(with_name)?);
        }
        Ok(measured)
    }

    /// Returns a metric of the mesh.
    pub(super) fn mesh(&self, figure: &str) -> Option<f64> {
        self.mesh.get(figure).copied()
    }

    /// Returns the number of vertices that faces use.
    #[allow(clippy::cast_sign_loss, reason = "a count")]
    pub(super) fn used_vertices(&self) -> usize {
        self.size.vertices - self.mesh("unreferenced_vertices").unwrap_or(0.0) as usize
    }

    /// Returns a metric of strips.
    pub(super) fn strips(&self, recipe: &Recipe, figure: &str) -> Option<f64> {
        self.by_recipe.get(recipe)?.figures.get(figure).copied()
    }

    /// Returns a metric of levels of detail.
    pub(super) fn levels(&self, recipe: &Recipe, figure: &str) -> Option<f64> {
        self.by_recipe.get(recipe)?.levels.figures.get(figure).copied()
    }

    /// Returns a metric of the recovery of levels.
    pub(super) fn recovery(&self, recipe: &Recipe, figure: &str) -> Option<f64> {
        self.by_recipe.get(recipe)?.recovery.get(figure).copied()
    }

    /// Returns the measurements of Skip Strips.
    pub(super) fn views(&self, recipe: &Recipe) -> Option<&ViewFigures> {
        self.by_recipe.get(recipe).map(|measured| &measured.views)
    }

    /// Returns a metric of levels of detail as points: the level in percent of the collapses, and
    /// the value.
    pub(super) fn level_curve(&self, recipe: &Recipe, figure: &str) -> Vec<(f64, f64)> {
        let curves = self.by_recipe.get(recipe).map(|measured| &measured.levels.curves);
        curves.and_then(|curves| curves.get(figure)).cloned().unwrap_or_default()
    }

    /// Returns the number of strips by node accesses, during the search.
    pub(super) fn progress(&self, recipe: &Recipe) -> &[(u64, usize)] {
        self.by_recipe.get(recipe).map_or(&[], |measured| &measured.progress)
    }

    /// Returns the vertices that a generalized triangle mesh transmits, for each of
    /// [`CACHE_ENTRIES`].
    pub(super) fn transmitted(&self, recipe: &Recipe, rule: Replacement, between: FlushPolicy) -> Vec<f64> {
        let transmitted = self.by_recipe.get(recipe).map_or(&[][..], |measured| &measured.transmitted);
        let column = 2 * usize::from(between == FlushPolicy::Keep) + usize::from(rule == Replacement::Fifo);
        transmitted.iter().map(|row| row[column] as f64).collect()
    }
}

/// Returns all numbers of a report by their keys.
fn numbers_of(report: &impl Serialize) -> BTreeMap<String, f64> {
    let Ok(serde_json::Value::Object(object)) = serde_json::to_value(report) else { return BTreeMap::new() };
    object.into_iter().filter_map(|(key, value)| Some((key, value.as_f64()?))).collect()
}

/// Builds the strips of a recipe, then proves and measures them.
fn measure_strips(
    prepared: &PreparedModel<'_>,
    recipe: &Recipe,
    extras: &Extras,
    observer: &dyn ReproObserver,
) -> Result<MeasuredStrips, Error> {
    if observer.is_cancelled() {
        return Err(Error::Interrupted("not done"));
    }
    let levels = parse_flags(&recipe.flags)?;
    let options = levels.stripify;
    let watch = ProgressRecorder {
        outer: observer.search(&options),
        steps: recipe.steps,
        progress: Mutex::default(),
        searches: Mutex::default(),
    };
    let strips = prepared.find_strips(&options, &watch)?;
    if watch.outer.stopped().is_some() {
        return Err(Error::Interrupted("not done"));
    }
    prepared.prove(&strips)?;
    let mut progress = watch.progress.into_inner().unwrap_or_default();
    let searches = watch.searches.into_inner().unwrap_or_default();
    // The watch is called at intervals and may have missed the last joins.
    if let Some(accesses) = searches.accesses() {
        progress.push((accesses, strips.iter().map(Strips::len).sum()));
    }
    let mut figures = strip_figures(prepared, &strips, &options)?;
    figures.extend(searches.figures());
    if extras.components {
        figures.insert(ONE_STRIP_COMPONENTS.into(), components::drawn_by_one_strip(prepared, &strips) as f64);
    }
    Ok(MeasuredStrips {
        figures,
        progress,
        transmitted: if extras.generalized { transmitted(&strips) } else { Vec::new() },
        levels: if extras.levels {
            level_figures::measure(prepared, &strips, levels)?
        } else {
            LevelFigures::default()
        },
        recovery: if extras.recovery {
            recovery_figures::measure(prepared, &strips, levels)?
        } else {
            BTreeMap::new()
        },
        views: view_figures::measure(prepared, &strips, &options, &extras.views)?,
    })
}

fn strip_figures(
    prepared: &PreparedModel<'_>,
    strips: &[Strips],
    options: &StripifyOptions,
) -> Result<BTreeMap<String, f64>, Error> {
    let mut figures = numbers_of(&prepared.metrics(strips, options)?);
    for cache in CACHES {
        let statistics: VertexCacheStatistics =
            strips.iter().map(|strips| VertexCacheStatistics::of(strips, cache, FlushPolicy::Keep)).sum();
        let rule = if cache.replacement == Replacement::Lru { "lru" } else { "fifo" };
        figures.insert(format!("acmr_{rule}_{}", cache.entries), statistics.acmr());
    }
    Ok(figures)
}

/// Counts the vertices that generalized triangle meshes transmit, for each of [`CACHE_ENTRIES`].
fn transmitted(strips: &[Strips]) -> Vec<[usize; 4]> {
    let cost = |cache, between| {
        let costs = strips.iter().map(|strips| GeneralizedCost::of(strips, cache, between));
        costs.sum::<GeneralizedCost>().transmitted
    };
    let both =
        |entries, between| [VertexCache::lru(entries), VertexCache::fifo(entries)].map(|c| cost(c, between));
    let all = |entries| {
        let ([a, b], [c, d]) = (both(entries, FlushPolicy::Flush), both(entries, FlushPolicy::Keep));
        [a, b, c, d]
    };
    CACHE_ENTRIES.map(all).collect()
}

/// Records the progress of a search, and stops it after a number of steps.
struct ProgressRecorder<'a> {
    outer: Box<dyn Search + 'a>,
    steps: Option<u64>,
    /// Steps and the number of strips after them.
    progress: Mutex<Vec<(u64, usize)>>,
    searches: Mutex<Searches>,
}

impl Watch for ProgressRecorder<'_> {
    fn go_on(&self, progress: Progress) -> bool {
        if let Ok(mut recorded) = self.progress.lock() {
            // A search may not change the number of strips for a long time: record only changes.
            if recorded.last().is_none_or(|last| last.1 != progress.strips) {
                recorded.push((progress.steps, progress.strips));
            }
        }
        self.steps.is_none_or(|steps| progress.steps < steps) && self.outer.go_on(progress)
    }

    fn search_ended(&self, accesses: u64, has_found: bool) {
        if let Ok(mut searches) = self.searches.lock() {
            searches.add(accesses, has_found);
        }
        self.outer.search_ended(accesses, has_found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recorder_records_changes_and_stops_the_search() {
        let recorder = ProgressRecorder {
            outer: Box::new(()),
            steps: Some(30),
            progress: Mutex::default(),
            searches: Mutex::default(),
        };
        let go_on = |steps, strips| {
            let mut progress = Progress::default();
            (progress.steps, progress.strips) = (steps, strips);
            recorder.go_on(progress)
        };
        assert_eq!([(10, 5), (20, 5), (29, 4), (30, 3)].map(|(a, b)| go_on(a, b)), [true, true, true, false]);
        assert_eq!(recorder.progress.into_inner().unwrap(), [(10, 5), (29, 4), (30, 3)]);
    }
}
