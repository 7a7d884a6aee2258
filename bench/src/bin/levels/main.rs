//! Measures simplification, compared with meshoptimizer, and levels of detail: filters, vertex
//! splits, traffic, and repaired strips.
//!
//! ```sh
//! cargo run --profile dist -p tristrip-bench --bin levels -- --docs docs
//! ```
//!
//! All level-of-detail representations, over the strips of STRIPE, are compared with the oracle
//! before they are timed. Times are medians on one thread, in rounds that alternate with
//! meshoptimizer.
#![allow(clippy::print_stdout, reason = "a program that prints")]

mod blocks;
mod recovery;
mod simplification;

use std::fmt::Write as _;
use std::fs;
use std::hint::black_box;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::Parser;
use simplification::{
    ComparedSimplification, POINTS, SimplificationGoal, measure, simplification_table, summary,
};
use tristrip::Effort;
use tristrip::lod::Filter;
use tristrip::lod::{Encoding, ProgressiveStrips};
use tristrip::lod::{LevelCursor, Repair, RepairOptions};
use tristrip::simplify::{self, Price, simplify_triangles};
use tristrip::{CollapseSequence, Method, StripifyOptions, Strips, stripify};
use tristrip_bench::failure::Failure;
use tristrip_bench::levels;
use tristrip_bench::measure::median;
use tristrip_bench::memory::CountingAllocator;
use tristrip_bench::models::{ModelArgs, Source, load};
use tristrip_bench::targets::Target;
use tristrip_bench::text::{self, Table};
use tristrip_lab::traffic;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// The command that generates the page.
const COMMAND: &str = "cargo run --profile dist -p tristrip-bench --bin levels -- --docs docs";
/// The models with a quality target relative to meshoptimizer.
const QUALITY: [&str; 3] = ["bunny", "horse", "armadillo_43k"];
const QUALITY_TARGET: f64 = 0.95;
/// Models with defects, simplified to 1 in [`DIRTY_SHARE`] triangles, also with the permissive
/// options of both programs.
const DIRTY: [&str; 9] = [
    "chair_nonmanifold",
    "dragon_res3",
    "engine_2cylinder",
    "f16",
    "machine_scene",
    "many_small_holes",
    "milktruck",
    "power_lines",
    "step_11752",
];
const DIRTY_SHARE: usize = 5;
/// The models whose levels of detail are measured. Each has the published fractions of vertices
/// sent over all levels by NF, STSS and DTFS, and the index-map slots renamed per split, naive and
/// encoded.
const PUBLISHED: [(&str, [f64; 3], [f64; 2]); 2] =
    [("cow", [0.885, 0.731, 0.577], [6.6, 3.0]), ("bunny", [0.809, 0.691, 0.544], [5.9, 3.0])];

/// Measure simplification and levels of detail
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    #[command(flatten)]
    models: ModelArgs,
    /// The number of timed rounds
    #[arg(long, default_value_t = 9, value_name = "N", value_parser = clap::value_parser!(u8).range(1..))]
    rounds: u8,
    /// Simplify to 1 in N triangles; the page shows 1 in 20, and 1 in 5 for models with defects
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    share: u16,
    /// Allow both programs to change the topology
    #[arg(long)]
    permissive: bool,
    /// The cost of our collapses: distance or planes; the page shows both
    #[arg(long, default_value_t, value_name = "PRICE")]
    price: Price,
    /// Write levels.md to this directory
    #[arg(long, value_name = "DIR")]
    docs: Option<PathBuf>,
}

/// The metrics of a model at all levels, with the strips of one method.
struct MeasuredLevels {
    model: String,
    strips: &'static str,
    /// The vertices sent over all levels by each filter and by repaired strips, as fractions of
    /// three per triangle.
    fractions: Vec<f64>,
    /// The vertices sent at the base mesh, in the same order.
    base: Vec<f64>,
    /// The index-map slots renamed per split, naive and encoded.
    places: [f64; 2],
    /// The speeds of STSS and DTFS in indices per second.
    filter_speeds: [f64; 2],
    /// The speed in splits per second, naive and encoded.
    split_speeds: [f64; 2],
    /// The time to repair strips, in microseconds per collapse.
    repair_microseconds: f64,
}

