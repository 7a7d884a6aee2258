//! Rebuilds the crate when a file of the viewer is added; the compiler does not notice this itself.

#![allow(clippy::print_stdout, reason = "the way to tell Cargo")]

use std::path::Path;

fn main() {
    for name in ["index.html", "viewer", "src", "three", "webgl"] {
        let path = Path::new("../../web").join(name);
        // Cargo treats a missing path as always changed.
        if path.exists() {
            println!("cargo::rerun-if-changed={}", path.display());
        }
    }
}
