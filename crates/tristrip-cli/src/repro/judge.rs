//! Papers with what was measured beside what they say: the report that becomes JSON and pages.

use serde::Serialize;

use super::lab::{Lab, Recipe};
use super::paper::{Claim, Column, Expects, LeftOut, Paper, Quantity, Row, Table};
use super::statistics;
use super::verdict::{Verdict, of_row, rounded};

/// A model is the published one if its vertices and triangles are within so many percent of the published ones.
const NEAR_PERCENT: f64 = 3.0;

/// A paper, published beside measured.
#[derive(Debug, Serialize)]
pub(crate) struct PaperReport {
    pub(crate) key: String,
    pub(crate) authors: String,
    pub(crate) title: String,
    pub(crate) year: u16,
    /// The page's path.
    pub(crate) page: Option<String>,
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
    /// The file that was measured.
    pub(crate) file: Option<String>,
    pub(crate) published: Counts,
    pub(crate) measured: Option<Counts>,
    /// Whether the file has faces of more than three corners.
    pub(crate) polygons: Option<bool>,
    pub(crate) columns: Vec<Cell>,
    pub(crate) verdict: String,
}

/// The size of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(crate) struct Counts {
    pub(crate) vertices: usize,
    pub(crate) triangles: usize,
}

#[derive(Debug, Serialize)]
pub(crate) struct Cell {
    pub(crate) column: String,
    /// The flags of `tristrip strip` or `tristrip lod`, where strips were measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) flags: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) steps: Option<u64>,
    pub(crate) published: Option<f64>,
    pub(crate) measured: Option<f64>,
    /// `null` where one of the two is missing.
    pub(crate) verdict: Option<Verdict>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ClaimReport {
    pub(crate) at: String,
    pub(crate) says: String,
    pub(crate) unit: String,
    pub(crate) expects: &'static str,
    pub(crate) published: f64,
    pub(crate) measured: Option<f64>,
    pub(crate) models: usize,
    pub(crate) verdict: Verdict,
    #[serde(skip)]
    pub(crate) digits: usize,
}

/// A figure drawn anew.
#[derive(Debug, Serialize)]
pub(crate) struct ChartReport {
    pub(crate) name: String,
    pub(crate) file: String,
    pub(crate) panels: Vec<PanelReport>,
    #[serde(skip)]
    pub(crate) svg: String,
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

/// What a file is to a published model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Identity {
    /// The same, or nearly.
    Same {
        counts: Counts,
    },
    StandIn {
        name: String,
        counts: Counts,
    },
    Missing,
}

/// Tells what the file of a row is to the row's model, by the counts.
pub(super) fn identify(row: &Row, lab: &Lab) -> Identity {
    let Some((name, model)) = row.file.as_ref().and_then(|name| Some((name, lab.model(name)?))) else {
        return Identity::Missing;
    };
    let counts = Counts { vertices: model.vertices, triangles: model.triangles };
    let near = |a: usize, b: usize| 100.0 * a.abs_diff(b) as f64 <= NEAR_PERCENT * b as f64;
    if !row.stand_in && near(counts.vertices, row.vertices) && near(counts.triangles, row.triangles) {
        Identity::Same { counts }
    } else {
        Identity::StandIn { name: name.clone(), counts }
    }
}

/// Asks for everything that a paper's tables and claims need.
pub(super) fn want(paper: &Paper, lab: &mut Lab) {
    for table in &paper.tables {
        for file in table.rows.iter().filter_map(|row| row.file.as_ref()) {
            lab.want_mesh(file);
            for column in &table.columns {
                match (&column.quantity, recipe(&column.quantity)) {
                    (Quantity::Levels { .. }, Some(recipe)) => lab.want_levels(recipe, file),
                    (_, Some(recipe)) => lab.want(recipe, file),
                    (_, None) => {}
                }
            }
        }
    }
    paper.claims.iter().for_each(|claim| statistics::want(&claim.statistic, paper, lab));
}

fn recipe(quantity: &Quantity) -> Option<Recipe> {
    match quantity {
        Quantity::Strips { flags, steps, .. } => Some(Recipe { flags: flags.clone(), steps: *steps }),
        Quantity::Levels { flags, .. } => Some(flags.as_str().into()),
        _ => None,
    }
}

/// Judges a paper's tables and claims.
pub(super) fn judge(paper: &Paper, charts: Vec<ChartReport>, lab: &Lab) -> PaperReport {
    PaperReport {
        key: paper.key.clone(),
        authors: paper.authors.clone(),
        title: paper.title.clone(),
        year: paper.year,
        page: None,
        tables: paper.tables.iter().map(|table| judge_table(table, lab)).collect(),
        charts,
        claims: paper.claims.iter().map(|claim| judge_claim(claim, paper, lab)).collect(),
        left_out: paper.left_out.clone(),
    }
}

fn judge_table(table: &Table, lab: &Lab) -> TableReport {
    let rows = table.rows.iter().map(|row| judge_row(row, &table.columns, lab)).collect();
    TableReport { name: table.name.clone(), rows }
}

fn judge_row(row: &Row, columns: &[Column], lab: &Lab) -> RowReport {
    let identity = identify(row, lab);
    let measured = measured(row, columns, lab);
    let mut published = row.published.iter();
    let mut cells = Vec::with_capacity(columns.len());
    for (column, measured) in columns.iter().zip(measured) {
        let published = if column.ours { None } else { published.next().copied() };
        // A saving follows from two other columns, which have verdicts of their own.
        let is_judged = !matches!(column.quantity, Quantity::Saving { .. });
        let pair = published.zip(measured).filter(|_| is_judged);
        let verdict = pair.map(|(published, measured)| match &identity {
            Identity::StandIn { name, .. } => Verdict::StandIn(name.clone()),
            _ => Verdict::of(published, measured, column.better, column.tolerance, column.digits),
        });
        let recipe = recipe(&column.quantity);
        cells.push(Cell {
            column: column.name.clone(),
            steps: recipe.as_ref().and_then(|recipe| recipe.steps),
            flags: recipe.map(|recipe| recipe.flags),
            published,
            measured: measured.map(|figure| rounded(figure, 6)),
            verdict,
        });
    }
    let verdict = match &identity {
        Identity::Missing => Verdict::NotAvailable.to_string(),
        Identity::StandIn { name, .. } => Verdict::StandIn(name.clone()).to_string(),
        Identity::Same { .. } => {
            let judged = cells.iter().filter_map(|cell| Some((cell.column.as_str(), cell.verdict.as_ref()?)));
            of_row(&judged.collect::<Vec<_>>())
        }
    };
    let (file, counts) = match identity {
        Identity::Missing => (None, None),
        Identity::Same { counts } | Identity::StandIn { counts, .. } => (row.file.clone(), Some(counts)),
    };
    RowReport {
        model: row.model.clone(),
        published: Counts { vertices: row.vertices, triangles: row.triangles },
        measured: counts,
        polygons: file.as_ref().and_then(|name| lab.model(name)).map(|model| model.has_polygons),
        file,
        columns: cells,
        verdict,
    }
}

/// Measures the columns of a row; savings come of the others.
fn measured(row: &Row, columns: &[Column], lab: &Lab) -> Vec<Option<f64>> {
    let model = row.file.as_ref().and_then(|name| lab.model(name));
    let figure = |quantity: &Quantity| match quantity {
        Quantity::Strips { figure, .. } => model?.strips(&recipe(quantity)?, figure),
        Quantity::Levels { figure, .. } => model?.levels(&recipe(quantity)?, figure),
        Quantity::Mesh(figure) => model?.mesh(figure),
        Quantity::Saving { .. } | Quantity::Unmeasured => None,
    };
    let figures: Vec<Option<f64>> = columns.iter().map(|column| figure(&column.quantity)).collect();
    let with_savings = columns.iter().zip(&figures).map(|(column, figure)| match column.quantity {
        Quantity::Saving { of, than } => {
            let (of, than) = (figures.get(of).copied()??, figures.get(than).copied()??);
            (than > 0.0).then(|| 100.0 * (1.0 - of / than))
        }
        _ => *figure,
    });
    with_savings.collect()
}

fn judge_claim(claim: &Claim, paper: &Paper, lab: &Lab) -> ClaimReport {
    let measured = statistics::compute(&claim.statistic, paper, lab);
    let rule = (claim.better, claim.tolerance, claim.digits);
    let verdict = match measured {
        Some((measured, _)) => Verdict::of_claim(claim.published, measured, claim.expects, rule),
        None => Verdict::NotAvailable,
    };
    ClaimReport {
        at: claim.at.clone(),
        says: claim.says.clone(),
        unit: claim.unit.clone(),
        expects: match claim.expects {
            Expects::About => "about",
            Expects::AtLeast => "at least",
            Expects::AtMost => "at most",
        },
        published: claim.published,
        measured: measured.map(|(figure, _)| rounded(figure, 6)),
        models: measured.map_or(0, |(_, models)| models),
        verdict,
        digits: claim.digits,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::console::Console;
    use crate::stages::Pool;
    use crate::task::Shared;
    use std::path::Path;

    /// A lab that has measured one column on the models of the project's own.
    fn lab(names: &[&str]) -> Lab {
        let pool = Pool::new(Some(1)).unwrap();
        let mut console = Console::new(&Shared { json: false, quiet: true, threads: Some(1) }, false);
        let mut lab = Lab::new(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/models")).unwrap();
        names.iter().for_each(|name| lab.want("--method sgi".into(), name));
        lab.measure(&pool, &mut console).unwrap();
        lab
    }

    fn row(file: &str, (vertices, triangles): (usize, usize), stand_in: bool) -> Row {
        let file = (!file.is_empty()).then(|| file.into());
        Row { model: "A model".into(), file, stand_in, vertices, triangles, published: vec![9000.0, 20.0] }
    }

    #[test]
    fn a_model_is_known_by_its_counts() {
        let lab = lab(&["wingnut"]);
        let counts = |model: &str| lab.model(model).map(|m| (m.vertices, m.triangles)).unwrap();
        let (v, t) = counts("wingnut");
        let is_same = |row: &Row| matches!(identify(row, &lab), Identity::Same { .. });
        assert!(is_same(&row("wingnut", (v, t), false)));
        assert!(is_same(&row("wingnut", (v + v / 50, t - t / 50), false)), "2 % off");
        assert!(!is_same(&row("wingnut", (v, t + t / 20), false)), "5 % off");
        assert!(!is_same(&row("wingnut", (v, t), true)), "another shape");
        for gone in ["", "hand", "nobody"] {
            assert_eq!(identify(&row(gone, (v, t), false), &lab), Identity::Missing);
        }
    }

    #[test]
    fn rows_are_judged_by_what_was_measured_on_them() {
        let lab = lab(&["wingnut"]);
        let columns: Vec<Column> = serde_json::from_str(
            r#"[{ "name": "SGI", "quantity": { "strips": { "flags": "--method sgi", "figure": "vertices_sent" } },
                  "better": "lower", "tolerance": { "percent": 2 }, "digits": 0 },
                { "name": "saving", "quantity": { "saving": { "of": 0, "than": 0 } },
                  "better": "higher", "tolerance": { "absolute": 2 }, "digits": 0 },
                { "name": "triangles", "quantity": { "mesh": "triangles" },
                  "better": "neither", "tolerance": { "absolute": 0 }, "digits": 0, "ours": true }]"#,
        )
        .unwrap();
        let model = lab.model("wingnut").unwrap();
        let same = judge_row(&row("wingnut", (model.vertices, model.triangles), false), &columns, &lab);
        let measured: Vec<Option<f64>> = same.columns.iter().map(|cell| cell.measured).collect();
        assert_eq!(measured[0], model.strips(&"--method sgi".into(), "vertices_sent"));
        assert_eq!(measured[1..], [Some(0.0), Some(6090.0)]);
        // A saving follows from others, and a column of ours has nothing beside it.
        assert_eq!(same.columns.iter().filter(|cell| cell.verdict.is_some()).count(), 1);
        assert_eq!(same.verdict, "better");
        let other = judge_row(&row("wingnut", (1, 1), false), &columns, &lab);
        assert_eq!((other.verdict.as_str(), other.columns[0].measured), ("stand-in: wingnut", measured[0]));
        let gone = judge_row(&row("", (1, 1), false), &columns, &lab);
        assert_eq!((gone.verdict.as_str(), gone.file.as_ref()), ("model not available", None));
        assert!(gone.columns.iter().all(|cell| cell.measured.is_none()));
    }
}
