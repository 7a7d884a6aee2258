//! Compiles the crate again when a file of the viewer is added, which the compiler does not see by itself.

#![allow(clippy::print_stdout, reason = "the way to tell Cargo")]

use std::path::Path;

fn main() {
    for name in ["index.html", "viewer", "src", "three", "webgl"] {
        let path = Path::new("../../web").join(name);
        // A path that does not exist would always count as changed.
        if path.exists() {
            println!("cargo::rerun-if-changed={}", path.display());
        }
    }
}
