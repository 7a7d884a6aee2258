//! The tests of paper 002: the memory of every level model, and the time to recover a fraction of
//! all levels.

use tristrip::lod::ModelKind;
use tristrip::{Method, StripifyOptions};
use tristrip_bench::failure::Failure;
use tristrip_bench::models::Source;
use tristrip_bench::targets::Target;
use tristrip_bench::text::Table;
use tristrip_io::{Model, read_path};
use tristrip_lab::baselines::ComparedModel;
use tristrip_lab::recovery::{ModelRecovery, SHARES, Sweep, measure};
use tristrip_pipeline::{Amount, Deviation, Goal, Ratio, levels, simplify};

/// The model of the paper.
const SETS: ComparedModel = ComparedModel::Library(ModelKind::Sets);

/// The values that table 2 of the paper prints for a model: strips, and megabytes of SETS and of
/// MTS.
const PUBLISHED: [(&str, usize, [f64; 2]); 2] =
    [("cow_2904", 136, [0.338, 0.253]), ("bunny", 1229, [4.150, 2.964])];
/// Additional models. The first replaces the model Phone, which is not available; it has the same
/// number of triangles.
const LARGE: [(&str, Option<usize>); 2] = [("dragon", Some(165_963)), ("dragon", None)];
/// The published megabytes have 2²⁰ bytes.
const MEGABYTE: f64 = 1_048_576.0;

/// The measurements of a model.
pub(super) struct MeasuredRecovery {
    model: String,
    triangles: usize,
    strips: usize,
    models: Vec<ModelRecovery>,
}

/// Measures the models of the paper that are in the model directory.
pub(super) fn measure_all(sources: &[Source], rounds: usize) -> Result<Vec<MeasuredRecovery>, Failure> {
    let mut figures = Vec::new();
    let named = |name: &str| sources.iter().find(|source| source.name == name);
    for source in PUBLISHED.iter().filter_map(|(name, ..)| named(name)) {
        figures.push(of_model(&source.name, &read_path(&source.path)?, rounds)?);
    }
    for (source, triangles) in LARGE.iter().filter_map(|(name, triangles)| Some((named(name)?, triangles))) {
        let model = read_path(&source.path)?;
        let Some(triangles) = *triangles else {
            figures.push(of_model(&source.name, &model, rounds)?);
            continue;
        };
        let goal = Goal { amount: Some(Amount::Triangles(triangles)), deviation: Deviation::default() };
        let simplified =
            simplify::run(&model, &simplify::Options::default().with_goal(goal), &())?.redrawn.model;
        figures.push(of_model(&format!("{} of {triangles} triangles", source.name), &simplified, rounds)?);
    }
    Ok(figures)
}

fn of_model(name: &str, model: &Model, rounds: usize) -> Result<MeasuredRecovery, Failure> {
    let stripify = StripifyOptions::default().with_method(Method::STRIPE);
    let levels =
        levels::run(model, &levels::Options::default().with_stripify(stripify).with_base(Ratio::ZERO), &())?
            .model;
    Ok(MeasuredRecovery {
        model: name.into(),
        triangles: levels.triangle_count(levels.collapse_count())?,
        strips: levels.parts.iter().map(|part| part.strips().len()).sum(),
        models: measure(&levels, &Sweep::ALL, rounds)?,
    })
}

impl MeasuredRecovery {
    fn of(&self, kind: ComparedModel) -> Option<&ModelRecovery> {
        self.models.iter().find(|model| model.model == kind.name())
    }

    /// Returns the time of SETS relative to MTS.
    fn ratio(&self, sweep: Sweep, share: usize) -> Option<f64> {
        let time = |kind| {
            let tests = &self.of(kind)?.tests;
            tests.iter().find(|test| test.sweep == sweep && test.share == share).map(|test| test.microseconds)
        };
        Some(time(SETS)? / time(ComparedModel::Mts)?)
    }
}

/// Compares with the printed values of the paper.
pub(super) fn compare(figures: &[MeasuredRecovery]) -> Vec<Target> {
    let mut targets = Vec::new();
    for (name, strips, megabytes) in PUBLISHED {
        let Some(figures) = figures.iter().find(|figures| figures.model == name) else { continue };
        let of = |what: &str| format!("{what}, stripe strips of {name}");
        let within = 0.1 * strips as f64;
        targets.push(Target {
            what: of("strips"),
            target: format!("{strips} ± {within:.0}"),
            found: figures.strips.to_string(),
            met: (figures.strips as f64 - strips as f64).abs() <= within,
        });
        let kinds = [SETS, ComparedModel::Mts];
        let [Some(sets), Some(mts)] = kinds.map(|kind| figures.of(kind)) else { continue };
        let ratio = sets.memory as f64 / mts.memory as f64;
        targets.push(Target::at_most(of("memory of sets relative to mts"), 1.4, ratio, 2));
        for (model, published) in [sets, mts].into_iter().zip(megabytes) {
            let found = model.memory as f64 / MEGABYTE / published;
            let what = format!("memory of {} relative to that published, {name}", model.model);
            targets.push(Target::at_most(what, 0.5, found, 2));
        }
        for sweep in Sweep::ALL {
            // The published times include drawing, which takes the same time for both.
            if let Some(ratio) = figures.ratio(sweep, 20).filter(|_| name == "bunny") {
                let what = format!("time of sets relative to mts, 20 % of levels, {sweep}, {name}");
                targets.push(Target::at_most(what, 0.68, ratio, 2));
            }
        }
    }
    targets.extend(figures.iter().flat_map(|of| super::blocks::compare_recovery(&of.model, &of.models)));
    targets
}

/// Returns a row per level model and sweep of each model.
pub(super) fn table(figures: &[MeasuredRecovery]) -> Table {
    let heads = [
        "model",
        "levels",
        "sweep",
        "triangles",
        "strips",
        "bytes per triangle",
        "cursor",
        "build s",
        "1 %",
        "3 %",
        "6 %",
        "10 %",
        "15 %",
        "20 %",
    ];
    let mut table = Table::new(3, &heads);
    for of in figures {
        for model in &of.models {
            for tests in model.tests.chunks(SHARES.len()) {
                let per_triangle = |bytes: usize| format!("{:.1}", bytes as f64 / of.triangles.max(1) as f64);
                let sweep = tests.first().map_or("", |test| test.sweep.name());
                let mut cells = vec![of.model.clone(), model.model.clone(), sweep.into()];
                cells.extend([of.triangles, of.strips].map(|count| count.to_string()));
                cells.extend([model.memory, model.cursor_memory].map(per_triangle));
                cells.push(format!("{:.3}", model.build_seconds));
                cells.extend(tests.iter().map(|test| format!("{:.2}", test.microseconds)));
                table.push(cells);
            }
        }
    }
    table
}
