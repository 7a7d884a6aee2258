//! What a paper says, as data: tables, figures, claims, and what of them is compared with which measurement.
//!
//! A paper is a JSON file in `papers/`. A new table, figure or claim is an entry there; a new kind of measurement is a variant of
//! [`Quantity`], [`Kind`] or [`Statistic`]. Strips are named by the flags of the command that finds them, so that each figure of
//! ours can be had again by hand: `tristrip strip MODEL` with the same flags.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// The papers by their keys.
const PAPERS: [(&str, &str); 4] = [
    ("000", include_str!("papers/000.json")),
    ("001", include_str!("papers/001.json")),
    ("003", include_str!("papers/003.json")),
    ("004", include_str!("papers/004.json")),
];

/// A paper with what is compared of it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Paper {
    pub(crate) key: String,
    pub(crate) authors: String,
    pub(crate) title: String,
    pub(crate) year: u16,
    pub(crate) tables: Vec<Table>,
    pub(crate) charts: Vec<ChartData>,
    pub(crate) claims: Vec<Claim>,
    pub(crate) left_out: Vec<LeftOut>,
}

/// A published table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Table {
    pub(crate) name: String,
    pub(crate) shows: String,
    /// Whether the published models have polygons, so that it matters where a file has only triangles.
    #[serde(default)]
    pub(crate) polygons: bool,
    pub(crate) columns: Vec<Column>,
    pub(crate) rows: Vec<Row>,
}

/// A column of a table, and the measurement that it is compared with.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) quantity: Quantity,
    pub(crate) better: Better,
    pub(crate) tolerance: Tolerance,
    /// Digits after the point.
    pub(crate) digits: usize,
    /// Whether the paper has no such column.
    #[serde(default)]
    pub(crate) ours: bool,
}

/// What is measured for a column.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Quantity {
    /// A figure of strips: a key of the report of `tristrip strip`, or the misses per triangle of a buffer: `acmr_lru_32`.
    Strips {
        flags: String,
        figure: String,
        /// Accesses to nodes after which a search is stopped.
        steps: Option<u64>,
    },
    /// A figure of levels of detail, whose strips these flags find: see [`crate::repro::levels`].
    Levels { flags: String, figure: String },
    /// A figure of the mesh: a key of `mesh` in that report.
    Mesh(String),
    /// How many percent one column is below another, by their numbers.
    Saving { of: usize, than: usize },
    /// Nothing: it cannot be measured again.
    Unmeasured,
}

/// The published figures of a model.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Row {
    pub(crate) model: String,
    /// The file that is the model, or stands in for it.
    pub(crate) file: Option<String>,
    /// Whether the file stands in for it although its counts agree.
    #[serde(default)]
    pub(crate) stand_in: bool,
    pub(crate) vertices: usize,
    pub(crate) triangles: usize,
    /// For each column that is not ours.
    pub(crate) published: Vec<f64>,
}

/// Which of two figures is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Better {
    Lower,
    Higher,
    #[default]
    Neither,
}

/// Within what two figures match.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Tolerance {
    /// Percent of the published figure.
    Percent(f64),
    /// Units of the figure.
    Absolute(f64),
}

/// A published figure, drawn anew.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ChartData {
    pub(crate) name: String,
    pub(crate) file: String,
    pub(crate) shows: String,
    pub(crate) kind: Kind,
}

/// What a chart shows.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Kind {
    /// A figure of each model in the folder by its size, a series a method.
    Corpus { panels: Vec<CorpusPanel>, series: Vec<Variant> },
    /// The cost of generalized triangle meshes by the size of the buffer, a panel a model.
    Buffers { flags: String, models: Vec<String>, columns: usize },
    /// A figure of levels of detail by level, a panel for each of the flags that find strips, a series a figure.
    Levels { model: String, panels: Vec<LevelsPanel>, axis: String, series: Vec<LevelsSeries> },
    /// Strips left by accesses to nodes, a panel a model, a series a method.
    Convergence { models: Vec<String>, steps: u64, series: Vec<Variant> },
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CorpusPanel {
    pub(crate) title: String,
    pub(crate) axis: String,
    pub(crate) figure: String,
    pub(crate) per_triangle: bool,
}

/// A way to find the strips of the full mesh, with the panel's title.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LevelsPanel {
    pub(crate) title: String,
    pub(crate) flags: String,
}

/// A figure of a level, with its name in a legend.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LevelsSeries {
    pub(crate) name: String,
    pub(crate) figure: String,
}

/// A method with its name in a legend.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Variant {
    pub(crate) name: String,
    pub(crate) flags: String,
}

/// What a paper says in its text, as a number.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Claim {
    pub(crate) at: String,
    pub(crate) says: String,
    pub(crate) published: f64,
    #[serde(default)]
    pub(crate) expects: Expects,
    pub(crate) unit: String,
    pub(crate) digits: usize,
    #[serde(default)]
    pub(crate) better: Better,
    #[serde(default = "exactly")]
    pub(crate) tolerance: Tolerance,
    pub(crate) statistic: Statistic,
}

fn exactly() -> Tolerance {
    Tolerance::Absolute(0.0)
}

