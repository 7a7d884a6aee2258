//! The results of a paper, which become JSON and pages.

use serde::Serialize;

use super::paper::{LeftOut, ModelSize, PublishedSize, Tolerance};
use super::verdict::Verdict;

/// A paper with published and measured values.
#[derive(Debug, Default, Serialize)]
#[non_exhaustive]
pub struct PaperReport {
    /// The key of the paper.
    pub key: String,
    pub(crate) authors: String,
    pub(crate) title: String,
    pub(crate) year: u16,
    /// The path of the page; `None` if it was not written.
    pub page: Option<String>,
    pub(crate) tables: Vec<TableReport>,
    pub(crate) charts: Vec<ChartReport>,
    pub(crate) claims: Vec<ClaimReport>,
    pub(crate) left_out: Vec<LeftOut>,
}

#[derive(Debug, Serialize)]
pub(crate) struct TableReport {
    pub(crate) name: String,
    pub(crate) rows: Vec<RowReport>,
}

#[derive(Debug, Serialize)]
pub(crate) struct RowReport {
    pub(crate) model: String,
    /// The measured file.
    pub(crate) file: Option<String>,
    pub(crate) published: PublishedSize,
    pub(crate) measured: Option<ModelSize>,
    /// Whether the file has faces of more than three corners.
    pub(crate) polygons: Option<bool>,
    pub(crate) columns: Vec<CellReport>,
    pub(crate) verdict: String,
}

#[derive(Debug, Serialize)]
pub(crate) struct CellReport {
    pub(crate) column: String,
    /// The flags of `tristrip strip` or `tristrip-lab levels`, if strips were measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) flags: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) steps: Option<u64>,
    pub(crate) published: Option<f64>,
    pub(crate) measured: Option<f64>,
    /// `null` if the published or the measured value is missing.
    pub(crate) verdict: Option<Verdict>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ClaimReport {
    pub(crate) at: String,
    pub(crate) says: String,
    pub(crate) unit: String,
    pub(crate) expects: &'static str,
    pub(crate) published: f64,
    /// The upper end of a published range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) published_to: Option<f64>,
    /// The maximum difference of values that match; `None` if the claim is a bound.
    pub(crate) tolerance: Option<Tolerance>,
    /// Whether `published` is a target of this project for a statement that the paper makes in
    /// words.
    pub(crate) is_our_bar: bool,
    pub(crate) measured: Option<f64>,
    /// The number of models, and how many of them may not be a model of the paper.
    pub(crate) models: usize,
    pub(crate) stand_ins: usize,
    /// The value on a wider set of models, which has no verdict.
    pub(crate) beside: Option<BesideReport>,
    pub(crate) verdict: Verdict,
    #[serde(skip)]
    pub(crate) digits: usize,
}

#[derive(Debug, Serialize)]
pub(crate) struct BesideReport {
    pub(crate) measured: f64,
    pub(crate) models: usize,
    pub(crate) stand_ins: usize,
}

/// A figure of the paper, drawn from measured values.
#[derive(Debug, Serialize)]
pub(crate) struct ChartReport {
    pub(crate) name: String,
    pub(crate) file: String,
    /// `None` for an image.
    pub(crate) panels: Vec<PanelReport>,
    /// Whether any panel has a point, or an image has its model.
    #[serde(skip)]
    pub(crate) is_measured: bool,
    #[serde(skip)]
    pub(crate) contents: Vec<u8>,
}

#[derive(Debug, Serialize)]
pub(crate) struct PanelReport {
    pub(crate) title: String,
    pub(crate) series: Vec<SeriesReport>,
}

#[derive(Debug, Serialize)]
pub(crate) struct SeriesReport {
    pub(crate) name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) flags: Option<String>,
    pub(crate) points: Vec<(f64, f64)>,
}
