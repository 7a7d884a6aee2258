//! The claims about `blocks`: the time and memory of a move compared with the published models, the
//! upload of a move, and the vertices sent.

use std::sync::Arc;
use std::time::Instant;

use tristrip::lod::{BlockOptions, Blocks, LevelCursor, ModelKind, RepairOptions};
use tristrip::{CollapseSequence, Effort, Index, Method, StripifyOptions, Strips};
use tristrip_bench::failure::Failure;
use tristrip_bench::measure::median;
use tristrip_bench::memory::extra_bytes;
use tristrip_bench::models::Source;
use tristrip_bench::targets::Target;
use tristrip_bench::text::Table;
use tristrip_io::read_path;
use tristrip_lab::baselines::ComparedModel;
use tristrip_lab::recovery::ModelRecovery;
use tristrip_pipeline::{Ratio, levels, levels::LevelPart};

/// The models that `blocks` is compared with.
const PUBLISHED: [ComparedModel; 3] =
    [ComparedModel::Library(ModelKind::Sets), ComparedModel::Mts, ComparedModel::LodStrips];
/// The models whose moves are measured.
const MOVED: [&str; 3] = ["cow", "bunny", "dragon"];
/// The models with a target for the vertices sent over all levels.
const SENT: [&str; 2] = ["cow", "bunny"];
/// The number of equally spaced moves from the full mesh down.
const MOVES: usize = 99;
/// The maximum number of ranges that a move may upload.
const RANGES: usize = 256;
/// The number of timed single steps, and the spacing of their start levels.
const STEPS: usize = 1000;

/// The measurements of `blocks` on a model, over strips of `best`.
pub(super) struct MeasuredBlocks {
    model: String,
    options: BlockOptions,
    triangles: usize,
    memory: usize,
    keys: usize,
    /// The vertices sent over all levels, as a fraction of three per triangle.
    sent: f64,
    /// The times of the moves in milliseconds, and the fraction of the buffer that each move
    /// uploads, both sorted.
    milliseconds: Vec<f64>,
    uploaded: Vec<f64>,
    /// The mean time of a step by one level, up or down, in microseconds.
    step_microseconds: f64,
}

/// The build time and memory of `sets`, `mts`, `lod-strips` and `blocks`.
pub(super) struct MeasuredBuild {
    model: String,
    seconds: f64,
    bytes_per_triangle: f64,
}

/// Measures `blocks` with its defaults, and with options for the fewest vertices sent.
pub(super) fn measure_all(sources: &[Source]) -> Result<Vec<MeasuredBlocks>, Failure> {
    let mut figures = Vec::new();
    for source in sources.iter().filter(|source| MOVED.contains(&source.name.as_str())) {
        let part = part_of(source, Method::Best)?;
        figures.push(of_part(&source.name, &part, BlockOptions::default())?);
        if SENT.contains(&source.name.as_str()) {
            figures.push(of_part(&source.name, &part, fewest_vertices())?);
        }
        if source.name == "dragon" {
            figures.push(of_part(&source.name, &part, small_uploads())?);
        }
    }
    Ok(figures)
}

/// Builds all four models of the dragon.
pub(super) fn build_all(sources: &[Source]) -> Result<Option<MeasuredBuild>, Failure> {
    let Some(source) = sources.iter().find(|source| source.name == "dragon") else { return Ok(None) };
    let part = part_of(source, Method::STRIPE)?;
    let kinds = [&PUBLISHED[..], &[ComparedModel::Library(ModelKind::Blocks)]].concat();
    let start = Instant::now();
    // All models are in memory at the end. They are dropped before the remaining bytes are counted.
    let (built, bytes) = extra_bytes(|| {
        let models = kinds.iter().map(|kind| kind.build(part.strips(), part.sequence()));
        models.collect::<Result<Vec<_>, _>>().map(|models| models.len())
    });
    built?;
    Ok(Some(MeasuredBuild {
        model: source.name.clone(),
        seconds: start.elapsed().as_secs_f64(),
        bytes_per_triangle: bytes.unwrap_or(0) as f64 / part.strips().triangles().count().max(1) as f64,
    }))
}

