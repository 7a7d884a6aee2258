//! Vertex caches: indices and misses of `cache`, as points in a plane, compared with meshoptimizer
//! in the same run; and the speed of the simulators.
//!
//! ```text
//! misses
//!   │  ■ · ○          ○ a point of meshoptimizer
//!   │      ·          ■ a setting of ours with fewer indices and no more misses,
//!   │      ●          ● one with fewer misses and no more indices: with both, the point is beaten
//!   └────────── indices
//! ```
//!
//! Every result is proven before its metrics are kept. The speed of `cache` is measured with the
//! other methods, in rounds that alternate with meshoptimizer.

use std::time::Instant;

use serde::Serialize;
use tristrip::stripify::Objective;
use tristrip::verify::verify;
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheSimulator, VertexCacheStatistics};
use tristrip::{Cost, Metrics};
use tristrip::{Mesh, Method, Strips, stripify};

use crate::failure::Failure;
use crate::measure::median;
use crate::meshoptimizer::{Pipeline, strips_of};
use crate::methods::{CACHE, NamedMethod};
use crate::models::{Source, load};

/// The vertex cache of all targets.
pub const REFERENCE_CACHE: VertexCache = VertexCache::fifo(16);
/// A vertex cache with one entry less. The peers' table gives its values for 16 entries.
pub const SMALLER_CACHE: VertexCache = VertexCache::fifo(15);
/// The effort of the longer searches.
pub const EFFORT: u8 = 5;
/// The effort of the longer searches on models with more triangles than [`LARGE`].
pub const LARGE_EFFORT: u8 = 3;
/// Above this number of triangles, the longer searches use the lower effort.
pub const LARGE: usize = 150_000;
/// The models on which the simulators are timed, on the strips of `cache`.
pub const SIMULATED: [&str; 2] = ["bunny", "dragon"];
/// The simulators that are timed.
const SIMULATORS: [VertexCache; 2] = [VertexCache::fifo(16), VertexCache::lru(16)];
const SIMULATOR_ROUNDS: usize = 15;

/// The indices and misses of strips.
#[derive(Debug, Clone, Serialize)]
pub struct CachePoint {
    /// The setting, or the pipeline of meshoptimizer.
    pub by: String,
    /// Always true: results that are not proven are not shown.
    pub proven: bool,
    /// The number of indices with restarts.
    pub indices: usize,
    /// The misses of [`REFERENCE_CACHE`], not flushed between strips.
    pub misses: usize,
    /// The misses of [`SMALLER_CACHE`].
    pub misses_fifo_15: usize,
    /// The time of one run, in seconds.
    pub seconds: f64,
}

/// A simulator's speed.
#[derive(Debug, Clone, Serialize)]
pub struct SimulatorSpeed {
    /// The vertex cache, such as `fifo:16`.
    pub vertex_cache: String,
    /// The median over several rounds.
    pub indices_per_second: f64,
}

/// The results on a model.
#[derive(Debug, Clone, Serialize)]
pub struct CacheResults {
    /// The model's name.
    pub model: String,
    /// The number of triangles.
    pub triangles: usize,
    /// The results of meshoptimizer, one per item of [`Pipeline::ALL`].
    pub meshoptimizer: Vec<CachePoint>,
    /// Our results, in the same order for every model: `cache` by objective, `cache` at a higher
    /// effort, and `best`.
    pub ours: Vec<CachePoint>,
    /// The speeds, on the models of [`SIMULATED`].
    pub simulators: Vec<SimulatorSpeed>,
}

impl CacheResults {
    /// Returns our result with the fewest indices among those with no more misses than a result of
    /// meshoptimizer; `None` if it does not have fewer indices.
    pub fn fewer_indices(&self, theirs: &CachePoint) -> Option<&CachePoint> {
        let better = self.ours.iter().filter(|p| p.misses <= theirs.misses && p.indices < theirs.indices);
        better.min_by_key(|p| (p.indices, p.misses))
    }

    /// Returns our result with the fewest misses among those with no more indices than a result of
    /// meshoptimizer; `None` if it does not have fewer misses.
    pub fn fewer_misses(&self, theirs: &CachePoint) -> Option<&CachePoint> {
        let better = self.ours.iter().filter(|p| p.indices <= theirs.indices && p.misses < theirs.misses);
        better.min_by_key(|p| (p.misses, p.indices))
    }

