//! The `tristrip` command: builds verified triangle strips for polygon meshes.
//!
//! ```text
//! args ─▶ task ─▶ input ─▶ tristrip-pipeline, tristrip-lab, tristrip-serve ─▶ output ─▶ figures ─▶ console
//!                 strip │ compare │ bound │ analyze │ verify │ convert │ simplify │ lod │ chain │ build_lod │ fly │ pack │ unpack │ inspect │ serve │ view │ repro
//! ```
//! Exit code 0: everything was done and proven. 1: something was not proven, or an input or output was bad. 2: wrong usage.

#![forbid(unsafe_code)]

mod analyze;
mod args;
mod batch;
mod bound;
mod build_lod;
mod chain;
mod collapses;
mod compare;
mod console;
mod convert;
mod failure;
mod figures;
mod fly;
mod input;
mod inspect;
mod job;
mod join;
mod lod;
mod logs;
mod method;
mod output;
mod pack;
mod reorder;
mod repro;
mod search;
mod serve;
mod shell;
mod simplify;
mod stage;
mod strip;
mod task;
mod unpack;
mod values;
mod verify;
mod view;
mod view_model;

use std::process::ExitCode;

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use console::Console;
use task::Task;

/// The stack of each thread: that of a main thread, since tasks run on these threads.
const STACK_BYTES: usize = 8 << 20;

fn main() -> ExitCode {
    let papers: Vec<&str> = tristrip_lab::repro::keys().collect();
    let (task, shared) = task::parse(&papers);
    let mut console = Console::new(&shared, task.output_is_stdout());
    let pool = match pool(shared.threads) {
        Ok(pool) => pool,
        Err(error) => {
            console.error(&format!("threads: {error}"));
            return ExitCode::FAILURE;
        }
    };
    let succeeded = pool.install(|| run(&task, &mut console));
    if succeeded && console.finish() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Builds the threads of the command. With one thread, it is the calling thread.
fn pool(threads: Option<usize>) -> Result<ThreadPool, ThreadPoolBuildError> {
    let builder = ThreadPoolBuilder::new().stack_size(STACK_BYTES);
    match threads {
        Some(1) => builder.num_threads(1).use_current_thread().build(),
        Some(n) => builder.num_threads(n).build(),
        None => builder.build(),
    }
}

/// Runs a task; returns whether everything was done and proven.
fn run(task: &Task, console: &mut Console) -> bool {
    match task {
        Task::Strip(task) => strip::run(task, console),
        Task::Compare(task) => compare::run(task, console),
        Task::Bound(task) => bound::run(task, console),
        Task::Analyze(task) => analyze::run(task, console),
        Task::Verify(task) => verify::run(task, console),
        Task::Convert(task) => convert::run(task, console),
        Task::Simplify(task) => simplify::run(task, console),
        Task::Lod(task) => lod::run(task, console),
        Task::Chain(task) => chain::run(task, console),
        Task::BuildLod(task) => build_lod::run(task, console),
        Task::Fly(task) => fly::run(task, console),
        Task::Pack(task) => pack::run(task, console),
        Task::Unpack(task) => unpack::run(task, console),
        Task::Inspect(task) => inspect::run(task, console),
        Task::Serve(task) => serve::run(task, console),
        Task::View(task) => view::run(task, console),
        Task::Repro(task) => repro::run(task, console),
        Task::Print(text) => {
            console.write_stdout(text);
            true
        }
    }
}
