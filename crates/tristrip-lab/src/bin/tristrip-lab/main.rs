//! `tristrip-lab`: reproduces papers, compares methods and level models, flies cameras over models,
//! and encodes meshes in the format of paper 001.

#![forbid(unsafe_code)]

mod args;
mod console;
mod failure;
mod fly;
mod input;
mod levels;
mod pareto;
mod repro;
mod values;
mod wire;

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};

use args::{Cli, Command};
use console::Console;
use failure::Failure;

/// The stack size of each thread, equal to that of a main thread.
const STACK_BYTES: usize = 8 << 20;

fn main() -> ExitCode {
    let Cli { shared, command } = Cli::parse();
    let console = Console::new(shared.quiet, shared.json);
    let threads = shared.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().stack_size(STACK_BYTES).num_threads(threads).build();
    let done = match pool {
        Ok(pool) => pool.install(|| run(&command, &console)),
        Err(error) => Err(Failure::Failed(format!("threads: {error}"))),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Usage(message)) => {
            Cli::command().error(ErrorKind::ValueValidation, message).print().unwrap_or_default();
            ExitCode::from(2)
        }
        Err(Failure::Failed(message)) => {
            console.error(&message);
            ExitCode::FAILURE
        }
        Err(Failure::Reported) => ExitCode::FAILURE,
    }
}

fn run(command: &Command, console: &Console) -> Result<(), Failure> {
    match command {
        Command::Repro(args) => repro::run(args, console),
        Command::Levels(args) => levels::run(args, console),
        Command::Pareto(args) => pareto::run(args, console),
        Command::Fly(args) => fly::run(args, console),
        Command::Pack(args) => wire::pack(args, console),
        Command::Unpack(args) => wire::unpack(args, console),
    }
}
