//! The `tristrip` command: polygon meshes into proven triangle strips.
//!
//! ```text
//! args ─▶ task ─▶ strip │ compare │ bound │ analyze │ verify │ convert │ simplify │ lod │ repro ─▶ input ─ stages ─ output ─▶ figures, report ─▶ console
//! ```
//! The exit code is 0 when everything was done and proven, 1 when something was not or an input was bad, 2 when the command was
//! called wrongly.

#![forbid(unsafe_code)]

mod analyze;
mod args;
mod bound;
mod chart;
mod compare;
mod console;
mod convert;
mod failure;
mod figures;
mod input;
mod lod;
mod method;
mod output;
mod pareto;
mod reorder;
mod report;
mod repro;
mod search;
mod simplify;
mod stages;
mod strip;
mod survey;
mod task;
mod text;
mod verify;

use std::process::ExitCode;

use console::Console;
use task::Task;

fn main() -> ExitCode {
    let (task, shared) = args::parse();
    let mut console = Console::new(&shared, task.output_is_stdout());
    let pool = match stages::Pool::new(shared.threads) {
        Ok(pool) => pool,
        Err(failure) => {
            console.error(&failure.to_string());
            return ExitCode::FAILURE;
        }
    };
    let all_done = match &task {
        Task::Strip(task) => strip::run(task, &pool, &mut console),
        Task::Compare(task) => compare::run(task, &pool, &mut console),
        Task::Bound(task) => bound::run(task, &pool, &mut console),
        Task::Analyze(task) => analyze::run(task, &pool, &mut console),
        Task::Verify(task) => verify::run(task, &mut console),
        Task::Convert(task) => convert::run(task, &pool, &mut console),
        Task::Simplify(task) => simplify::run(task, &pool, &mut console),
        Task::Lod(task) => lod::run(task, &pool, &mut console),
        Task::Repro(task) => repro::run(task, &pool, &mut console),
    };
    if all_done && console.finish() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
