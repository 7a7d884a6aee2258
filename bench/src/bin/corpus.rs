//! Checks a directory of real models with every method. Each result is proven by `verify`, and
//! gives the same bytes with 1, 2 and 7 threads. It is also written to files that an independent
//! checker proves again (`tools/corpus/check_files.py`). For models of more than 8,000 triangles,
//! variants of methods run with 1 and one other number of threads.
//!
//! ```sh
//! cargo build --profile dist -p tristrip-bench
//! target/dist/corpus ../shared/models --checker ../shared/check_strips.py
//! ```
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program that prints")]

use std::borrow::Borrow;
use std::cmp::Reverse;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use clap::Parser;
use tristrip_bench::corpus::{CheckOptions, CheckedModel, THREADS, ThreadPools, check};
use tristrip_bench::failure::Failure;
use tristrip_bench::models::{self, Source};

/// The number of models that are checked concurrently.
const WORKERS: usize = 2;

/// Prove every method on real models, and the files written from the results
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// The directory of models [default: ../shared/models next to the checkout, else
    /// testdata/models]
    models: Option<PathBuf>,
    /// The file checker, a Python program that needs numpy; without it, files are not proven
    #[arg(long, value_name = "FILE")]
    checker: Option<PathBuf>,
    /// Write a file for every method, also for large models; the checker then takes about ten
    /// minutes
    #[arg(long)]
    all_files: bool,
    /// Write a hash of every index buffer, file and level of detail, one per line, for comparing
    /// two versions of the program
    #[arg(long, value_name = "FILE")]
    hashes: Option<PathBuf>,
    /// The Python interpreter for the checker
    #[arg(long, default_value = "python3", value_name = "PROGRAM")]
    python: PathBuf,
    /// Check only this model; repeatable
    #[arg(long, value_name = "NAME")]
    model: Vec<String>,
    /// Check only every Nth model by file size, starting at the Ith largest, counted from 0
    #[arg(long, value_name = "I/N", value_parser = part)]
    part: Option<(usize, usize)>,
}

fn part(text: &str) -> Result<(usize, usize), String> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    numbers.filter(|&(i, n)| i < n).ok_or_else(|| "expected I/N with I less than N".to_owned())
}

