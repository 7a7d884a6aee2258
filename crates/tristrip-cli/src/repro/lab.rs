//! Measurements: each method that a paper asks for, on each model that it asks it for, proven before its figures count.
//!
//! First everything is asked for, then every model is read once and all that was asked for is done with it, and then the figures
//! are there. A model that is not in the folder has none.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use clap::Parser;
use indicatif::ProgressBar;
use serde::Serialize;
use tristrip::strip::{Between, Buffer, BufferUse, GeneralizedCost, Replacement};
use tristrip::stripify::{Progress, Watch};
use tristrip::{Options, Strips};
use tristrip_io::Format;

use super::levels::{self, LevelsFound};
use super::paper::{self, ModelSet};
use crate::console::Console;
use crate::failure::Failure;
use crate::figures::{Figures, MeshFigures};
use crate::input::{load, meshes};
use crate::method::MethodArgs;
use crate::search::{SearchWatch, interrupted};
use crate::stages::{Pool, Prepared, find_strips, prepare, prove};
use crate::task::Input;

/// The buffers for which misses per triangle are measured beside those of every report.
const BUFFERS: [Buffer; 4] = [Buffer::fifo(64), Buffer::lru(16), Buffer::lru(32), Buffer::lru(64)];
/// The sizes of the buffers of generalized triangle meshes.
pub(super) const PLACES: std::ops::RangeInclusive<u32> = 2..=64;

/// How strips are found: the flags of `tristrip strip`, and accesses to nodes after which a search is stopped.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Recipe {
    pub(crate) flags: String,
    pub(crate) steps: Option<u64>,
}

impl From<&str> for Recipe {
    fn from(flags: &str) -> Self {
        Self { flags: flags.into(), steps: None }
    }
}

#[derive(Debug, Parser)]
struct Flags {
    #[command(flatten)]
    method: MethodArgs,
}

/// Makes options of flags as they are typed.
pub(crate) fn parse_flags(flags: &str) -> Result<Options, Failure> {
    let words = std::iter::once("tristrip").chain(flags.split_whitespace());
    let flags = Flags::try_parse_from(words).map_err(|error| Failure::Input(error.to_string()))?;
    flags.method.validate(false).map_err(Failure::Input)
}

/// Which models something is measured on.
#[derive(Debug, Default)]
struct Scope {
    all: bool,
    polygons: bool,
    names: BTreeSet<String>,
    /// Models for which generalized triangle meshes are measured as well.
    buffers: BTreeSet<String>,
    /// Models for which levels of detail are measured as well.
    levels: BTreeSet<String>,
}

impl Scope {
    fn holds(&self, name: &str, has_polygons: bool) -> bool {
        self.all || (self.polygons && has_polygons) || self.names.contains(name)
    }
}

/// What was measured of a model.
#[derive(Debug, Default)]
pub(super) struct Measured {
    pub(super) vertices: usize,
    pub(super) triangles: usize,
    pub(super) has_polygons: bool,
    mesh: BTreeMap<String, f64>,
    found: BTreeMap<Recipe, Found>,
}

/// What was measured of strips.
#[derive(Debug, Default)]
struct Found {
    figures: BTreeMap<String, f64>,
    /// Accesses to nodes and the strips that were left, as the search went; of a model of one part.
    progress: Vec<(u64, usize)>,
    /// For each of [`PLACES`] the vertices transmitted: LRU and FIFO, flushed between strips, and kept.
    buffers: Vec<[usize; 4]>,
    levels: LevelsFound,
}

/// The models and what is measured of them.
#[derive(Debug)]
pub(crate) struct Lab {
    models: BTreeMap<String, PathBuf>,
    wanted: BTreeMap<Recipe, Scope>,
    wanted_meshes: Scope,
    measured: BTreeMap<String, Measured>,
}