fn main() -> Result<(), Failure> {
    let args = Args::parse();
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let sources = args.models.sources()?;
    let rounds = usize::from(args.rounds);
    let goal =
        SimplificationGoal { share: args.share.into(), permissive: args.permissive, price: args.price };

    let mut simplified = Vec::new();
    for source in &sources {
        let mesh = load(source)?.triangles;
        simplified.push(measure(&source.name, &mesh, &goal, rounds)?);
        if source.name == "dragon" {
            simplified.push(measure("dragon to 1 %", &mesh, &goal.with_share(100), rounds.min(3))?);
        }
    }
    let mut by_planes = Vec::new();
    for source in sources.iter().filter(|_| args.share == 20 && args.price == Price::Distance) {
        let goal = SimplificationGoal { price: Price::Planes, ..goal };
        by_planes.push(measure(&source.name, &load(source)?.triangles, &goal, rounds)?);
    }
    let mut dirty = Vec::new();
    for source in sources.iter().filter(|source| args.share == 20 && DIRTY.contains(&source.name.as_str())) {
        let mesh = load(source)?.triangles;
        let goal = goal.with_share(DIRTY_SHARE);
        dirty.push(measure(&source.name, &mesh, &goal, rounds.min(3))?);
        let permissive = SimplificationGoal { permissive: true, ..goal };
        dirty.push(measure(&format!("{}, permissive", source.name), &mesh, &permissive, rounds.min(3))?);
    }
    let mut all_levels = Vec::new();
    for source in sources
        .iter()
        .filter(|_| args.share == 20)
        .filter(|source| PUBLISHED.iter().any(|(name, ..)| *name == source.name))
    {
        for (name, method) in [("stripe", Method::STRIPE), ("best", Method::Best)] {
            all_levels.push(follow(source, name, method, rounds)?);
        }
    }
    let (mut recovered, mut of_blocks, mut built) = (Vec::new(), Vec::new(), None);
    if args.share == 20 {
        recovered = recovery::measure_all(&sources, rounds.min(3))?;
        of_blocks = blocks::measure_all(&sources)?;
        built = blocks::build_all(&sources)?;
    }
    let mut targets = compare(&simplified, &dirty, &all_levels);
    targets.extend(recovery::compare(&recovered));
    targets.extend(blocks::compare(&of_blocks, built.as_ref()));
    let (table, of_levels) = (simplification_table(&simplified), levels_table(&all_levels));
    let (of_dirty, of_planes) = (simplification_table(&dirty), simplification_table(&by_planes));
    let (of_recovery, of_blocks) = (recovery::table(&recovered), blocks::table(&of_blocks));
    let tables = [&table, &of_planes, &of_dirty, &of_levels, &of_recovery, &of_blocks].map(Table::aligned);
    println!("{}", tables.join("\n"));
    for (price, figures) in [(args.price, &simplified), (Price::Planes, &by_planes)] {
        println!("{}", summary(price, figures));
    }
    println!("{}", text::targets(&targets).aligned());
    if let Some(docs) = &args.docs {
        fs::create_dir_all(docs)?;
        let mut page = format!(
            "# Simplification and levels of detail\n\n\
             Generated by `{COMMAND}`; change the program, not this page. Times are medians on one thread, in rounds that\n\
             alternate with meshoptimizer; over STRIPE's strips every representation drew what the oracle draws, at 201 levels, before it was timed.\n\n## Targets\n\n{}\n",
            text::targets(&targets).markdown()
        );
        write!(
            page,
            "## Simplification to 5 % of the triangles\n\n\
             `tristrip simplify` compared with meshoptimizer's `simplify`, both by half-edge collapses, ours with all collapses recorded. RMS is the\n\
             two-sided distance from the full mesh in percent of its diagonal, by {POINTS} points in each direction; largest is the largest of these, and of\n\
             the distances of up to {POINTS} removed vertices. Bytes are the peak in use beyond\n\
             input and result. Both stop where meshoptimizer stops.\n\n{}\n\n{}\n",
            summary(Price::Distance, &simplified),
            table.markdown()
        )?;
        write!(
            page,
            "## The same by planes alone\n\n\
             `tristrip simplify --price planes`: faster, with larger distances.\n\n{}\n\n{}\n",
            summary(Price::Planes, &by_planes),
            of_planes.markdown()
        )?;
        write!(
            page,
            "## Models that are no clean surfaces, to 20 %\n\n\
             Edges of three and more triangles, doubled faces, holes, many parts, clutter; also with the permissive options of both, which\n\
             let the topology change.\n\n{}\n",
            of_dirty.markdown()
        )?;
        write!(
            page,
            "## Levels of detail\n\n\
             Progressive strips (Kim et al. 2005), base mesh of 5 %: vertices sent over all levels, each drawn once, as a fraction of three per\n\
             triangle, and in brackets at the base mesh; *linked* and *repair* are ours. u is the number of slots renamed per vertex split.\n\
             Speeds are in million indices or vertex splits per second.\n\n{}\n",
            of_levels.markdown()
        )?;
        write!(
            page,
            "## Recovery of levels\n\n\
             The tests of Belmonte et al. 2006 on every level model, over STRIPE's strips and all levels: a share of all levels is recovered, from the\n\
             full mesh down to the base mesh and up again, at equal distances or at distances that grow from the full mesh on. Microseconds per move,\n\
             without drawing, which the published times contain; bytes per triangle of the model, and of a cursor that has drawn the full mesh. The\n\
             dragon of 165,963 triangles stands in for the paper's Phone. Times are medians of three rounds, or of one that takes longer than a second.\n\n{}\n",
            of_recovery.markdown()
        )?;
        write!(
            page,
            "## Blocks\n\n\
             The model `blocks`, of which a level is an index buffer that moves patch in place, over strips of `best` and all levels: vertices sent\n\
             over all levels, each drawn once, as a fraction of three per triangle; 99 moves of one percent of the levels from the full mesh down, in\n\
             milliseconds, and the share of the buffer that each uploads in at most 256 ranges, medians and worst; a step by one level. A second row\n\
             has more memory, and more search or strips cut for small uploads. A move to the levels of another key replaces the whole buffer.\n\n{}",
            of_blocks.markdown()
        )?;
        fs::write(docs.join("levels.md"), page)?;
    }
    Ok(())
}

