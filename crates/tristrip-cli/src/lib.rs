//! The `tristrip` command as a library. The program passes its arguments to [`run`]. With the
//! feature `schema`, `report_schemas` returns the JSON Schemas of the reports.
//!
//! ```text
//! args ─▶ task ─▶ input ─▶ tristrip-pipeline, tristrip-render, tristrip-serve ─▶ output ─▶ figures ─▶ console
//!                 strip │ compare │ bound │ analyze │ verify │ convert │ simplify │ level │ chain │ build_lod
//!                 pack │ unpack │ inspect │ serve │ view
//! ```
//! `serve` and `view` need the feature `serve`, and HTTPS the feature `tls`.
//!
//! The exit code is 0 if all results are verified, 1 if a verification, an input or an output
//! fails, and 2 for wrong usage.

#![forbid(unsafe_code)]

mod analyze;
mod args;
mod bound;
mod build_lod;
mod chain;
mod clock;
mod compare;
mod console;
mod convert;
mod failure;
mod figures;
mod input;
mod inspect;
mod job;
mod level;
#[cfg(feature = "serve")]
mod logs;
mod method;
mod output;
mod pack;
mod reorder;
mod report;
#[cfg(feature = "schema")]
mod schema;
mod search;
#[cfg(feature = "serve")]
mod serve;
mod shell;
mod simplify;
mod stage;
mod strip;
mod task;
mod topics;
mod unpack;
mod values;
mod verify;
#[cfg(feature = "serve")]
mod view;

use std::ffi::OsString;

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use console::Console;
#[cfg(feature = "schema")]
pub use schema::report_schemas;
use task::Task;

/// The exit code on success, with all results verified, and for help and version.
const DONE: u8 = 0;
/// The exit code if a result fails verification, or for an input or output error.
const FAILED: u8 = 1;
/// The exit code for wrong usage.
const WRONG_USAGE: u8 = 2;
/// The stack size of each thread. It is that of a main thread because tasks run on these threads.
const STACK_BYTES: usize = 8 << 20;

/// Runs the command and returns its exit code. The first argument is the program name.
///
/// - 0: all results are verified, or help or the version was printed.
/// - 1: a result fails verification, or an input or output fails; a message states the reason.
/// - 2: wrong usage; a message names the flag.
///
/// The command reads and writes the standard streams of the process. Help and messages always call
/// the program `tristrip`.
///
/// # Signals
/// The first search replaces the Ctrl-C handler of the process; the new handler stays installed. On
/// Ctrl-C outside a search, or on a second Ctrl-C, this handler ends the process with the exit code
/// 130; nothing else ends the process. The web server installs handlers for Ctrl-C and SIGTERM,
/// which also stay installed. The interrupt state is global to the process: run one command at a
/// time.
///
/// ```
/// assert_eq!(tristrip_cli::run(["tristrip", "--version"]), 0);
/// assert_eq!(tristrip_cli::run(["tristrip", "bound", "../../testdata/models/fish_control.ply", "--quiet"]), 0);
/// assert_eq!(tristrip_cli::run(["tristrip", "bound", "missing.ply"]), 1);
/// assert_eq!(tristrip_cli::run(["tristrip", "bound"]), 2);
/// ```
pub fn run<I, T>(arguments: I) -> u8
where
    I: IntoIterator<Item = T>,
    T: Into<OsString>,
{
    run_command(arguments.into_iter().map(Into::into).collect())
}

/// Runs the command; [`run`] is its generic interface.
fn run_command(arguments: Vec<OsString>) -> u8 {
    search::forget_interrupt();
    let (task, shared) = match task::parse(arguments) {
        Ok(parsed) => parsed,
        Err(message) => {
            console::print_usage(&message);
            return if message.use_stderr() { WRONG_USAGE } else { DONE };
        }
    };
    let mut console = Console::new(&shared, task.output_is_stdout());
    let pool = match pool(shared.threads) {
        Ok(pool) => pool,
        Err(error) => {
            console.error(&format!("threads: {error}"));
            return FAILED;
        }
    };
    let succeeded = pool.install(|| run_task(&task, &mut console));
    if succeeded && console.finish() { DONE } else { FAILED }
}

/// Builds the thread pool of the command. A single thread is the calling thread, unless this thread
/// already belongs to a pool: a thread never leaves the pool that it joined for an earlier command.
fn pool(threads: Option<usize>) -> Result<ThreadPool, ThreadPoolBuildError> {
    let builder = ThreadPoolBuilder::new().stack_size(STACK_BYTES);
    match threads {
        Some(1) if rayon::current_thread_index().is_none() => {
            builder.num_threads(1).use_current_thread().build()
        }
        Some(n) => builder.num_threads(n).build(),
        None => builder.build(),
    }
}

/// Runs a task; returns whether it succeeded and all results are verified.
fn run_task(task: &Task, console: &mut Console) -> bool {
    match task {
        Task::Strip(task) => strip::run(task, console),
        Task::Compare(task) => compare::run(task, console),
        Task::Bound(task) => bound::run(task, console),
        Task::Analyze(task) => analyze::run(task, console),
        Task::Verify(task) => verify::run(task, console),
        Task::Convert(task) => convert::run(task, console),
        Task::Simplify(task) => simplify::run(task, console),
        Task::Level(task) => level::run(task, console),
        Task::Chain(task) => chain::run(task, console),
        Task::BuildLod(task) => build_lod::run(task, console),
        Task::Pack(task) => pack::run(task, console),
        Task::Unpack(task) => unpack::run(task, console),
        Task::Inspect(task) => inspect::run(task, console),
        #[cfg(feature = "serve")]
        Task::Serve(task) => serve::run(task, console),
        #[cfg(feature = "serve")]
        Task::View(task) => view::run(task, console),
        Task::Print(text) => {
            console.write_stdout(text);
            true
        }
    }
}
