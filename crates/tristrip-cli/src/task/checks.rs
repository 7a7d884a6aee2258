//! Checks the output files of charts and images, and builds messages that name the flag of an
//! invalid value.

use std::path::{Path, PathBuf};

use tristrip::Error;

use crate::job::Job;

/// The maximum number of inputs in one chart. The curves of more inputs would be hard to
/// distinguish.
const MAX_PLOTTED_INPUTS: usize = 3;

/// Returns the message of an invalid value. It names the flag of the value.
pub(super) fn of_flag(error: &Error) -> String {
    match error {
        Error::Parameter { name, found, expected } => {
            format!("--{}: found {found}, expected {expected}", name.replace('_', "-"))
        }
        other => other.to_string(),
    }
}

/// Checks that the inputs can be drawn in a picture and that the picture can be written to this
/// file.
pub(super) fn check_picture(path: &PathBuf, jobs: &[Job]) -> Result<(), String> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("png")) {
        return Err(format!("{}: --picture writes PNG; use the extension .png", path.display()));
    }
    if jobs.len() > 1 {
        return Err(format!("--picture: found {} inputs, expected one", jobs.len()));
    }
    check_distinct_files("--picture", path, jobs)
}

/// Checks that a picture or chart and the outputs are different files.
pub(super) fn check_distinct_files(flag: &str, path: &PathBuf, jobs: &[Job]) -> Result<(), String> {
    if jobs.iter().filter_map(|job| job.output.as_ref()).any(|output| output.path.as_ref() == Some(path)) {
        return Err(format!("{}: -o and {flag} name the same file", path.display()));
    }
    Ok(())
}

/// Checks that a chart with this many inputs can be written to this file.
pub(super) fn check_chart(flag: &str, path: &Path, input_count: usize) -> Result<(), String> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("svg")) {
        return Err(format!("{}: {flag} writes SVG; use the extension .svg", path.display()));
    }
    if input_count > MAX_PLOTTED_INPUTS {
        return Err(format!("{flag}: found {input_count} inputs, expected at most {MAX_PLOTTED_INPUTS}"));
    }
    Ok(())
}