/// Measures all levels of a model, down to 5 % of its triangles.
fn follow(
    source: &Source,
    name: &'static str,
    method: Method,
    rounds: usize,
) -> Result<MeasuredLevels, Failure> {
    let fed = load(source)?;
    let mesh = fed.polygons.unwrap_or(fed.triangles);
    let problems = levels::check(&mesh, false)?.problems;
    if let Some(problem) = problems.first() {
        return Err(format!("{}: {problem}", source.name).into());
    }
    let strips = stripify(&mesh, &StripifyOptions::default().with_method(method))?;
    let list = strips.to_list();
    let options = simplify::SimplifyOptions::default().with_triangles(list.len() / 60);
    let sequence = simplify_triangles(&mesh, list, &options)?.sequence;
    let mut base = Vec::new();
    let totals = traffic::walk(&strips, &sequence, |level| {
        if level.level == 0 {
            base = Filter::ALL.map(|filter| level.sent(filter).vertices as f64).to_vec();
        }
    })?;
    let mut fractions: Vec<f64> = Filter::ALL.iter().map(|&filter| totals.fraction(filter)).collect();

    let sequence = Arc::new(sequence);
    let start = Instant::now();
    let options = RepairOptions::default().with_effort(Effort::default());
    let mut repair = Repair::new(Arc::clone(&sequence), &strips, options)?;
    let mut sent = repair.vertices_sent() as u64;
    while repair.coarsen() {
        sent += repair.vertices_sent() as u64;
    }
    let repair_microseconds = start.elapsed().as_secs_f64() * 1e6 / sequence.len().max(1) as f64;
    fractions.push(sent as f64 / totals.progressive_mesh_vertices() as f64);
    base.push(repair.vertices_sent() as f64);
    let base_triangles = sequence.triangle_count(0)? as f64;
    let splits = totals.splits();
    Ok(MeasuredLevels {
        model: source.name.clone(),
        strips: name,
        fractions,
        base: base.into_iter().map(|vertices| vertices / (3.0 * base_triangles)).collect(),
        places: [Encoding::Naive, Encoding::Offsets].map(|encoding| splits.slots_per_split(encoding)),
        filter_speeds: filter_speeds(&strips, &sequence, rounds)?,
        split_speeds: split_speeds(&strips, &sequence, rounds)?,
        repair_microseconds,
    })
}

