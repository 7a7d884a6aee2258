//! The published results of a paper as data: tables, figures and claims, and the measurements that
//! they are compared with.
//!
//! A paper is a JSON file in `papers/`. A new table, figure or claim is an entry there. A new kind
//! of measurement is a variant of [`Quantity`], [`ChartKind`] or [`Statistic`]. Strips are
//! specified by flags of the command, so each measured value can be reproduced by hand:
//! `tristrip strip MODEL` with the same flags. A part of a paper that is measured separately is
//! called a *section*. It is a separate file with the same key.

use serde::{Deserialize, Deserializer, Serialize};
use tristrip::vertex_cache::FlushPolicy;

use super::view_data::{Detail, PublishedView, TreeOrder, ViewPanel};

/// A section of a paper: published results that are compared with measurements. Most papers have
/// one section.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Paper {
    pub(crate) key: String,
    pub(crate) section: String,
    pub(crate) authors: String,
    pub(crate) title: String,
    pub(crate) year: u16,
    pub(crate) tables: Vec<PublishedTable>,
    pub(crate) charts: Vec<ChartData>,
    pub(crate) claims: Vec<Claim>,
    /// Remarks that a reader needs for the comparison: deviations of the measured methods, and gaps
    /// and contradictions of the text.
    #[serde(default)]
    pub(crate) remarks: Vec<String>,
    pub(crate) left_out: Vec<LeftOut>,
}

/// A published table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PublishedTable {
    pub(crate) name: String,
    pub(crate) shows: String,
    /// Whether the published models have polygons. A page must then mark files that have only
    /// triangles.
    #[serde(default)]
    pub(crate) polygons: bool,
    pub(crate) columns: Vec<PublishedColumn>,
    pub(crate) rows: Vec<PublishedRow>,
}

/// A column of a table, and the measurement that it is compared with.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PublishedColumn {
    pub(crate) name: String,
    pub(crate) quantity: Quantity,
    pub(crate) better: Better,
    pub(crate) tolerance: Tolerance,
    /// The number of decimals.
    pub(crate) digits: usize,
    /// Whether the column is an addition of this project, without published values.
    #[serde(default)]
    pub(crate) ours: bool,
}

/// The measurement of a column.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Quantity {
    /// A metric of strips: a key of the report of `tristrip strip`, or the misses per triangle of a
    /// vertex cache, such as `acmr_lru_32`.
    Strips {
        flags: String,
        figure: String,
        /// The number of node accesses after which a search is stopped.
        steps: Option<u64>,
    },
    /// A metric of levels of detail, drawn with the strips of these flags. `level_figures.rs` lists
    /// the metrics.
    Levels { flags: String, figure: String },
    /// A metric of the recovery of all levels, over the strips of these flags.
    /// `recovery_figures.rs` lists the metrics.
    Recovery { flags: String, figure: String },
    /// A metric of Skip Strips over the strips of these flags, and of the row's view if it has one.
    /// `view_figures.rs` lists the metrics.
    Views { flags: String, order: TreeOrder, figure: String },
    /// A metric of the mesh: a key of `mesh` in that report.
    Mesh(String),
    /// The percentage by which one column is below another, by their indices.
    Saving { of: usize, than: usize },
    /// The column cannot be reproduced.
    Unmeasured,
}

/// The published values of a model.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PublishedRow {
    pub(crate) model: String,
    /// The file of the model, or of its stand-in.
    pub(crate) file: Option<String>,
    /// Whether the file is a stand-in even though it has the size of the model.
    #[serde(default)]
    pub(crate) stand_in: bool,
    /// The number of vertices; `None` if the paper does not print it.
    pub(crate) vertices: Option<usize>,
    pub(crate) triangles: usize,
    /// The view of the row; `None` if it has none.
    pub(crate) view: Option<PublishedView>,
    /// The published value of each column, except for added columns.
    pub(crate) published: Vec<f64>,
}

impl PublishedRow {
    /// Returns the published size of the model.
    pub(crate) fn size(&self) -> PublishedSize {
        PublishedSize { vertices: self.vertices, triangles: self.triangles }
    }

    /// Returns the detail of the row's view.
    pub(crate) fn detail(&self) -> Option<Detail> {
        let view = self.view?;
        Some(Detail { triangles: view.triangles, of: self.triangles, up: view.up })
    }
}

/// The published numbers of vertices, if printed, and triangles of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(crate) struct PublishedSize {
    pub(crate) vertices: Option<usize>,
    pub(crate) triangles: usize,
}

/// The numbers of vertices and triangles of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub(crate) struct ModelSize {
    pub(crate) vertices: usize,
    pub(crate) triangles: usize,
}

/// Which of two values is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Better {
    Lower,
    Higher,
    #[default]
    Neither,
}

