//! The `tristrip` command: builds verified triangle strips for polygon meshes.
//!
//! ```text
//! args ─▶ task ─▶ input ─▶ stages ─▶ output ─▶ figures ─▶ console
//!                 strip │ compare │ bound │ analyze │ verify │ convert │ simplify │ lod │ repro
//! ```
//! Exit code 0: everything was done and proven. 1: something was not proven, or an input or output was bad. 2: wrong usage.

#![forbid(unsafe_code)]

mod analyze;
mod args;
mod batch;
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
mod repro;
mod search;
mod simplify;
mod stages;
mod strip;
mod survey;
mod task;
mod text;
mod values;
mod verify;

use std::process::ExitCode;

use console::Console;
use task::Task;

fn main() -> ExitCode {
    let papers: Vec<&str> = repro::keys().collect();
    let (task, shared) = task::parse(&papers);
    let mut console = Console::new(&shared, task.output_is_stdout());
    let pool = match stages::Pool::new(shared.threads) {
        Ok(pool) => pool,
        Err(failure) => {
            console.error(&failure.to_string());
            return ExitCode::FAILURE;
        }
    };
    let succeeded = match &task {
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
    if succeeded && console.finish() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