    /// Checks whether a result of meshoptimizer is beaten in indices and in misses.
    pub fn beats(&self, theirs: &CachePoint) -> bool {
        self.fewer_indices(theirs).is_some() && self.fewer_misses(theirs).is_some()
    }

    /// Returns a count per triangle.
    pub fn per_triangle(&self, count: usize) -> f64 {
        count as f64 / self.triangles.max(1) as f64
    }

    /// Returns the result of one of our settings.
    pub fn setting(&self, name: &str) -> Option<&CachePoint> {
        self.ours.iter().find(|point| point.by == name)
    }
}

/// Counts the models on which each result of meshoptimizer is beaten in indices and in misses, in
/// the order of [`Pipeline::ALL`].
pub fn beaten(caches: &[CacheResults]) -> [usize; Pipeline::ALL.len()] {
    std::array::from_fn(|i| {
        caches.iter().filter(|b| b.meshoptimizer.get(i).is_some_and(|r| b.beats(r))).count()
    })
}

/// Measures and proves all results of a model, and times the simulators.
///
/// # Errors
/// The model cannot be read, a result is not proven, or a simulator counts wrongly.
pub fn search(source: &Source) -> Result<CacheResults, Failure> {
    let mesh = load(source)?.triangles;
    let say = |name: &str, error: Failure| format!("{}, {name}: {error}", source.name);
    let (mut ours, mut meshoptimizer, mut simulators) = (Vec::new(), Vec::new(), Vec::new());
    for NamedMethod { name, options } in settings(mesh.faces().face_count()) {
        let run = || Ok(stripify(&mesh, &options)?);
        let (point, strips) = point(&mesh, &name, run).map_err(|error| say(&name, error))?;
        if name == CACHE && SIMULATED.contains(&source.name.as_str()) {
            simulators = simulate(&strips, mesh.vertex_count())?;
        }
        ours.push(point);
    }
    for pipeline in Pipeline::ALL {
        let name = pipeline.name();
        let run = || Ok(strips_of(&pipeline.run(&mesh)?));
        meshoptimizer.push(point(&mesh, name, run).map_err(|error| say(name, error))?.0);
    }
    let triangles = mesh.faces().face_count();
    Ok(CacheResults { model: source.name.clone(), triangles, meshoptimizer, ours, simulators })
}

/// Returns our settings for a model with this number of triangles.
fn settings(triangles: usize) -> Vec<NamedMethod> {
    let effort = if triangles > LARGE { LARGE_EFFORT } else { EFFORT };
    let usual = Objective::ALL.map(|objective| NamedMethod::cache(REFERENCE_CACHE, objective));
    let longer = Objective::ALL.map(|objective| NamedMethod::cache(REFERENCE_CACHE, objective).at(effort));
    let best = NamedMethod::search(Method::Best, 2, Cost::Restart);
    usual.into_iter().chain(longer).chain([best]).collect()
}

/// Builds strips once and proves them.
fn point(
    mesh: &Mesh,
    name: &str,
    run: impl FnOnce() -> Result<Strips, Failure>,
) -> Result<(CachePoint, Strips), Failure> {
    let start = Instant::now();
    let strips = run()?;
    let seconds = start.elapsed().as_secs_f64();
    verify(mesh, &strips).map_err(|error| format!("not proven: {error}"))?;
    let both = VertexCacheStatistics::of_each(&strips, &[REFERENCE_CACHE, SMALLER_CACHE], FlushPolicy::Keep);
    let point = CachePoint {
        by: name.into(),
        proven: true,
        indices: Metrics::of(&strips).indices_restart,
        misses: both[0].misses,
        misses_fifo_15: both[1].misses,
        seconds,
    };
    Ok((point, strips))
}