impl Lab {
    /// Lists the models of a folder.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub(crate) fn new(folder: &Path) -> Result<Self, Failure> {
        let entries = std::fs::read_dir(folder).map_err(|error| Failure::system(folder, &error))?;
        let mut paths = Vec::new();
        for entry in entries {
            let path = entry.map_err(|error| Failure::system(folder, &error))?.path();
            if Format::from_path(&path).is_some() {
                paths.push(path);
            }
        }
        // Of two files of one name the first counts.
        paths.sort_unstable_by(|a, b| b.cmp(a));
        let named = |path: PathBuf| Some((path.file_stem()?.to_str()?.to_owned(), path));
        Ok(Self {
            models: paths.into_iter().filter_map(named).collect(),
            wanted: BTreeMap::new(),
            wanted_meshes: Scope::default(),
            measured: BTreeMap::new(),
        })
    }

    /// Asks for strips of a model.
    pub(super) fn want(&mut self, recipe: Recipe, model: &str) {
        self.wanted.entry(recipe).or_default().names.insert(model.into());
        self.want_mesh(model);
    }

    /// Asks for strips of a model as generalized triangle meshes, for buffers of all sizes.
    pub(super) fn want_buffers(&mut self, recipe: Recipe, model: &str) {
        self.wanted.entry(recipe.clone()).or_default().buffers.insert(model.into());
        self.want(recipe, model);
    }

    /// Asks for the levels of detail of a model, whose strips a recipe finds.
    pub(super) fn want_levels(&mut self, recipe: Recipe, model: &str) {
        self.wanted.entry(recipe.clone()).or_default().levels.insert(model.into());
        self.want(recipe, model);
    }

    /// Asks for strips of many models; those of tables are asked for one by one.
    pub(super) fn want_set(&mut self, recipe: Recipe, set: ModelSet) {
        let scope = self.wanted.entry(recipe).or_default();
        match set {
            ModelSet::All => scope.all = true,
            ModelSet::Polygons => scope.polygons = true,
            ModelSet::Table => return,
        }
        self.wanted_meshes.all = true;
    }

    /// Asks for the figures of a mesh.
    pub(super) fn want_mesh(&mut self, model: &str) {
        self.wanted_meshes.names.insert(model.into());
    }

    /// Measures what was asked for; gives the models that could not be read, each with the reason.
    ///
    /// # Errors
    /// Strips are not proven, flags make no sense, or the user interrupts.
    pub(super) fn measure(&mut self, pool: &Pool, console: &mut Console) -> Result<Vec<String>, Failure> {
        let mut notes = Vec::new();
        let wanted = |name: &String| self.wanted_meshes.holds(name, false);
        let models: Vec<_> = self.models.iter().filter(|(name, _)| wanted(name)).collect();
        let count = models.len();
        for (number, (name, path)) in models.into_iter().enumerate() {
            console.begin(&format!("{name} ({} of {count})", number + 1), None);
            let input = Input { path: Some(path.clone()), format: None };
            let measured = match load(&input) {
                Ok(model) => measure(&meshes(&model), name, &self.wanted, pool, console),
                Err(failure) => {
                    console.note(&failure.to_string());
                    notes.push(format!("{name}: {failure}"));
                    console.end();
                    continue;
                }
            };
            console.end();
            self.measured.insert(name.clone(), measured?);
        }
        Ok(notes)
    }

    /// Gives what was measured of a model.
    pub(super) fn model(&self, name: &str) -> Option<&Measured> {
        self.measured.get(name)
    }

    /// Lists the models that were measured.
    pub(super) fn models(&self) -> impl Iterator<Item = (&str, &Measured)> {
        self.measured.iter().map(|(name, measured)| (name.as_str(), measured))
    }
}

impl Measured {
    /// Gives a figure of the mesh.
    pub(super) fn mesh(&self, figure: &str) -> Option<f64> {
        self.mesh.get(figure).copied()
    }

    /// Gives the vertices that are in use.
    pub(super) fn vertices_in_use(&self) -> f64 {
        self.vertices as f64 - self.mesh("unreferenced_vertices").unwrap_or(0.0)
    }

    /// Gives a figure of strips.
    pub(super) fn strips(&self, recipe: &Recipe, figure: &str) -> Option<f64> {
        self.found.get(recipe)?.figures.get(figure).copied()
    }

    /// Gives a figure of levels of detail.
    pub(super) fn levels(&self, recipe: &Recipe, figure: &str) -> Option<f64> {
        self.found.get(recipe)?.levels.figures.get(figure).copied()
    }

    /// Gives a figure of levels of detail by level, in percent of the collapses.
    pub(super) fn curve(&self, recipe: &Recipe, figure: &str) -> Vec<(f64, f64)> {
        let curves = self.found.get(recipe).map(|found| &found.levels.curves);
        curves.and_then(|curves| curves.get(figure)).cloned().unwrap_or_default()
    }

