//! The native part of the Python package `tristrip`: functions and classes over NumPy arrays, and the command.
//!
//! ```text
//! NumPy arrays ─▶ arrays ─▶ strips │ mesh │ levels │ views │ stream ─▶ arrays, dictionaries with the keys of the command's JSON
//!      files   ─▶ scene  ─▶ …
//! ```
//! Every long computation runs in `work`: without the lock of the interpreter, on the threads of one pool, while the calling thread
//! handles signals and reports progress. Errors become the exceptions of `tristrip._errors` in the module `errors`. Types and
//! defaults that a user sees stand in `python/tristrip/_native.pyi`.

#![forbid(unsafe_code)]
#![allow(
    clippy::doc_markdown,
    reason = "documentation comments are docstrings of Python, which are no Markdown"
)]
#![allow(clippy::needless_pass_by_value, reason = "arguments of Python are extracted into values")]
#![allow(clippy::doc_link_with_quotes, reason = "the examples are in Python")]

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

/// The native module of the package `tristrip`, which has the documentation of its functions and classes.
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
