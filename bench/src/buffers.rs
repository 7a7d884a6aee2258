//! Vertex buffers: indices and misses of `cache`, as points in a plane, next to meshoptimizer's in the same run; and how fast the
//! simulators are.
//!
//! ```text
//! misses
//!   │  ■ · ○          ○ a point of meshoptimizer
//!   │      ·          ■ a setting of ours with fewer indices at no more misses,
//!   │      ●          ● one with fewer misses at no more indices: with both, the point is beaten
//!   └────────── indices
//! ```
//!
//! Every answer is proven before its figures are kept. The speed of `cache` is not measured here but with the other methods, round by
//! round beside meshoptimizer.

use std::time::Instant;

use serde::Serialize;
use tristrip::strip::{Cost, Metrics};
use tristrip::verify::verify;
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheSimulator, VertexCacheStatistics};
use tristrip::{Mesh, Method, Strips, stripify};

use crate::Failure;
use crate::measure::median;
use crate::methods::{CACHE, Named, PREFERENCES};
use crate::models::{Source, load};
use crate::rivals::{Pipeline, strips_of};

/// The buffer that everything is judged by.
pub const BUFFER: VertexCache = VertexCache::fifo(16);
/// A buffer of one place less, which gives the figures that the peers' table has for 16 places.
pub const SMALLER: VertexCache = VertexCache::fifo(15);
/// The effort of the longer searches,
pub const EFFORT: u8 = 5;
/// and on models of more triangles than [`LARGE`].
pub const LARGE_EFFORT: u8 = 3;
/// Above so many triangles the longer searches are shorter.
pub const LARGE: usize = 150_000;
/// Models on which the simulators are timed, on the strips of `cache`.
pub const SIMULATED: [&str; 2] = ["bunny", "dragon"];
/// The simulators that are timed.
const SIMULATORS: [VertexCache; 2] = [VertexCache::fifo(16), VertexCache::lru(16)];
const SIMULATOR_ROUNDS: usize = 15;

/// What some strips cost.
#[derive(Debug, Clone, Serialize)]
pub struct Point {
    /// The setting, or the rival.
    pub by: String,
    /// Always true: what is not proven is not shown.
    pub proven: bool,
    /// Indices with restarts.
    pub indices: usize,
    /// Misses of [`BUFFER`], kept from strip to strip.
    pub misses: usize,
    /// Misses of [`SMALLER`].
    pub misses_fifo_15: usize,
    /// Time of one run.
    pub seconds: f64,
}

/// A simulator's speed.
#[derive(Debug, Clone, Serialize)]
pub struct Simulator {
    /// The buffer, as `fifo:16`.
    pub buffer: String,
    /// Median over several rounds.
    pub indices_per_second: f64,
}

/// Everything that was found on a model.
#[derive(Debug, Clone, Serialize)]
pub struct Buffered {
    /// The model's name.
    pub model: String,
    /// Triangles.
    pub triangles: usize,
    /// Meshoptimizer's points, one for each of [`Pipeline::ALL`].
    pub rivals: Vec<Point>,
    /// Ours, in the same order for every model: `cache` by what it prefers, the same at a higher effort, and `best`.
    pub ours: Vec<Point>,
    /// Speeds, on models of [`SIMULATED`].
    pub simulators: Vec<Simulator>,
}

impl Buffered {
    /// Finds the fewest indices at no more misses than a rival has; none where the rival's are as few.
    pub fn fewer_indices(&self, rival: &Point) -> Option<&Point> {
        let better = self.ours.iter().filter(|p| p.misses <= rival.misses && p.indices < rival.indices);
        better.min_by_key(|p| (p.indices, p.misses))
    }

    /// Finds the fewest misses at no more indices than a rival has; none where the rival's are as few.
    pub fn fewer_misses(&self, rival: &Point) -> Option<&Point> {
        let better = self.ours.iter().filter(|p| p.indices <= rival.indices && p.misses < rival.misses);
        better.min_by_key(|p| (p.misses, p.indices))
    }

    /// Tells whether a rival is beaten both ways.
    pub fn beats(&self, rival: &Point) -> bool {
        self.fewer_indices(rival).is_some() && self.fewer_misses(rival).is_some()
    }

    /// Gives a figure a triangle.
    pub fn per_triangle(&self, count: usize) -> f64 {
        count as f64 / self.triangles.max(1) as f64
    }

    /// Gives the point of one of our settings.
    pub fn setting(&self, name: &str) -> Option<&Point> {
        self.ours.iter().find(|point| point.by == name)
    }
}

/// Counts the models on which each of meshoptimizer's points is beaten both ways, in the order of [`Pipeline::ALL`].
pub fn beaten(buffered: &[Buffered]) -> [usize; Pipeline::ALL.len()] {
    std::array::from_fn(|i| buffered.iter().filter(|b| b.rivals.get(i).is_some_and(|r| b.beats(r))).count())
}

/// Finds and proves all points of a model, and times the simulators.
///
/// # Errors
/// The model cannot be read, a result is not proven, or a simulator miscounts.
pub fn search(source: &Source) -> Result<Buffered, Failure> {
    let mesh = load(source)?.triangles;
    let say = |name: &str, error: Failure| format!("{}, {name}: {error}", source.name);
    let (mut ours, mut rivals, mut simulators) = (Vec::new(), Vec::new(), Vec::new());
    for Named { name, options } in settings(mesh.faces().face_count()) {
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
        rivals.push(point(&mesh, name, run).map_err(|error| say(name, error))?.0);
    }
    let triangles = mesh.faces().face_count();
    Ok(Buffered { model: source.name.clone(), triangles, rivals, ours, simulators })
}