/// The maximum difference of two values that match.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Tolerance {
    /// In percent of the published value.
    Percent(f64),
    /// In the unit of the value.
    Absolute(f64),
}

/// A figure of the paper, drawn from measured values.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ChartData {
    pub(crate) name: String,
    pub(crate) file: String,
    pub(crate) shows: String,
    pub(crate) kind: ChartKind,
}

/// What a chart shows.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum ChartKind {
    /// A metric of each model in the directory by model size; one series per method.
    Corpus { panels: Vec<CorpusPanel>, series: Vec<MethodSeries> },
    /// The cost of generalized triangle meshes by the size of the vertex cache; one panel per
    /// model.
    VertexCaches { flags: String, models: Vec<String>, columns: usize },
    /// Metrics of levels of detail by level; one panel per method, one series per metric.
    Levels { model: String, panels: Vec<LevelPanel>, axis: String, series: Vec<LevelSeries> },
    /// The number of strips by node accesses; one panel per model, one series per method.
    Convergence { models: Vec<String>, steps: u64, series: Vec<MethodSeries> },
    /// Images of the display strips of a model at some detail.
    Views { model: String, flags: String, order: TreeOrder, panels: Vec<ViewPanel> },
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CorpusPanel {
    pub(crate) title: String,
    pub(crate) axis: String,
    pub(crate) figure: String,
    pub(crate) per_triangle: bool,
}

/// The flags for the strips of the full mesh, with the title of the panel.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LevelPanel {
    pub(crate) title: String,
    pub(crate) flags: String,
}

/// A metric of levels, with its name in the legend.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LevelSeries {
    pub(crate) name: String,
    pub(crate) figure: String,
}

/// A method, with its name in the legend.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MethodSeries {
    pub(crate) name: String,
    pub(crate) flags: String,
}

/// A number stated in the text of a paper.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Claim {
    pub(crate) at: String,
    pub(crate) says: String,
    /// The number, if the paper prints it.
    pub(crate) published: Option<f64>,
    /// The upper end, if the paper prints a range.
    pub(crate) up_to: Option<f64>,
    /// The number, if it follows from a table.
    pub(crate) follows: Option<PrintedNumber>,
    /// The range, if it follows from a table.
    pub(crate) range_of: Option<PrintedSavings>,
    /// The two printed numbers, if the number is their ratio in percent.
    pub(crate) percent_of: Option<[f64; 2]>,
    #[serde(default)]
    pub(crate) expects: Expects,
    /// Whether the number is a target of this project for a statement that the paper makes in
    /// words.
    #[serde(default)]
    pub(crate) is_our_bar: bool,
    pub(crate) unit: String,
    pub(crate) digits: usize,
    #[serde(default)]
    pub(crate) better: Better,
    #[serde(default = "exact")]
    pub(crate) tolerance: Tolerance,
    pub(crate) statistic: Statistic,
    /// A wider set of models. Its value is shown next to the result, without a verdict.
    pub(crate) beside: Option<ModelSet>,
}

/// A number that follows from the cells of a column.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PrintedNumber {
    pub(crate) table: String,
    pub(crate) column: String,
    /// The input: the cells, or the percentage by which they exceed the number of triangles plus 2.
    #[serde(default)]
    pub(crate) cells: PrintedCells,
    pub(crate) over: PrintedOver,
    #[serde(default)]
    pub(crate) rows: PrintedRows,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum PrintedCells {
    #[default]
    Value,
    Excess,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum PrintedOver {
    Mean,
    Greatest,
    /// The exponent of the growth of the cells with the number of triangles.
    Exponent,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum PrintedRows {
    /// The rows whose model is in the directory and is not a stand-in.
    #[default]
    Available,
    All,
}

/// The percentage by which the printed cells of a column are below those of another column, over
/// all rows.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PrintedSavings {
    pub(crate) table: String,
    pub(crate) of: String,
    pub(crate) than: String,
}

fn exact() -> Tolerance {
    Tolerance::Absolute(0.0)
}

/// The bound that a claim sets for the measured value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Expects {
    #[default]
    About,
    AtLeast,
    AtMost,
}