    /// Gives the strips that were left after so many accesses.
    pub(super) fn progress(&self, recipe: &Recipe) -> &[(u64, usize)] {
        self.found.get(recipe).map_or(&[], |found| &found.progress)
    }

    /// Gives for each of [`PLACES`] the vertices that a generalized triangle mesh transmits.
    pub(super) fn transmitted(&self, recipe: &Recipe, rule: Replacement, between: paper::Strips) -> Vec<f64> {
        let buffers = self.found.get(recipe).map_or(&[][..], |found| &found.buffers);
        let at = 2 * usize::from(between == paper::Strips::Keep) + usize::from(rule == Replacement::Fifo);
        buffers.iter().map(|costs| costs[at] as f64).collect()
    }
}

/// Takes all figures out of a report.
fn figures_of(report: &impl Serialize) -> BTreeMap<String, f64> {
    let Ok(serde_json::Value::Object(object)) = serde_json::to_value(report) else { return BTreeMap::new() };
    object.into_iter().filter_map(|(key, value)| Some((key, value.as_f64()?))).collect()
}

fn measure(
    meshes: &[&tristrip::Mesh],
    name: &str,
    wanted: &BTreeMap<Recipe, Scope>,
    pool: &Pool,
    console: &Console,
) -> Result<Measured, Failure> {
    let parts = prepare(pool, meshes, false);
    let mesh = MeshFigures::of(pool, &parts);
    let has_polygons = mesh.faces < mesh.triangles;
    let mut measured = Measured {
        vertices: mesh.vertices,
        triangles: mesh.triangles,
        has_polygons,
        mesh: figures_of(&mesh),
        found: BTreeMap::new(),
    };
    let recipes: Vec<_> = wanted.iter().filter(|(_, scope)| scope.holds(name, has_polygons)).collect();
    let bar = console.progress();
    let found = pool.map(&recipes, |(recipe, scope)| {
        bar.set_message(recipe.flags.clone());
        find(&parts, recipe, (scope.buffers.contains(name), scope.levels.contains(name)), pool, &bar)
    });
    for ((recipe, _), found) in recipes.into_iter().zip(found) {
        let named = |failure| match failure {
            Failure::Unproven(why) => Failure::Unproven(format!("{name}, {}: {why}", recipe.flags)),
            other => other,
        };
        measured.found.insert(recipe.clone(), found.map_err(named)?);
    }
    Ok(measured)
}

