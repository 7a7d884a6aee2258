//! A target and its text, for the groups of targets.

use serde::Serialize;

use crate::measure::{MethodRow, Outcome};

/// Half of the last digit of the peers' values.
pub(super) const ROUNDING: f64 = 0.000_05;

/// The maximum number of models that are named when a target is missed.
const NAMED: usize = 5;

/// A target and the measured value.
#[derive(Debug, Clone, Serialize)]
pub struct Target {
    /// The measured quantity.
    pub what: String,
    /// The target.
    pub target: String,
    /// The measured value.
    pub found: String,
    /// Whether the target is met.
    pub met: bool,
}

impl Target {
    /// Creates a target that a value of at most `target` meets.
    pub fn at_most(what: String, target: f64, found: f64, digits: usize) -> Self {
        let (target_text, found_text) = (format!("≤ {target:.digits$}"), format!("{found:.*}", digits + 1));
        Self { what, target: target_text, found: found_text, met: found <= target }
    }

    /// Creates a target that a value of at least `target` meets.
    pub fn at_least(what: String, target: f64, found: f64, digits: usize) -> Self {
        let (target_text, found_text) = (format!("≥ {target:.digits$}"), format!("{found:.*}", digits + 1));
        Self { what, target: target_text, found: found_text, met: found >= target }
    }
}

/// Returns how many models miss a target, with the names of the first few.
fn listed(names: &[String], of: usize) -> String {
    let count = format!("{} of {of}", names.len());
    match names.len() {
        0 => count,
        n if n <= NAMED => format!("{count}: {}", names.join(", ")),
        _ => format!("{count}: {}, …", names[..NAMED].join(", ")),
    }
}

/// Returns a target that no model may miss.
pub(super) fn none(what: &str, missed: impl Iterator<Item = String>, of: usize) -> Option<Target> {
    let missed: Vec<String> = missed.collect();
    let (found, met) = (listed(&missed, of), missed.is_empty());
    (of > 0).then(|| Target { what: what.into(), target: "none".into(), found, met })
}

/// Returns the row of a method on a model, as triangles or as polygons.
pub(super) fn row<'a>(
    outcomes: &'a [Outcome],
    model: &str,
    polygons: bool,
    method: &str,
) -> Option<&'a MethodRow> {
    outcomes.iter().find(|o| o.model == model && o.polygons == polygons)?.row(method)
}

/// Returns the geometric mean of ratios; `None` if there are none.
pub(super) fn geometric_mean(ratios: impl Iterator<Item = f64>) -> Option<f64> {
    let logarithms: Vec<f64> = ratios.map(f64::ln).collect();
    (!logarithms.is_empty()).then(|| (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp())
}
