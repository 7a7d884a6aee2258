//! Rebuilds the crate when a file of the viewer is added; the compiler does not notice this itself.

#![allow(clippy::print_stdout, reason = "the way to tell Cargo")]

fn main() {
    println!("cargo::rerun-if-changed=dist");
}