/// Finds strips, proves them, and measures them.
fn find(
    parts: &[Prepared<'_>],
    recipe: &Recipe,
    (with_buffers, with_levels): (bool, bool),
    pool: &Pool,
    bar: &ProgressBar,
) -> Result<Found, Failure> {
    if interrupted() {
        return Err(Failure::Input("not done: interrupted".into()));
    }
    let options = parse_flags(&recipe.flags)?;
    let outer = SearchWatch::new(bar.clone(), None, &options);
    let watch = Recorder { outer, steps: recipe.steps, seen: Mutex::default() };
    let strips = find_strips(pool, parts, &options, &watch)?.strips;
    if watch.outer.stopped().is_some() {
        return Err(Failure::Input("not done: interrupted".into()));
    }
    prove(pool, parts, &strips, &options)?;
    Ok(Found {
        figures: strip_figures(parts, &strips, &options, pool),
        progress: watch.seen.into_inner().unwrap_or_default(),
        buffers: if with_buffers { transmitted(parts, &strips) } else { Vec::new() },
        levels: if with_levels { levels::measure(parts, &strips, pool)? } else { LevelsFound::default() },
    })
}

fn strip_figures(
    parts: &[Prepared<'_>],
    strips: &[Strips],
    options: &Options,
    pool: &Pool,
) -> BTreeMap<String, f64> {
    let mut figures = figures_of(&Figures::of(pool, parts, strips, options));
    let pairs: Vec<_> = parts.iter().zip(strips).collect();
    for buffer in BUFFERS {
        let used: BufferUse = pairs
            .iter()
            .map(|(part, strips)| BufferUse::of(strips, buffer, Between::Keep, part.mesh.vertex_count()))
            .sum();
        let kind = if buffer.replacement == Replacement::Lru { "lru" } else { "fifo" };
        figures.insert(format!("acmr_{kind}_{}", buffer.places), used.acmr());
    }
    figures
}

/// Counts the vertices that generalized triangle meshes transmit, for each of [`PLACES`].
fn transmitted(parts: &[Prepared<'_>], strips: &[Strips]) -> Vec<[usize; 4]> {
    let cost = |buffer, between| {
        let costs = parts
            .iter()
            .zip(strips)
            .map(|(part, strips)| GeneralizedCost::of(strips, buffer, between, part.mesh.vertex_count()));
        costs.sum::<GeneralizedCost>().transmitted
    };
    let both = |places, between| [Buffer::lru(places), Buffer::fifo(places)].map(|b| cost(b, between));
    let all = |places| {
        let ([a, b], [c, d]) = (both(places, Between::Flush), both(places, Between::Keep));
        [a, b, c, d]
    };
    PLACES.map(all).collect()
}

/// Keeps what a search reached, and stops it after so many steps.
struct Recorder {
    outer: SearchWatch,
    steps: Option<u64>,
    seen: Mutex<Vec<(u64, usize)>>,
}

impl Watch for Recorder {
    fn go_on(&self, progress: Progress) -> bool {
        if let Ok(mut seen) = self.seen.lock() {
            // Only what is new: a search may be at the same number of strips for long.
            if seen.last().is_none_or(|last| last.1 != progress.strips) {
                seen.push((progress.steps, progress.strips));
            }
        }
        self.steps.is_none_or(|steps| progress.steps < steps) && self.outer.go_on(progress)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::task::Shared;

    #[test]
    fn flags_are_those_of_the_command() {
        assert!(parse_flags("--method eta --start input").is_ok());
        assert!(parse_flags("--method sgi --start input").is_err());
        assert!(parse_flags("--colour red").is_err());
    }

    #[test]
    fn what_was_asked_for_is_measured_and_nothing_else() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/models");
        let pool = Pool::new(Some(1)).unwrap();
        let mut console = Console::new(&Shared { json: false, quiet: true, threads: Some(1) }, false);
        let mut lab = Lab::new(&folder).unwrap();
        let stripe = Recipe::from("--method stripe");
        lab.want(stripe.clone(), "hand");
        lab.want_buffers("--method sgi".into(), "fish_control");
        lab.want("--method sgi".into(), "nobody");
        assert_eq!(lab.measure(&pool, &mut console).unwrap(), Vec::<String>::new());
        assert_eq!(lab.models().map(|(name, _)| name).collect::<Vec<_>>(), ["fish_control", "hand"]);
        let (fish, hand) = (lab.model("fish_control").unwrap(), lab.model("hand").unwrap());
        assert!(fish.has_polygons && !hand.has_polygons && lab.model("nobody").is_none());
        assert_eq!((hand.triangles, hand.vertices), (15_982, 7993));
        assert_eq!(hand.strips(&"--method sgi".into(), "strips"), None);
        assert!(
            hand.strips(&stripe, "strips").unwrap() > 10.0
                && hand.transmitted(&stripe, Replacement::Lru, paper::Strips::Keep).is_empty()
        );
        // A buffer of two is the machine of the GL cost.
        let sgi = Recipe::from("--method sgi");
        let transmitted = fish.transmitted(&sgi, Replacement::Lru, paper::Strips::Flush);
        assert_eq!(Some(transmitted[0]), fish.strips(&sgi, "gl_cost"));
        assert!(transmitted.is_sorted_by(|a, b| a >= b) && transmitted.len() == 63);
    }

    #[test]
    fn a_recorder_keeps_what_is_new_and_stops_in_time() {
        let outer = SearchWatch::new(ProgressBar::hidden(), None, &Options::default());
        let recorder = Recorder { outer, steps: Some(30), seen: Mutex::default() };
        let reaches = |steps, strips| {
            let mut progress = Progress::default();
            (progress.steps, progress.strips) = (steps, strips);
            recorder.go_on(progress)
        };
        assert_eq!(
            [(10, 5), (20, 5), (29, 4), (30, 3)].map(|(a, b)| reaches(a, b)),
            [true, true, true, false]
        );
        assert_eq!(recorder.seen.into_inner().unwrap(), [(10, 5), (29, 4), (30, 3)]);
    }
}
