//! The program `tristrip`: runs the command of the library with the arguments of the process.

#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(tristrip_cli::run(std::env::args_os()))
}
