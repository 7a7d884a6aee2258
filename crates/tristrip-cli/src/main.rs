//! The `tristrip` command.
fn main() {}
