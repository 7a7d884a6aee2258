//! Measures every default method, and levels of detail, on hostile shapes at two sizes: time per
//! triangle, and growth.
//!
//! ```sh
//! cargo run --profile dist -p tristrip-bench --bin hostile -- --triangles 1000000
//! ```
//!
//! Every run is a separate process with a time limit. Its result is proven before its time is
//! printed. A run *violates* its limit in two cases: it takes longer than a second plus the
//! method's time per triangle, or more than five times as long as a run on a quarter of the
//! triangles.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program that prints")]

use std::io::Read as _;
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use clap::Parser;
use serde_json::{Value, json};
use tristrip_bench::failure::Failure;
use tristrip_bench::hostile::{HostileMethod, HostileShape, METHODS, shapes};
use tristrip_bench::text::Table;

/// The ratio between the two sizes, and the maximum ratio between their times.
const SIZES: u32 = 4;
const MAX_GROWTH: f64 = 5.0;
/// The minimum time for which growth is compared, in seconds.
const SHORT: f64 = 0.25;

/// Measure every default method on hostile shapes
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// The number of triangles of the larger size
    #[arg(long, default_value_t = 1_000_000, value_name = "N")]
    triangles: u32,
    /// Measure only shapes whose names contain this text; repeatable
    #[arg(long, value_name = "TEXT")]
    shape: Vec<String>,
    /// Measure only this method; repeatable
    #[arg(long, value_name = "NAME")]
    method: Vec<String>,
    /// The time limit of a run in seconds
    #[arg(long, default_value_t = 30, value_name = "SECONDS")]
    limit: u64,
    /// Print only violations
    #[arg(long)]
    violations: bool,
    /// Run one shape with one method in this process, and print its metrics as JSON
    #[arg(long, num_args = 2, value_names = ["SHAPE", "METHOD"], conflicts_with_all = ["shape", "method"])]
    one: Option<Vec<String>>,
}

/// The metrics of a run; `None` if it exceeded the time limit.
#[derive(Debug, Clone, Copy)]
struct Measured {
    triangles: f64,
    seconds: f64,
    proof_seconds: f64,
    strips: u64,
}

fn main() -> Result<ExitCode, Failure> {
    let args = Args::parse();
    if let Some([shape, method]) = args.one.as_deref() {
        return one(shape, method, args.triangles);
    }
    let chosen = |shape: &HostileShape| {
        args.shape.is_empty() || args.shape.iter().any(|text| shape.name.contains(text.as_str()))
    };
    let mut table = Table::new(
        2,
        &["shape", "method", "triangles", "strips", "s", "µs/triangle", "growth", "proof s", "result"],
    );
    let (mut runs, mut violations) = (0, 0);
    for shape in shapes().iter().filter(|shape| chosen(shape)) {
        for method in METHODS {
            if !args.method.is_empty() && !args.method.iter().any(|name| name == method.name) {
                continue;
            }
            let small = run(shape.name, method.name, args.triangles / SIZES, args.limit)?;
            let large = run(shape.name, method.name, args.triangles, args.limit)?;
            let violation = violation(&method, small, large);
            runs += 1;
            violations += usize::from(violation.is_some());
            if violation.is_some() || !args.violations {
                table.push(row(shape.name, &method, small, large, violation, args.limit));
                eprintln!("{}", table_line(shape.name, &method, small, large, violation));
            }
        }
    }
    print!("{}", table.aligned());
    println!("hostile: {violations} of {runs} runs violate their limit");
    Ok(if violations == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Runs a shape in this process.
fn one(shape: &str, method: &str, triangles: u32) -> Result<ExitCode, Failure> {
    let all = shapes();
    let shape = all.iter().find(|each| each.name == shape).ok_or("there is no such shape")?;
    let method = HostileMethod::of_name(method).ok_or("there is no such method")?;
    let run = method.run(&shape.mesh(triangles)?)?;
    let (seconds, proof) = (run.seconds, run.proof_seconds);
    println!(
        "{}",
        json!({"triangles": run.triangles, "seconds": seconds, "proof": proof, "strips": run.strips})
    );
    Ok(ExitCode::SUCCESS)
}

/// Runs a shape in a separate process. Returns `None` if it takes too long.
fn run(shape: &str, method: &str, triangles: u32, limit: u64) -> Result<Option<Measured>, Failure> {
    let mut child = Command::new(std::env::current_exe()?)
        .args(["--triangles", &triangles.to_string(), "--one", shape, method])
        .stdout(Stdio::piped())
        .spawn()?;
    if !ends_within(&mut child, Duration::from_secs(limit))? {
        child.kill()?;
        child.wait()?;
        return Ok(None);
    }
    let mut text = String::new();
    child.stdout.take().ok_or("no output")?.read_to_string(&mut text)?;
    if !child.wait()?.success() {
        return Err(format!("{shape}, {method}: not proven").into());
    }
    let figures: Value = serde_json::from_str(&text)?;
    let number = |key: &str| figures[key].as_f64().ok_or_else(|| format!("no {key}"));
    Ok(Some(Measured {
        triangles: number("triangles")?,
        seconds: number("seconds")?,
        proof_seconds: number("proof")?,
        strips: figures["strips"].as_u64().ok_or("no strips")?,
    }))
}

fn ends_within(child: &mut Child, limit: Duration) -> Result<bool, Failure> {
    let start = Instant::now();
    while child.try_wait()?.is_none() {
        if start.elapsed() > limit {
            return Ok(false);
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(true)
}

/// Returns how a run violates its limit; `None` if it does not.
fn violation(
    method: &HostileMethod,
    small: Option<Measured>,
    large: Option<Measured>,
) -> Option<&'static str> {
    let Some(large) = large else { return Some("limit") };
    if large.seconds > 1.0 + 1e-6 * method.microseconds * large.triangles {
        return Some("time");
    }
    let grows = small.is_none_or(|small| large.seconds > MAX_GROWTH * small.seconds);
    (grows && large.seconds > SHORT).then_some("growth")
}

fn row(
    shape: &str,
    method: &HostileMethod,
    small: Option<Measured>,
    large: Option<Measured>,
    violation: Option<&str>,
    limit: u64,
) -> Vec<String> {
    let mut cells = vec![shape.into(), method.name.into()];
    match large {
        Some(large) => {
            let growth = small.map_or("-".into(), |small| format!("{:.1}", large.seconds / small.seconds));
            cells.extend([
                format!("{:.0}", large.triangles),
                large.strips.to_string(),
                format!("{:.2}", large.seconds),
                format!("{:.2}", 1e6 * large.seconds / large.triangles),
                growth,
                format!("{:.2}", large.proof_seconds),
            ]);
        }
        None => {
            cells.extend(["-".into(), "-".into(), format!("> {limit}"), "-".into(), "-".into(), "-".into()])
        }
    }
    cells.push(violation.unwrap_or("ok").into());
    cells
}

/// Formats a row when its run has finished.
fn table_line(
    shape: &str,
    method: &HostileMethod,
    small: Option<Measured>,
    large: Option<Measured>,
    violation: Option<&str>,
) -> String {
    row(shape, method, small, large, violation, 0).join("\t")
}
