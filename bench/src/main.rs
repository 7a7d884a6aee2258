//! Runs the benchmarks: every method and meshoptimizer on every model of a directory, in the same
//! run. Each result is proven before its time is printed.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program that prints")]

use std::fs;
use std::path::PathBuf;

use clap::Parser;
use serde::Serialize;
use tristrip_bench::failure::Failure;
use tristrip_bench::measure::{MeasurePlan, Outcome, measure};
use tristrip_bench::memory::CountingAllocator;
use tristrip_bench::methods::{all_methods, main_methods};
use tristrip_bench::models::{self, Source};
use tristrip_bench::scaling::{Scaling, scale};
use tristrip_bench::searches::{self, SearchEffort, SearchResults};
use tristrip_bench::targets::{self, Target};
use tristrip_bench::vertex_caches::{self, CacheResults};
use tristrip_bench::{docs, peers, text};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// The models of a smoke run.
const SMOKE: [&str; 5] = ["catmark_bishop", "fish_control", "wingnut", "milktruck", "hand"];
/// The model that is subdivided: a scan with a free licence.
const SCALED: &str = "hand";

/// Measure every method on real models, and meshoptimizer in the same run
#[derive(Debug, Parser)]
#[command(version)]
#[expect(clippy::struct_excessive_bools, reason = "flags of a command line")]
struct Args {
    /// The directory of models [default: ../shared/models next to the checkout, else
    /// testdata/models]
    models: Option<PathBuf>,
    /// Measure only this model; repeatable
    #[arg(long, value_name = "NAME")]
    model: Vec<String>,
    /// Run every variant of every method, instead of one per family
    #[arg(long)]
    all: bool,
    /// The number of timed rounds
    #[arg(long, default_value_t = 9, value_name = "N", value_parser = clap::value_parser!(u8).range(1..))]
    rounds: u8,
    /// Run a few small models for one round, as a smoke test
    #[arg(long)]
    smoke: bool,
    /// Skip the subdivided model of millions of triangles
    #[arg(long)]
    no_scaling: bool,
    /// Skip the long searches on every model: fewest strips, cheapest indices, and indices with
    /// vertex-cache misses
    #[arg(long)]
    no_searches: bool,
    /// Print all results as JSON
    #[arg(long)]
    json: bool,
    /// Write benchmarks.md to this directory
    #[arg(long, value_name = "DIR")]
    docs: Option<PathBuf>,
}

/// All measurements.
#[derive(Serialize)]
struct Report {
    models: Vec<Outcome>,
    searches: Vec<SearchResults>,
    vertex_caches: Vec<CacheResults>,
    scaling: Option<Scaling>,
    targets: Vec<Target>,
}

fn main() -> Result<(), Failure> {
    let args = Args::parse();
    // Times are for one thread.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let peers = peers::load()?;
    let sources = choose(&args)?;
    let plan = MeasurePlan {
        methods: if args.all { all_methods() } else { main_methods() },
        rounds: if args.smoke { 1 } else { usize::from(args.rounds) },
    };
    let mut outcomes = Vec::new();
    for source in &sources {
        for outcome in measure(source, &plan, peers.get(&source.name))? {
            if !args.json {
                println!("{}", text::outcome(&outcome));
            }
            outcomes.push(outcome);
        }
    }
    let depth = if args.smoke { SearchEffort::SMOKE } else { SearchEffort::FULL };
    let papers = searches::published()?;
    let (mut searched, mut caches) = (Vec::new(), Vec::new());
    for source in sources.iter().filter(|_| !args.no_searches) {
        let name = &source.name;
        let found = searches::search(source, depth, peers.get(name), papers.get(name))?;
        if !args.json {
            println!("{}", text::searched(&found));
        }
        searched.push(found);
        let found = vertex_caches::search(source)?;
        if !args.json {
            println!("{}", text::caches(&found));
        }
        caches.push(found);
    }
    let scaled = sources.iter().find(|s| s.name == SCALED && !args.smoke && !args.no_scaling);
    let scaling = match scaled {
        Some(source) => Some(scale(SCALED, models::load(source)?.triangles, 3)?),
        None => None,
    };
    let targets = targets::compare(&outcomes, &searched, &caches, scaling.as_ref());
    if let Some(dir) = &args.docs {
        fs::create_dir_all(dir)?;
        let page = docs::page(&outcomes, (&searched, depth), &caches, scaling.as_ref(), &targets);
        fs::write(dir.join("benchmarks.md"), page)?;
    }
    if args.json {
        let report = Report { models: outcomes, searches: searched, vertex_caches: caches, scaling, targets };
        println!("{}", serde_json::to_string_pretty(&report)?);
        return Ok(());
    }
    if let Some(scaling) = &scaling {
        println!("{SCALED}, subdivided\n{}", text::scaling(scaling).aligned());
    }
    println!("{}", text::targets(&targets).aligned());
    println!(
        "{} models, {} rows, all proven",
        sources.len(),
        outcomes.iter().map(|o| o.rows.len()).sum::<usize>()
    );
    Ok(())
}

/// Returns the models to measure.
fn choose(args: &Args) -> Result<Vec<Source>, Failure> {
    let folder = args.models.clone().unwrap_or_else(models::default_folder);
    let mut sources = models::find(&folder)?;
    if let Some(unknown) = args.model.iter().find(|name| sources.iter().all(|s| s.name != **name)) {
        return Err(format!("{}: found no model `{unknown}`", folder.display()).into());
    }
    if !args.model.is_empty() {
        sources.retain(|source| args.model.contains(&source.name));
    } else if args.smoke {
        sources.retain(|source| SMOKE.contains(&source.name.as_str()));
    }
    Ok(sources)
}