/// Returns the largest part of a model with its collapses.
fn part_of(source: &Source, method: Method) -> Result<LevelPart, Failure> {
    let stripify = StripifyOptions::default().with_method(method);
    let options = levels::Options::default().with_stripify(stripify).with_base(Ratio::ZERO);
    let levels = levels::run(&read_path(&source.path)?, &options, &())?.model;
    let largest = levels.parts.into_iter().max_by_key(|part| part.strips().vertices_sent());
    largest.ok_or_else(|| format!("{}: no part", source.name).into())
}

/// Returns options that send few vertices: more memory, and a long search.
fn fewest_vertices() -> BlockOptions {
    let repair = RepairOptions::default().with_effort(Effort::new(7).unwrap_or_default());
    BlockOptions::default().with_memory(24).with_repair(repair)
}

/// Returns options that upload little per move.
fn small_uploads() -> BlockOptions {
    BlockOptions::default().with_memory(36).with_small_uploads(true)
}

fn of_part(name: &str, part: &LevelPart, options: BlockOptions) -> Result<MeasuredBlocks, Failure> {
    let (strips, sequence) = (part.strips(), part.sequence());
    if sequence.vertex_count() <= usize::from(u16::RESTART) {
        of_type::<u16>(name, strips, sequence, options)
    } else {
        of_type::<u32>(name, strips, sequence, options)
    }
}

fn of_type<I: Index>(
    name: &str,
    strips: &Strips,
    sequence: &Arc<CollapseSequence>,
    options: BlockOptions,
) -> Result<MeasuredBlocks, Failure> {
    let model = Arc::new(Blocks::new(strips, Arc::clone(sequence), &options)?);
    let mut cursor = model.cursor::<I>()?;
    let last = sequence.len();
    // 1. The vertices of all levels, or of every hundredth level if there are many.
    let (mut sent, mut in_lists) = (0, 0);
    for level in (0..=last).rev().step_by(if last > 100_000 { 100 } else { 1 }) {
        cursor.set_level(level)?;
        sent += cursor.indices().iter().filter(|&&index| index != I::RESTART).count();
        in_lists += 3 * sequence.triangle_count(level)?;
    }
    // 2. Moves by one percent of the levels.
    cursor.set_level(last)?;
    cursor.take_changed(RANGES);
    let (mut milliseconds, mut uploaded) = (Vec::new(), Vec::new());
    for number in (1..=MOVES).rev() {
        let level = last * number / (MOVES + 1);
        let start = Instant::now();
        cursor.set_level(level)?;
        milliseconds.push(1e3 * start.elapsed().as_secs_f64());
        let changed: usize = cursor.take_changed(RANGES).into_iter().map(|range| range.len()).sum();
        uploaded.push(changed as f64 / cursor.indices().len().max(1) as f64);
    }
    milliseconds.sort_unstable_by(f64::total_cmp);
    uploaded.sort_unstable_by(f64::total_cmp);
    // 3. Single steps, down and up again, from levels over the whole range.
    let mut times = Vec::new();
    for number in 1..=STEPS {
        let level = (last * number / STEPS).max(1);
        cursor.set_level(level)?;
        let start = Instant::now();
        cursor.set_level(level - 1)?;
        cursor.set_level(level)?;
        times.push(1e6 * start.elapsed().as_secs_f64() / 2.0);
    }
    Ok(MeasuredBlocks {
        model: name.into(),
        options,
        triangles: sequence.triangle_count(last)?,
        memory: tristrip::lod::LevelModel::memory(&*model),
        keys: model.keys().len(),
        sent: sent as f64 / in_lists.max(1) as f64,
        milliseconds,
        uploaded,
        step_microseconds: times.iter().sum::<f64>() / times.len() as f64,
    })
}