/// The measurement of a claim.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Statistic {
    /// The percentage by which a metric is below that of another method.
    Saving { over: SavingOver, figure: String, flags: String, than: String, models: ModelSet },
    /// The mean percentage by which a metric exceeds the number of triangles plus 2.
    Excess { figure: String, flags: String, models: ModelSet },
    /// The mean of a metric.
    Mean { figure: String, flags: String, models: ModelSet },
    /// The exponent of the growth of a metric with the number of triangles: the slope of the
    /// regression line of their logarithms.
    Exponent { figure: String, flags: String, models: ModelSet },
    /// The rank among variants, from 1, by the sum of a metric per triangle.
    Rank { figure: String, flags: String, among: StripeVariants, models: ModelSet },
    /// The mean of a metric of levels of detail.
    Levels { figure: String, flags: String, models: ModelSet },
    /// A metric of the levels of detail of a model.
    LevelsOf { figure: String, flags: String, model: String },
    /// A metric of the recovery of the levels of a model.
    RecoveryOf { figure: String, flags: String, model: String },
    /// A metric of Skip Strips of a model, without a view.
    ViewsOf { figure: String, flags: String, order: TreeOrder, model: String },
    /// The percentage by which the measured cells of a column are below those of another column,
    /// over the rows of a table.
    Columns { over: SavingOver, table: String, of: String, than: String },
    /// A metric of a mesh.
    Mesh { figure: String, model: String },
    /// A metric of the strips of a model, divided by that of another method if there is one.
    StripsOf { figure: String, flags: String, than: Option<String>, model: String },
    /// The number of components of a model that one strip draws.
    OneStripComponents { flags: String, model: String },
    /// The percentage by which LRU transmits less than FIFO, as the mean over a range of
    /// vertex-cache sizes and the models of a chart.
    LruSaving {
        chart: String,
        entries: (u32, u32),
        #[serde(deserialize_with = "flush_policy")]
        flush_policy: FlushPolicy,
    },
    /// The saving of an LRU vertex cache of one size, in percent of the saving of the largest size,
    /// as the mean over the models of a chart.
    SavedBy {
        chart: String,
        entries: u32,
        #[serde(deserialize_with = "flush_policy")]
        flush_policy: FlushPolicy,
    },
    /// The steps of the first series of a chart, divided by the steps after which the second series
    /// has as few strips.
    Speed { chart: String, model: String },
}

/// Parses the name of a flush policy: `flush` or `keep`.
fn flush_policy<'de, D: Deserializer<'de>>(deserializer: D) -> Result<FlushPolicy, D::Error> {
    #[derive(Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum PolicyName {
        Flush,
        Keep,
    }
    Ok(match PolicyName::deserialize(deserializer)? {
        PolicyName::Flush => FlushPolicy::Flush,
        PolicyName::Keep => FlushPolicy::Keep,
    })
}

/// How the savings of several models are combined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum SavingOver {
    Mean,
    Least,
    Greatest,
    /// The saving between the sums of the metrics per triangle.
    Sum,
}

/// The models of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ModelSet {
    /// The models of the paper's tables that are in the directory, without stand-ins.
    Table,
    /// Those of the paper's models that have a face of more than three corners, for papers whose
    /// models have polygons.
    Own,
    /// All models that have a face of more than three corners.
    Polygons,
    All,
}

/// Variants of STRIPE that are ranked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum StripeVariants {
    /// Rows and full patches with five cutoffs.
    Global,
    /// Whole faces with five tie-breaking rules.
    Whole,
    /// Partial faces with five tie-breaking rules.
    Partial,
    /// The global variants, and whole and partial faces with five tie-breaking rules.
    Twenty,
}

impl StripeVariants {
    /// Returns the flags of the variants.
    pub(crate) fn flags(self) -> Vec<String> {
        let global = || {
            ["rows", "full"].into_iter().flat_map(|patches| {
                [5, 10, 15, 20, 25]
                    .map(|cutoff| format!("--method stripe-global:patches={patches},cutoff={cutoff}"))
            })
        };
        let local = |faces: &str| {
            ["arbitrary", "look-ahead", "alternate", "random", "sequential"]
                .map(|ties| format!("--method stripe-local:triangulation={faces},ties={ties}"))
        };
        match self {
            Self::Global => global().collect(),
            Self::Whole => local("whole").into(),
            Self::Partial => local("partial").into(),
            Self::Twenty => global().chain(local("whole")).chain(local("partial")).collect(),
        }
    }
}

/// A part of a paper that is not reproduced, with the reason.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LeftOut {
    pub(crate) what: String,
    pub(crate) why: String,
}

#[cfg(test)]
mod tests {
    use super::super::recipe::parse_flags;
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn variants_are_those_of_the_paper() {
        for (among, count) in [
            (StripeVariants::Global, 10),
            (StripeVariants::Whole, 5),
            (StripeVariants::Partial, 5),
            (StripeVariants::Twenty, 20),
        ] {
            let flags = among.flags();
            assert_eq!(flags.iter().collect::<BTreeSet<_>>().len(), count);
            assert!(flags.iter().all(|flags| parse_flags(flags).is_ok()));
        }
        // The variant that table 1 calls `stripe`.
        let published = "--method stripe-global:patches=rows,cutoff=5,ties=sequential";
        let parsed = |flags| parse_flags(flags).unwrap().stripify;
        assert_eq!(parsed("--method stripe"), parsed(published));
    }
}
