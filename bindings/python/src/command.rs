//! The command, for the program `tristrip` that is installed with the package.

use pyo3::prelude::*;

/// Run the command with these arguments, of which the first is the name of the program, and return its exit code: 0 done, 1 not proven or bad
/// input, 2 wrong usage. It prints to the standard streams of the process, and from its first search on Ctrl-C is handled by the command: in a
/// program of your own, use the functions of the package instead.
///
/// >>> import tristrip
/// >>> tristrip.run_command(["tristrip", "verify", "--quiet", "missing.ply", "missing.ply"])
/// 1
#[pyfunction]
#[pyo3(signature = (arguments))]
pub(crate) fn run_command(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> u8 {
    py.detach(|| tristrip_cli::run(arguments))
}
