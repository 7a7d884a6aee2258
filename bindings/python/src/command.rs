//! The command-line program `tristrip` that is installed with the package.

use pyo3::prelude::*;

/// Run the command-line program and return its exit code.
///
/// The program prints to the standard streams of the process. From its first search on, it handles
/// Ctrl-C itself. In your own programs, use the functions of the package instead.
///
/// Args:
///     arguments: the command line, starting with the program name.
///
/// Returns:
///     0 for success, 1 for bad input or failed verification, 2 for wrong usage.
///
/// >>> import tristrip
/// >>> tristrip.run_command(["tristrip", "verify", "--quiet", "missing.ply", "missing.ply"])
/// 1
#[pyfunction]
#[pyo3(signature = (arguments))]
pub(crate) fn run_command(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> u8 {
    py.detach(|| tristrip_cli::run(arguments))
}
