//! The cost of building Skip Strips, and the properties of the model.

use std::sync::Arc;
use std::time::Instant;

use tristrip::lod::{Filter, SkipStrips};
use tristrip::simplify::{MergeOrder, SimplifyOptions, merge_tree};
use tristrip::{CollapseSequence, Mesh, Method, StripifyOptions, Strips, stripify};
use tristrip_bench::failure::Failure;
use tristrip_bench::measure::median;
use tristrip_bench::models::{Source, load};
use tristrip_bench::targets::Target;
use tristrip_bench::text::Table;

/// The models, with the maximum fraction of three vertices per triangle at full detail, and the
/// maximum seconds for the merge tree and the model.
const MODELS: [(&str, f64, Option<f64>); 3] =
    [("bunny", 0.39, Some(0.3)), ("terrain_gcanyon_512", 0.335, None), ("dragon", 0.43, Some(5.0))];
/// The maximum number of bytes per vertex, in addition to the strips.
const MAX_BYTES: f64 = 90.0;
/// The number of threads that price the collapses of the merge tree.
const TREE_THREADS: usize = 2;
/// How often a tree and its model are built. Times are medians.
const BUILDS: usize = 3;
/// The maximum time of a collapse or split, in nanoseconds.
const MAX_NANOSECONDS: f64 = 100.0;
/// The levels between which collapses and splits are timed, as fractions of all levels, and the
/// number of repetitions.
const MOVES: [usize; 4] = [4, 2, 3, 0];

/// A model that was built.
pub(super) struct BuiltModel {
    pub(super) mesh: Mesh,
    pub(super) strips: Strips,
    pub(super) sequence: Arc<CollapseSequence>,
    pub(super) model: Arc<SkipStrips>,
    pub(super) figures: BuildFigures,
}

/// The measurements.
pub(super) struct BuildFigures {
    pub(super) name: String,
    triangles: usize,
    vertices: usize,
    tree_seconds: f64,
    model_seconds: f64,
    levels: usize,
    height: u32,
    hops: [f64; 3],
    nanoseconds: f64,
    bytes: f64,
    view_bytes: f64,
    full: f64,
}

/// Builds a model that has targets; returns `None` for other models.
pub(super) fn build(source: &Source) -> Result<Option<BuiltModel>, Failure> {
    if MODELS.iter().all(|(name, ..)| *name != source.name) {
        return Ok(None);
    }
    let mesh = load(source)?.triangles;
    let strips = stripify(&mesh, &StripifyOptions::default().with_method(Method::Best))?;
    let threads = rayon::ThreadPoolBuilder::new().num_threads(TREE_THREADS).build()?;
    let (mut tree_times, mut model_times, mut built) = (Vec::new(), Vec::new(), None);
    for _ in 0..BUILDS {
        drop(built.take());
        let start = Instant::now();
        let list = strips.to_list();
        let tree = threads
            .install(|| merge_tree(&mesh, list, MergeOrder::default(), &SimplifyOptions::default()))?;
        tree_times.push(start.elapsed().as_secs_f64());
        let start = Instant::now();
        let model = Arc::new(SkipStrips::new(&strips, &tree.sequence, mesh.positions())?);
        model_times.push(start.elapsed().as_secs_f64());
        built = Some((tree, model));
    }
    let Some((tree, model)) = built else { return Ok(None) };
    let (triangles, vertices) = (strips.triangles().count(), mesh.vertex_count());
    let mut full = model.full_view();
    let sent = full.display_strips().vertices_sent();
    full.set_level(0)?;
    let figures = BuildFigures {
        name: source.name.clone(),
        triangles,
        vertices,
        tree_seconds: median(tree_times),
        model_seconds: median(model_times),
        levels: tree.level_ends.len(),
        height: model.height(),
        hops: model.view_by(Filter::Dtfs).mean_hops(),
        nanoseconds: nanoseconds_per_move(&model)?,
        bytes: model.memory_by_part()[1] as f64 / vertices as f64,
        view_bytes: full.memory() as f64 / vertices as f64,
        full: sent as f64 / (3 * triangles) as f64,
    };
    Ok(Some(BuiltModel { mesh, strips, sequence: Arc::new(tree.sequence), model, figures }))
}

/// Returns the mean time of a collapse or split, including its checks, over moves between levels.
fn nanoseconds_per_move(model: &Arc<SkipStrips>) -> Result<f64, Failure> {
    let count = model.levels().collapse_count();
    let mut view = model.view_without_strips();
    let (mut moved, mut level) = (0, 0);
    let start = Instant::now();
    for quarters in MOVES {
        let next = count * quarters / 4;
        view.set_level(next)?;
        moved += next.abs_diff(level);
        level = next;
    }
    Ok(1e9 * start.elapsed().as_secs_f64() / moved.max(1) as f64)
}

/// Compares with the targets.
pub(super) fn compare(built: &[BuildFigures]) -> Vec<Target> {
    let mut targets = Vec::new();
    for model in built {
        let Some(&(name, full, seconds)) = MODELS.iter().find(|(name, ..)| *name == model.name) else {
            continue;
        };
        targets.push(Target::at_most(format!("vertices sent at full detail, {name}"), full, model.full, 3));
        if let Some(seconds) = seconds {
            let found = model.tree_seconds + model.model_seconds;
            targets.push(Target::at_most(format!("seconds to build, {name}"), seconds, found, 1));
        }
        let what = format!("bytes per vertex beside the strips, {name}");
        targets.push(Target::at_most(what, MAX_BYTES, model.bytes, 0));
        let what = format!("nanoseconds per collapse or split with its checks, {name}");
        targets.push(Target::at_most(what, MAX_NANOSECONDS, model.nanoseconds, 0));
    }
    targets
}

/// Returns a row per model.
pub(super) fn table(built: &[BuildFigures]) -> Table {
    let heads = [
        "model",
        "triangles",
        "tree s",
        "model s",
        "levels",
        "height",
        "log 1.25",
        "parents",
        "skips",
        "ns per move",
        "bytes",
        "view bytes",
        "full",
    ];
    let mut table = Table::new(1, &heads);
    for model in built {
        table.push(vec![
            model.name.clone(),
            model.triangles.to_string(),
            format!("{:.2}", model.tree_seconds),
            format!("{:.2}", model.model_seconds),
            model.levels.to_string(),
            model.height.to_string(),
            format!("{:.1}", (model.vertices as f64).ln() / 1.25_f64.ln()),
            format!("{:.2}", model.hops[0]),
            format!("{:.2}", model.hops[1]),
            format!("{:.0}", model.nanoseconds),
            format!("{:.1}", model.bytes),
            format!("{:.1}", model.view_bytes),
            format!("{:.4}", model.full),
        ]);
    }
    table
}
