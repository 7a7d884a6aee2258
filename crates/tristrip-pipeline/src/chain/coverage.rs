//! Screen coverages: the size on screen at which a coarser level of detail replaces a finer one.
//!
//! # Algorithm
//! The coverage of an object is the screen area of its bounding sphere divided by the area of the
//! screen. The sphere encloses the bounding box and has radius r. If it is p pixels wide, an error
//! e covers p e / 2r pixels. The error is one pixel at p = 2r / e, where the sphere covers π/4 p²
//! pixels.
//!
//! As the object gets smaller, a level is first drawn at the coverage at which its error is one
//! pixel on a screen of 1920 × 1080 pixels. This coverage is at most [`STEP`] times the coverage of
//! the level before it. Each level therefore has its own range, even if its error equals the error
//! of the level before. The last level is drawn down to coverage 0.
//!
//! | error, in % of 2r | sphere, in pixels | coverage |
//! |---|---|---|
//! | 0.1 | 1000 | 0.38 |
//! | 0.3 | 333 | 0.042 |
//! | 1 | 100 | 0.0038 |

use std::f64::consts::FRAC_PI_4;

/// The number of pixels of the screen.
const PIXELS: f64 = 1920.0 * 1080.0;

/// The maximum ratio between the starting coverages of consecutive levels.
const STEP: f64 = 0.9;

/// The bounding box and the level errors of a part, over the vertices of its collapses.
#[derive(Debug, Clone)]
pub(super) struct PartExtent {
    pub(super) lowest: [f64; 3],
    pub(super) highest: [f64; 3],
    /// The maximum collapse error of each level, the finest first.
    pub(super) errors: Vec<f32>,
}

/// Returns the minimum coverage of each level, the finest level first. The parts count as one
/// object.
pub(super) fn coverages(parts: &[&PartExtent]) -> Vec<f64> {
    let axes = [0, 1, 2].map(|axis| {
        let lowest = parts.iter().map(|part| part.lowest[axis]).fold(f64::INFINITY, f64::min);
        let highest = parts.iter().map(|part| part.highest[axis]).fold(f64::NEG_INFINITY, f64::max);
        (highest - lowest).max(0.0)
    });
    let diameter = axes.iter().map(|x| x * x).sum::<f64>().sqrt();
    let level_count = parts.iter().map(|part| part.errors.len()).max().unwrap_or(0);
    let mut from = 1.0;
    let begins = (1..level_count).map(|level| {
        let error = parts.iter().map(|part| f64::from(part.errors[level])).fold(0.0, f64::max);
        let pixels = if error > 0.0 { diameter / error } else { f64::INFINITY };
        from = (FRAC_PI_4 * pixels * pixels / PIXELS).min(STEP * from);
        from
    });
    let mut ends: Vec<f64> = begins.collect();
    ends.extend((level_count > 0).then_some(0.0));
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    fn extent(size: f64, errors: &[f32]) -> PartExtent {
        PartExtent { lowest: [0.0; 3], highest: [size, 0.0, 0.0], errors: errors.to_vec() }
    }

    #[test]
    fn a_level_begins_where_its_error_is_a_pixel() {
        let found = coverages(&[&extent(1000.0, &[0.0, 1.0, 3.0, 10.0])]);
        for (found, expected) in found.iter().zip([0.378, 0.0421, 0.00379, 0.0]) {
            assert!((found - expected).abs() < 0.001, "{found}, expected {expected}");
        }
        // At that coverage the sphere is 1000 pixels wide, and the error is one pixel.
        let width = (found[0] * PIXELS / FRAC_PI_4).sqrt();
        assert!((width - 1000.0).abs() < 1e-6, "{width}");
    }

    #[test]
    fn coverages_decrease_also_where_errors_do_not() {
        let same = coverages(&[&extent(1.0, &[0.0, 0.0, 0.5, 0.5, 0.5])]);
        assert!(same.is_sorted_by(|a, b| a > b) && (same[0] - STEP).abs() < 1e-9, "{same:?}");
        let flat = coverages(&[&extent(0.0, &[0.0, 1.0])]);
        assert_eq!(flat, [0.0, 0.0]);
    }

    #[test]
    fn parts_of_a_mesh_are_one_object() {
        let (large, small) = (extent(1000.0, &[0.0, 0.0]), extent(1.0, &[0.0, 3.0]));
        let both = [&large, &small];
        let (apart, together) = (coverages(&both[1..]), coverages(&both));
        assert!(together[0] > 0.04 && apart[0] < 1e-6, "{together:?} {apart:?}");
    }
}