/// How a claim's number is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Expects {
    #[default]
    About,
    AtLeast,
    AtMost,
}

/// What is measured for a claim.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Statistic {
    /// How many percent a figure is below that of another method.
    Saving { over: Over, figure: String, flags: String, than: String, models: ModelSet },
    /// How many percent a figure is above the triangles and two, on average.
    Excess { figure: String, flags: String, models: ModelSet },
    /// A figure on average.
    Mean { figure: String, flags: String, models: ModelSet },
    /// The exponent by which a figure grows with the triangles: the slope where both are logarithms.
    Exponent { figure: String, flags: String, models: ModelSet },
    /// The place among variants by the sum of a figure a triangle, from 1.
    Rank { figure: String, flags: String, among: Among, models: ModelSet },
    /// A figure of levels of detail, on average.
    Levels { figure: String, flags: String, models: ModelSet },
    /// A figure of the levels of detail of a model.
    LevelsOf { figure: String, flags: String, model: String },
    /// A figure of a mesh.
    Mesh { figure: String, model: String },
    /// How many percent LRU transmits less than FIFO, on average over buffers from so many places to so many and a chart's models.
    LruSaving { chart: String, places: (u32, u32), between: Strips },
    /// How many percent of what the largest LRU buffer saves one of so many places saves, on average over a chart's models.
    SavedBy { chart: String, places: u32, between: Strips },
    /// How many times as many steps the first series of a chart takes to come to as few strips as it does, as the second does.
    Speed { chart: String, model: String },
}

/// What happens to a buffer between two strips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Strips {
    Flush,
    Keep,
}

/// How savings of many models become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Over {
    Mean,
    Greatest,
    /// The saving of the sums of the figures a triangle.
    Sum,
}

/// Which models a claim is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ModelSet {
    /// Those of the paper's tables that are here; no stand-ins.
    Table,
    /// All with a face of more than three corners.
    Polygons,
    All,
}

/// Variants of STRIPE that are ranked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Among {
    /// Rows and full patches by five cutoffs.
    Global,
    /// Partial faces with five kinds of ties.
    Partial,
    /// The global ones, whole and partial faces with five kinds of ties.
    Twenty,
}

impl Among {
    /// Lists the flags of the variants.
    pub(crate) fn flags(self) -> Vec<String> {
        let global = || {
            ["rows", "full"].into_iter().flat_map(|patches| {
                [5, 10, 15, 20, 25]
                    .map(|cutoff| format!("--method stripe-global --patches {patches} --cutoff {cutoff}"))
            })
        };
        let local = |faces: &str| {
            ["arbitrary", "look-ahead", "alternate", "random", "sequential"]
                .map(|ties| format!("--method stripe-local --triangulation {faces} --ties {ties}"))
        };
        match self {
            Self::Global => global().collect(),
            Self::Partial => local("partial").into(),
            Self::Twenty => global().chain(local("whole")).chain(local("partial")).collect(),
        }
    }
}

/// What cannot be shown again.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LeftOut {
    pub(crate) what: String,
    pub(crate) why: String,
}

/// Lists the keys of all papers.
pub(crate) fn keys() -> impl Iterator<Item = &'static str> {
    PAPERS.iter().map(|(key, _)| *key)
}

/// Reads papers by their keys, each once, in the order of the keys.
pub(crate) fn load(keys: &BTreeSet<String>) -> Result<Vec<Paper>, Failure> {
    let chosen = PAPERS.iter().filter(|(key, _)| keys.contains(*key));
    chosen
        .map(|(key, text)| {
            serde_json::from_str(text).map_err(|error| Failure::Input(format!("paper {key}: {error}")))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repro::lab::parse_flags;

    #[test]
    fn every_paper_is_whole() {
        let papers = load(&keys().map(String::from).collect()).unwrap();
        assert_eq!(papers.len(), PAPERS.len());
        for (paper, key) in papers.iter().zip(keys()) {
            assert_eq!(paper.key, key);
            for table in &paper.tables {
                let published = table.columns.iter().filter(|column| !column.ours).count();
                for row in &table.rows {
                    assert_eq!(row.published.len(), published, "{key}, {}, {}", table.name, row.model);
                }
                for column in &table.columns {
                    if let Quantity::Strips { flags, .. } | Quantity::Levels { flags, .. } = &column.quantity
                    {
                        assert!(parse_flags(flags).is_ok(), "{flags}");
                    }
                }
            }
            for claim in &paper.claims {
                if let Statistic::LruSaving { chart, .. }
                | Statistic::SavedBy { chart, .. }
                | Statistic::Speed { chart, .. } = &claim.statistic
                {
                    assert!(paper.charts.iter().any(|known| known.name == *chart), "{chart}");
                }
            }
        }
    }

    #[test]
    fn variants_are_those_of_the_paper() {
        for (among, count) in [(Among::Global, 10), (Among::Partial, 5), (Among::Twenty, 20)] {
            let flags = among.flags();
            assert_eq!(flags.iter().collect::<BTreeSet<_>>().len(), count);
            assert!(flags.iter().all(|flags| parse_flags(flags).is_ok()));
        }
    }
}
