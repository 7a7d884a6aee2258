//! Whether a measured file is the published model or a stand-in.

use super::paper::{ModelSize, PublishedRow};
use super::runner::Runner;

/// The maximum difference, in percent, between the sizes of a file and the published model. It
/// applies to the number of triangles, and to the number of all vertices or of used vertices.
const NEAR_PERCENT: f64 = 3.0;

/// The relation of a measured file to a published model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Identity {
    /// The file is the published model.
    Same {
        size: ModelSize,
    },
    StandIn {
        name: String,
        size: ModelSize,
    },
    Missing,
}

/// Determines by size whether the file of a row is the published model.
pub(super) fn identify(row: &PublishedRow, runner: &Runner) -> Identity {
    let Some((name, model)) = row.file.as_ref().and_then(|name| Some((name, runner.model(name)?))) else {
        return Identity::Missing;
    };
    let (size, published) = (model.size, row.size());
    let near = |a: usize, b: usize| 100.0 * a.abs_diff(b) as f64 <= NEAR_PERCENT * b as f64;
    let vertices = [size.vertices, model.used_vertices()];
    let is_near = published.vertices.is_none_or(|count| vertices.iter().any(|&found| near(found, count)));
    if !row.stand_in && is_near && near(size.triangles, published.triangles) {
        Identity::Same { size }
    } else {
        Identity::StandIn { name: name.clone(), size }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repro::runner::tests::measured_sgi;

    #[test]
    fn models_are_identified_by_size() {
        let runner = measured_sgi(&["wingnut"]);
        let ModelSize { vertices: v, triangles: t } = runner.model("wingnut").unwrap().size;
        let row = |file: &str, vertices, triangles, stand_in| PublishedRow {
            model: "A model".into(),
            file: (!file.is_empty()).then(|| file.into()),
            stand_in,
            vertices: Some(vertices),
            triangles,
            view: None,
            published: Vec::new(),
        };
        let is_same = |row: &PublishedRow| matches!(identify(row, &runner), Identity::Same { .. });
        assert!(is_same(&row("wingnut", v, t, false)));
        assert!(is_same(&row("wingnut", v + v / 50, t - t / 50, false)), "2 % off");
        assert!(!is_same(&row("wingnut", v, t + t / 20, false)), "5 % off");
        assert!(!is_same(&row("wingnut", v, t, true)), "another shape");
        for missing in ["", "hand", "nobody"] {
            assert_eq!(identify(&row(missing, v, t, false), &runner), Identity::Missing);
        }
    }
}