/// Lists our settings for a model of so many triangles.
fn settings(triangles: usize) -> Vec<Named> {
    let effort = if triangles > LARGE { LARGE_EFFORT } else { EFFORT };
    let usual = PREFERENCES.map(|(prefer, _)| Named::cache(BUFFER, prefer));
    let longer = PREFERENCES.map(|(prefer, _)| Named::cache(BUFFER, prefer).at(effort));
    let best = Named::search(Method::Best, 2, Cost::Restart);
    usual.into_iter().chain(longer).chain([best]).collect()
}

/// Runs a way to strips once, and proves what it gives.
fn point(
    mesh: &Mesh,
    name: &str,
    run: impl FnOnce() -> Result<Strips, Failure>,
) -> Result<(Point, Strips), Failure> {
    let start = Instant::now();
    let strips = run()?;
    let seconds = start.elapsed().as_secs_f64();
    verify(mesh, &strips).map_err(|error| format!("not proven: {error}"))?;
    let both =
        VertexCacheStatistics::of_each(&strips, &[BUFFER, SMALLER], FlushPolicy::Keep, mesh.vertex_count());
    let point = Point {
        by: name.into(),
        proven: true,
        indices: Metrics::of(&strips).indices_restart,
        misses: both[0].misses,
        misses_fifo_15: both[1].misses,
        seconds,
    };
    Ok((point, strips))
}

/// Times the simulators in turns, after their answers were compared with those of a buffer that is sent one vertex after the other.
fn simulate(strips: &Strips, vertex_count: usize) -> Result<Vec<Simulator>, Failure> {
    let mut times = SIMULATORS.map(|_| Vec::new());
    let run = |buffer| VertexCacheStatistics::of(strips, buffer, FlushPolicy::Keep, vertex_count).misses;
    let expected = SIMULATORS.map(|buffer| {
        let mut one_by_one = VertexCacheSimulator::new(buffer, vertex_count);
        strips.vertices().iter().filter(|&&vertex| !one_by_one.send(vertex)).count()
    });
    for _ in 0..SIMULATOR_ROUNDS {
        for ((buffer, expected), times) in SIMULATORS.into_iter().zip(expected).zip(&mut times) {
            let start = Instant::now();
            let misses = run(buffer);
            times.push(start.elapsed().as_secs_f64());
            if misses != expected {
                return Err(format!("{buffer}: {misses} misses, one by one {expected}").into());
            }
        }
    }
    let speed = |times| strips.vertices_sent() as f64 / median(times);
    let simulator = |(buffer, times): (VertexCache, _)| Simulator {
        buffer: buffer.to_string(),
        indices_per_second: speed(times),
    };
    Ok(SIMULATORS.into_iter().zip(times).map(simulator).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn point(by: &str, indices: usize, misses: usize) -> Point {
        Point { by: by.into(), proven: true, indices, misses, misses_fifo_15: misses, seconds: 0.1 }
    }

    #[test]
    fn a_point_is_beaten_by_two_settings_or_one() {
        let rivals = vec![point("corner", 10, 10), point("few indices", 5, 20), point("few misses", 20, 7)];
        let ours = vec![point("a", 10, 8), point("b", 9, 10), point("c", 6, 20)];
        let found = Buffered { model: "m".into(), triangles: 5, rivals, ours, simulators: Vec::new() };
        let by = |point: Option<&Point>| point.map(|p| p.by.clone());
        assert_eq!(by(found.fewer_indices(&found.rivals[0])).as_deref(), Some("b"));
        assert_eq!(by(found.fewer_misses(&found.rivals[0])).as_deref(), Some("a"));
        assert!(found.fewer_indices(&found.rivals[1]).is_none());
        assert!(found.fewer_misses(&found.rivals[2]).is_none());
        assert_eq!(beaten(&[found]), [1, 0, 0]);
    }

    #[test]
    fn equal_points_do_not_beat_each_other() {
        let (rivals, ours) = (vec![point("theirs", 10, 10)], vec![point("ours", 10, 10)]);
        let found = Buffered { model: "m".into(), triangles: 5, rivals, ours, simulators: Vec::new() };
        assert!(found.fewer_indices(&found.rivals[0]).is_none());
        assert!(found.fewer_misses(&found.rivals[0]).is_none());
    }

    #[test]
    fn every_setting_and_rival_has_a_point() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../testdata/models/catmark_bishop.ply");
        let found = search(&Source { name: "catmark_bishop".into(), path }).unwrap();
        let names: Vec<String> = settings(found.triangles).into_iter().map(|s| s.name).collect();
        assert_eq!(found.ours.iter().map(|p| p.by.clone()).collect::<Vec<_>>(), names);
        assert_eq!(found.rivals.len(), Pipeline::ALL.len());
        assert!(found.setting(CACHE).is_some() && found.simulators.is_empty());
        for point in found.ours.iter().chain(&found.rivals) {
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
        assert_eq!(simulators.iter().map(|s| s.buffer.as_str()).collect::<Vec<_>>(), ["fifo:16", "lru:16"]);
        assert!(simulators.iter().all(|s| s.indices_per_second > 0.0));
    }
}