/// Times STSS and DTFS, alternating, over index maps of 21 levels.
fn filter_speeds(strips: &Strips, sequence: &CollapseSequence, rounds: usize) -> Result<[f64; 2], Failure> {
    let mut cursor = Arc::new(ProgressiveStrips::new(strips, sequence, Encoding::Naive)?).cursor();
    let map_at = |step: usize| {
        let mut map = Vec::new();
        cursor.set_level(sequence.len() * step / 20)?;
        cursor.decode_to(&mut map);
        Ok(map)
    };
    let maps = (0..=20).map(map_at).collect::<Result<Vec<Vec<u32>>, tristrip::Error>>()?;
    let entries: usize = maps.iter().map(Vec::len).sum();
    let (mut times, mut display) = ([Vec::new(), Vec::new()], Strips::default());
    for _ in 0..3 * rounds {
        for (filter, times) in [Filter::Stss, Filter::Dtfs].into_iter().zip(&mut times) {
            let start = Instant::now();
            for map in &maps {
                display.clear();
                filter.map_to(black_box(map), &mut display);
            }
            times.push(start.elapsed().as_secs_f64());
        }
    }
    Ok(times.map(|times| entries as f64 / median(times)))
}

/// Times the vertex splits from the base mesh to the full mesh.
fn split_speeds(strips: &Strips, sequence: &CollapseSequence, rounds: usize) -> Result<[f64; 2], Failure> {
    let mut speeds = [0.0; 2];
    for (encoding, speed) in [Encoding::Naive, Encoding::Offsets].into_iter().zip(&mut speeds) {
        let mut cursor = Arc::new(ProgressiveStrips::new(strips, sequence, encoding)?).cursor();
        let mut times = Vec::new();
        for _ in 0..rounds {
            cursor.set_level(0)?;
            let start = Instant::now();
            while cursor.refine() {}
            times.push(start.elapsed().as_secs_f64());
        }
        *speed = sequence.len() as f64 / median(times);
    }
    Ok(speeds)
}