/// Times the simulators in alternation. First compares their misses with those of a cache that
/// receives one vertex at a time.
fn simulate(strips: &Strips, vertex_count: usize) -> Result<Vec<SimulatorSpeed>, Failure> {
    let mut times = SIMULATORS.map(|_| Vec::new());
    let run = |cache| VertexCacheStatistics::of(strips, cache, FlushPolicy::Keep).misses;
    let count = |cache| -> Result<usize, Failure> {
        let mut one_by_one = VertexCacheSimulator::new(cache, vertex_count)?;
        strips.vertices().iter().try_for_each(|&vertex| one_by_one.send(vertex).map(drop))?;
        Ok(one_by_one.misses())
    };
    let expected = SIMULATORS.into_iter().map(count).collect::<Result<Vec<_>, _>>()?;
    for _ in 0..SIMULATOR_ROUNDS {
        for ((cache, expected), times) in SIMULATORS.into_iter().zip(&expected).zip(&mut times) {
            let start = Instant::now();
            let misses = run(cache);
            times.push(start.elapsed().as_secs_f64());
            if misses != *expected {
                return Err(format!("{cache}: {misses} misses, {expected} one by one").into());
            }
        }
    }
    let speed = |times| strips.vertices_sent() as f64 / median(times);
    let simulator = |(cache, times): (VertexCache, _)| SimulatorSpeed {
        vertex_cache: cache.to_string(),
        indices_per_second: speed(times),
    };
    Ok(SIMULATORS.into_iter().zip(times).map(simulator).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn point(by: &str, indices: usize, misses: usize) -> CachePoint {
        CachePoint { by: by.into(), proven: true, indices, misses, misses_fifo_15: misses, seconds: 0.1 }
    }

    #[test]
    fn a_point_is_beaten_by_two_settings_or_one() {
        let meshoptimizer =
            vec![point("corner", 10, 10), point("few indices", 5, 20), point("few misses", 20, 7)];
        let ours = vec![point("a", 10, 8), point("b", 9, 10), point("c", 6, 20)];
        let found =
            CacheResults { model: "m".into(), triangles: 5, meshoptimizer, ours, simulators: Vec::new() };
        let by = |point: Option<&CachePoint>| point.map(|p| p.by.clone());
        assert_eq!(by(found.fewer_indices(&found.meshoptimizer[0])).as_deref(), Some("b"));
        assert_eq!(by(found.fewer_misses(&found.meshoptimizer[0])).as_deref(), Some("a"));
        assert!(found.fewer_indices(&found.meshoptimizer[1]).is_none());
        assert!(found.fewer_misses(&found.meshoptimizer[2]).is_none());
        assert_eq!(beaten(&[found]), [1, 0, 0]);
    }

    #[test]
    fn equal_points_do_not_beat_each_other() {
        let (meshoptimizer, ours) = (vec![point("theirs", 10, 10)], vec![point("ours", 10, 10)]);
        let found =
            CacheResults { model: "m".into(), triangles: 5, meshoptimizer, ours, simulators: Vec::new() };
        assert!(found.fewer_indices(&found.meshoptimizer[0]).is_none());
        assert!(found.fewer_misses(&found.meshoptimizer[0]).is_none());
    }

    #[test]
    fn every_setting_and_rival_has_a_point() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../testdata/models/catmark_bishop.ply");
        let found = search(&Source { name: "catmark_bishop".into(), path }).unwrap();
        let names: Vec<String> = settings(found.triangles).into_iter().map(|s| s.name).collect();
        assert_eq!(found.ours.iter().map(|p| p.by.clone()).collect::<Vec<_>>(), names);
        assert_eq!(found.meshoptimizer.len(), Pipeline::ALL.len());
        assert!(found.setting(CACHE).is_some() && found.simulators.is_empty());
        for point in found.ours.iter().chain(&found.meshoptimizer) {
            assert!(point.proven && point.indices > found.triangles, "{point:?}");
            assert!(point.misses <= point.misses_fifo_15 && point.misses * 3 > found.triangles, "{point:?}");
        }
    }

    #[test]
    fn settings_are_shorter_on_large_models() {
        let names = |triangles| settings(triangles).into_iter().map(|s| s.name).collect::<Vec<_>>();
        assert_eq!(names(LARGE)[4], format!("{CACHE} {EFFORT}"));
        assert_eq!(names(LARGE + 1)[4], format!("{CACHE} {LARGE_EFFORT}"));
    }

    #[test]
    fn simulators_agree_and_have_speeds() {
        let mut strips = Strips::default();
        strips.push(&[0, 1, 2, 3, 0, 4]);
        strips.push(&[5, 3, 1]);
        let simulators = simulate(&strips, 6).unwrap();
        assert_eq!(
            simulators.iter().map(|s| s.vertex_cache.as_str()).collect::<Vec<_>>(),
            ["fifo:16", "lru:16"]
        );
        assert!(simulators.iter().all(|s| s.indices_per_second > 0.0));
    }
}