fn main() -> Result<ExitCode, Failure> {
    let args = Args::parse();
    let folder = args.models.clone().unwrap_or_else(models::default_folder);
    let mut sources = models::find(&folder)?;
    sources.retain(|source| args.model.is_empty() || args.model.contains(&source.name));
    if let Some((first, every)) = args.part {
        largest_first(&mut sources);
        sources = sources.into_iter().skip(first).step_by(every).collect();
    }
    let program = std::env::current_exe()?;
    let built = program.parent().ok_or("the program has no folder")?;
    let files = built.join("corpus-files");
    fs::create_dir_all(&files)?;

    let start = Instant::now();
    let results = check_all(
        &sources,
        &files,
        CheckOptions { all_files: args.all_files, hashes: args.hashes.is_some() },
    )?;
    let sum =
        |count: fn(&CheckedModel) -> usize| results.iter().map(|(_, checked)| count(checked)).sum::<usize>();
    let mut problems: Vec<String> =
        results.iter().flat_map(|(_, checked)| checked.problems.clone()).collect();
    println!(
        "corpus: {} models: {} results proven by verify, {} of them with the same bytes for {THREADS:?} threads, \
         all representations of levels of detail draw the oracle's triangles at {} levels ({:.0} s)",
        sources.len(),
        sum(|c| c.proven),
        sum(|c| c.identical),
        sum(|c| c.levels),
        start.elapsed().as_secs_f64()
    );
    if let Some(path) = &args.hashes {
        let lines = results.iter().flat_map(|(_, checked)| &checked.hashes);
        fs::write(path, lines.fold(String::new(), |text, line| text + line + "\n"))?;
    }
    let start = Instant::now();
    let command = built.join(format!("tristrip{}", std::env::consts::EXE_SUFFIX));
    if command.is_file() {
        let same = threads_of_command(&command, &sources, &files, &mut problems)?;
        println!(
            "corpus: the command: {same} of {} models with the same bytes for {THREADS:?} threads ({:.0} s)",
            sources.len(),
            start.elapsed().as_secs_f64()
        );
    } else {
        problems.push("the command is not built: cargo build --release -p tristrip-cli".into());
    }
    let start = Instant::now();
    let file_count = sum(|c| c.files.len());
    match &args.checker {
        Some(checker) if !prove_files(&args.python, checker, &results, &files)? => {
            problems.push("the checker does not prove every file".into());
        }
        Some(_) => println!(
            "corpus: {file_count} files proven by the checker ({:.0} s)",
            start.elapsed().as_secs_f64()
        ),
        None => println!("corpus: {file_count} files written, not proven: no --checker is given"),
    }
    fs::remove_dir_all(&files)?;
    problems.iter().for_each(|problem| eprintln!("corpus: PROBLEM: {problem}"));
    println!("corpus: {} problems", problems.len());
    Ok(if problems.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn largest_first<S: Borrow<Source>>(sources: &mut [S]) {
    sources.sort_by_key(|source| Reverse(fs::metadata(&source.borrow().path).map_or(0, |m| m.len())));
}

/// Checks the models in parallel, the largest files first. The results are sorted by name.
fn check_all<'a>(
    sources: &'a [Source],
    files: &Path,
    extra: CheckOptions,
) -> Result<Vec<(&'a Source, CheckedModel)>, Failure> {
    let pools = ThreadPools::new()?;
    let mut order: Vec<&Source> = sources.iter().collect();
    largest_first(&mut order);
    let (next, results) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..WORKERS {
            scope.spawn(|| {
                while let Some(&source) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let checked = check(source, &pools, files, extra).unwrap_or_else(|error| CheckedModel {
                        problems: vec![error.to_string()],
                        ..CheckedModel::default()
                    });
                    if let Ok(mut results) = results.lock() {
                        results.push((source, checked));
                    }
                }
            });
        }
    });
    let mut results = results.into_inner().map_err(|_| "a worker thread panicked")?;
    results.sort_by(|a, b| a.0.name.cmp(&b.0.name));
    Ok(results)
}

/// Runs the command on every model with each number of threads. Returns the number of models whose
/// files are all equal.
fn threads_of_command(
    command: &Path,
    sources: &[Source],
    files: &Path,
    problems: &mut Vec<String>,
) -> Result<usize, Failure> {
    let mut same = 0;
    for source in sources {
        let mut first: Option<Vec<u8>> = None;
        let mut is_same = true;
        for threads in THREADS {
            let out = files.join("threads.glb");
            let run = Command::new(command)
                .args(["strip", "--quiet", "--threads", &threads.to_string(), "-o"])
                .arg(&out)
                .arg(&source.path)
                .output()?;
            if !run.status.success() {
                problems.push(format!(
                    "{}: the command: {}",
                    source.name,
                    String::from_utf8_lossy(&run.stderr).trim()
                ));
                is_same = false;
                break;
            }
            let bytes = fs::read(&out)?;
            if first.get_or_insert_with(|| bytes.clone()) != &bytes {
                problems.push(format!(
                    "{}: the command writes different bytes with {threads} threads",
                    source.name
                ));
                is_same = false;
            }
        }
        same += usize::from(is_same);
    }
    Ok(same)
}

/// Runs the checker on all files. Returns whether it proved all of them.
fn prove_files(
    python: &Path,
    checker: &Path,
    results: &[(&Source, CheckedModel)],
    files: &Path,
) -> Result<bool, Failure> {
    let mut list = String::new();
    for (source, checked) in results {
        for file in &checked.files {
            writeln!(list, "{}\t{}", source.path.display(), file.display())?;
        }
    }
    let list_path = files.join("files.tsv");
    fs::write(&list_path, list)?;
    let driver = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tools/corpus/check_files.py");
    let status = Command::new(python).arg(driver).arg(checker).arg(&list_path).status();
    Ok(status.map_err(|error| format!("{}: {error}", python.display()))?.success())
}