/// Compares the recovery times and memory of a model with the published models.
pub(super) fn compare_recovery(model: &str, measured: &[ModelRecovery]) -> Vec<Target> {
    let of = |kind: ComparedModel| measured.iter().find(|model| model.model == kind.name());
    let (Some(blocks), Some(mts)) = (of(ComparedModel::Library(ModelKind::Blocks)), of(ComparedModel::Mts))
    else {
        return Vec::new();
    };
    let ratio = |(i, test): (usize, &tristrip_lab::recovery::RecoveryTest)| {
        let of_others = PUBLISHED.iter().filter_map(|&kind| Some(of(kind)?.tests.get(i)?.microseconds));
        Some(test.microseconds / of_others.min_by(f64::total_cmp)?)
    };
    let worst = blocks.tests.iter().enumerate().filter_map(ratio).reduce(f64::max).unwrap_or(f64::INFINITY);
    let what =
        format!("time of blocks relative to the quickest published model, worst of all tests, {model}");
    let time = Target::at_most(what, 0.6, worst, 2);
    let what = format!("memory of blocks relative to mts, {model}");
    let is_built = blocks.error.is_none() && mts.error.is_none();
    let ratio = if is_built { blocks.memory as f64 / mts.memory.max(1) as f64 } else { f64::INFINITY };
    vec![time, Target::at_most(what, 1.0, ratio, 2)]
}

/// Compares with the targets.
pub(super) fn compare(figures: &[MeasuredBlocks], built: Option<&MeasuredBuild>) -> Vec<Target> {
    let mut targets = Vec::new();
    for model in figures {
        if SENT.contains(&model.model.as_str()) {
            let what = format!(
                "vertices sent by blocks over all levels, {} bytes per triangle, {}",
                model.options.memory, model.model
            );
            targets.push(Target::at_most(what, 0.42, model.sent, 2));
        }
        let is_default = model.options == BlockOptions::default();
        if model.model == "bunny" && is_default {
            let what = "a step of blocks by one level, mean microseconds, bunny".into();
            targets.push(Target::at_most(what, 5.0, model.step_microseconds, 1));
        }
        if model.model == "dragon" {
            let how = if is_default { "" } else { " with small uploads" };
            let what = format!("a move of blocks{how} by 1 % of the levels, median ms, dragon");
            targets.push(Target::at_most(what, 0.5, median(model.milliseconds.clone()), 1));
            let what = format!("the same, percent of the buffer in {RANGES} ranges");
            targets.push(Target::at_most(what, 15.0, 100.0 * median(model.uploaded.clone()), 0));
        }
    }
    if let Some(built) = built {
        let of = |what: &str| format!("building sets, mts, lod-strips and blocks, {what}, {}", built.model);
        targets.push(Target::at_most(of("seconds"), 10.0, built.seconds, 0));
        targets.push(Target::at_most(of("bytes per triangle"), 400.0, built.bytes_per_triangle, 0));
    }
    targets
}

/// Returns a row per model and options.
pub(super) fn table(figures: &[MeasuredBlocks]) -> Table {
    let heads = [
        "model",
        "effort",
        "small uploads",
        "bytes per triangle",
        "keys",
        "vertices sent",
        "move ms",
        "worst ms",
        "upload %",
        "worst %",
        "step µs",
    ];
    let mut table = Table::new(1, &heads);
    for model in figures {
        let last = |values: &[f64]| values.last().copied().unwrap_or(0.0);
        table.push(vec![
            model.model.clone(),
            model.options.repair.effort.level().to_string(),
            if model.options.small_uploads { "yes" } else { "" }.into(),
            format!("{:.1}", model.memory as f64 / model.triangles.max(1) as f64),
            model.keys.to_string(),
            format!("{:.3}", model.sent),
            format!("{:.3}", median(model.milliseconds.clone())),
            format!("{:.3}", last(&model.milliseconds)),
            format!("{:.1}", 100.0 * median(model.uploaded.clone())),
            format!("{:.1}", 100.0 * last(&model.uploaded)),
            format!("{:.2}", model.step_microseconds),
        ]);
    }
    table
}
