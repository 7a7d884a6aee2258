//! The native module of the Python package `tristrip`: functions and classes over NumPy arrays, and
//! the command.
//!
//! ```text
//! NumPy arrays ─▶ arrays ─▶ strips │ mesh │ levels │ views │ stream ─▶ arrays, dictionaries
//!      files   ─▶ scene  ─▶ …
//! ```
//! Long computations run in `work`, which releases the GIL. They run on one thread pool while the
//! calling thread handles signals and reports progress. The module `errors` converts errors to the
//! exceptions of `tristrip._errors`. `python/tristrip/_native.pyi` defines the public types and
//! defaults. Dictionaries have the keys of the command's JSON reports.

#![forbid(unsafe_code)]
#![allow(
    clippy::doc_markdown,
    reason = "documentation comments are Python docstrings, which are not Markdown"
)]
#![allow(clippy::needless_pass_by_value, reason = "PyO3 extracts arguments into values")]
#![allow(clippy::doc_link_with_quotes, reason = "the examples are Python code")]

mod arguments;
mod arrays;
mod attributes;
mod command;
mod decoder;
mod errors;
mod input;
mod levels;
mod mesh;
mod method;
mod numbers;
mod pool;
mod reports;
mod scene;
mod simplify;
mod stream;
mod strips;
mod views;
mod work;

use pyo3::prelude::*;

/// The native module. The package re-exports its functions and classes.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::command::run_command;
    #[pymodule_export]
    use crate::decoder::{Decoder, StreamedPart};
    #[pymodule_export]
    use crate::levels::Levels;
    #[pymodule_export]
    use crate::pool::set_threads;
    #[pymodule_export]
    use crate::scene::chain::Chain;
    #[pymodule_export]
    use crate::scene::class::Scene;
    #[pymodule_export]
    use crate::scene::functions::{convert, load, verify};
    #[pymodule_export]
    use crate::scene::part::Part;
    #[pymodule_export]
    use crate::scene::simplify::SimplifiedScene;
    #[pymodule_export]
    use crate::scene::strip::StrippedScene;
    #[pymodule_export]
    use crate::simplify::{Simplified, simplify};
    #[pymodule_export]
    use crate::stream::{inspect, pack, unpack};
    #[pymodule_export]
    use crate::strips::{Strips, stripify};
    #[pymodule_export]
    use crate::views::{View, ViewModel};

    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
