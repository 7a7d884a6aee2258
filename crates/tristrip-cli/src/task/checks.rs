//! Checks of the files that charts and pictures are written to, and messages that name the flag of
//! a value.

use std::path::{Path, PathBuf};

use tristrip::Error;

use crate::job::Job;

/// The maximum number of inputs in one chart: with more, the curves cannot be told apart.
const MAX_PLOTTED_INPUTS: usize = 3;

/// Returns the message of an error in a value, by the flag that the value was given with.
pub(super) fn of_flag(error: &Error) -> String {
    match error {
        Error::Parameter { name, found, expected } => {
            format!("--{}: found {found}, expected {expected}", name.replace('_', "-"))
        }
        other => other.to_string(),
    }
}

/// Checks that a picture of one input can be written to this file.
pub(super) fn check_picture(path: &PathBuf, jobs: &[Job]) -> Result<(), String> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("png")) {
        return Err(format!("{}: --picture writes PNG; use the extension .png", path.display()));
    }
    if jobs.len() > 1 {
        return Err("--picture takes one input".into());
    }
    check_distinct_files("--picture", path, jobs)
}

/// Checks that a chart and the outputs are different files.
pub(super) fn check_distinct_files(flag: &str, path: &PathBuf, jobs: &[Job]) -> Result<(), String> {
    if jobs.iter().filter_map(|job| job.output.as_ref()).any(|output| output.path.as_ref() == Some(path)) {
        return Err(format!("{}: -o and {flag} name the same file", path.display()));
    }
    Ok(())
}

/// Checks that a chart of this many inputs can be written to this file.
pub(super) fn check_chart(flag: &str, path: &Path, input_count: usize) -> Result<(), String> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("svg")) {
        return Err(format!("{}: {flag} writes SVG; use the extension .svg", path.display()));
    }
    if input_count > MAX_PLOTTED_INPUTS {
        return Err(format!("{flag} takes at most {MAX_PLOTTED_INPUTS} inputs"));
    }
    Ok(())
}