fn compare(
    simplified: &[ComparedSimplification],
    dirty: &[ComparedSimplification],
    all_levels: &[MeasuredLevels],
) -> Vec<Target> {
    let mut targets = Vec::new();
    let named = |name: &str| simplified.iter().find(|s| s.model == name);
    for model in QUALITY.iter().filter_map(|name| named(name)).filter(|model| model.is_alike()) {
        let what = format!("RMS distance at 5 % relative to meshoptimizer, {}", model.model);
        targets.push(Target::at_most(what, QUALITY_TARGET, model.rms[0] / model.rms[1], 2));
    }
    for model in dirty.iter().filter(|model| model.rms[1] > 0.0) {
        let what = format!("RMS distance at 20 % relative to meshoptimizer, {}", model.model);
        targets.push(Target::at_most(what, 1.0, model.rms[0] / model.rms[1], 2));
    }
    if let Some(bunny) = named("bunny") {
        targets.push(Target::at_most(
            "simplification to 5 %, ms, bunny".into(),
            80.0,
            1e3 * bunny.times[0],
            0,
        ));
    }
    if let Some(dragon) = named("dragon to 1 %") {
        targets.push(Target::at_most(
            "simplification to 1 %, seconds, dragon".into(),
            3.0,
            dragon.times[0],
            1,
        ));
        let what = "simplification to 1 %, bytes per triangle, dragon".into();
        targets.push(Target::at_most(what, 400.0, dragon.bytes_per_triangle, 0));
    }
    for level in all_levels {
        let Some((_, fractions, places)) = PUBLISHED.iter().find(|(name, ..)| *name == level.model) else {
            continue;
        };
        let of = |what: &str| format!("{what}, {} strips of {}", level.strips, level.model);
        let near = |what: &str, published: f64, found: f64, within: f64| Target {
            what: of(what),
            target: format!("{published} ± {within:.2}"),
            found: format!("{found:.3}"),
            met: (found - published).abs() <= within,
        };
        if level.strips == "stripe" {
            for (k, name) in ["unfiltered", "STSS", "DTFS"].iter().enumerate() {
                targets.push(near(
                    &format!("{name} over all levels"),
                    fractions[k],
                    level.fractions[k],
                    0.05,
                ));
            }
            for (k, name) in ["naive", "encoded"].iter().enumerate() {
                targets.push(near(&format!("u, {name}"), places[k], level.places[k], 0.1 * places[k]));
            }
        } else {
            targets.push(Target::at_most(of("DTFS over all levels"), 0.50, level.fractions[2], 2));
            targets.push(Target::at_most(of("repair over all levels"), 0.45, level.fractions[4], 2));
        }
        if level.model == "bunny" {
            targets.push(Target::at_most(of("DTFS at the base mesh"), 1.02, level.base[2], 2));
            targets.push(Target::at_most(of("repair at the base mesh"), 0.60, level.base[4], 2));
        }
        let [stss, dtfs] = level.filter_speeds;
        targets.push(Target::at_most(of("time of DTFS relative to STSS"), 1.0, stss / dtfs, 2));
        targets.push(Target::at_least(of("DTFS, million indices per second"), 200.0, dtfs / 1e6, 0));
        let slower = level.split_speeds[0].min(level.split_speeds[1]);
        targets.push(Target::at_least(of("million vertex splits per second"), 5.0, slower / 1e6, 1));
    }
    targets
}

fn levels_table(all_levels: &[MeasuredLevels]) -> Table {
    let heads = [
        "model",
        "strips",
        "none",
        "STSS",
        "DTFS",
        "linked",
        "repair",
        "u naive",
        "u encoded",
        "STSS M/s",
        "DTFS M/s",
        "splits naive M/s",
        "splits encoded M/s",
        "repair µs",
    ];
    let mut table = Table::new(2, &heads);
    for level in all_levels {
        let mut cells = vec![level.model.clone(), level.strips.to_owned()];
        cells.extend(
            level.fractions.iter().zip(&level.base).map(|(all, base)| format!("{all:.3} ({base:.3})")),
        );
        cells.extend(level.places.iter().map(|places| format!("{places:.2}")));
        cells.extend(level.filter_speeds.iter().map(|speed| format!("{:.0}", speed / 1e6)));
        cells.extend(level.split_speeds.iter().map(|speed| format!("{:.1}", speed / 1e6)));
        cells.push(format!("{:.1}", level.repair_microseconds));
        table.push(cells);
    }
    table
}
