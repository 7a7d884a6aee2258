//! Compares the tables and claims of papers with measurements.

use super::identity::{Identity, identify};
use super::paper::{Claim, Expects, Paper, PublishedColumn, PublishedRow, PublishedTable, Quantity};
use super::paper_report::{
    BesideReport, CellReport, ChartReport, ClaimReport, PaperReport, RowReport, TableReport,
};
use super::runner::Runner;
use super::statistics::{self, Computed};
use super::table_values::{measured_values, recipe};
use super::verdict::{Verdict, rounded, row_verdict};

/// Requests the measurements of a paper's tables and claims.
pub(super) fn request(paper: &Paper, runner: &mut Runner) {
    for table in &paper.tables {
        for (row, file) in table.rows.iter().filter_map(|row| Some((row, row.file.as_ref()?))) {
            runner.request_mesh(file);
            for column in &table.columns {
                match (&column.quantity, recipe(&column.quantity)) {
                    (Quantity::Levels { .. }, Some(recipe)) => runner.request_levels(recipe, file),
                    (Quantity::Recovery { .. }, Some(recipe)) => runner.request_recovery(recipe, file),
                    (Quantity::Views { order, .. }, Some(recipe)) => {
                        runner.request_views(recipe, file, *order).details.extend(row.detail());
                    }
                    (_, Some(recipe)) => runner.request(recipe, file),
                    (_, None) => {}
                }
            }
        }
    }
    for claim in &paper.claims {
        statistics::request(&claim.statistic, None, paper, runner);
        if claim.beside.is_some() {
            statistics::request(&claim.statistic, claim.beside, paper, runner);
        }
    }
}

/// Compares a paper's tables and claims with the measurements.
pub(super) fn compare(paper: &Paper, charts: Vec<ChartReport>, runner: &Runner) -> PaperReport {
    PaperReport {
        key: paper.key.clone(),
        authors: paper.authors.clone(),
        title: paper.title.clone(),
        year: paper.year,
        page: None,
        tables: paper.tables.iter().map(|table| compare_table(table, runner)).collect(),
        charts,
        claims: paper.claims.iter().map(|claim| compare_claim(claim, paper, runner)).collect(),
        left_out: paper.left_out.clone(),
    }
}

fn compare_table(table: &PublishedTable, runner: &Runner) -> TableReport {
    let rows = table.rows.iter().map(|row| compare_row(row, &table.columns, runner)).collect();
    TableReport { name: table.name.clone(), rows }
}

fn compare_row(row: &PublishedRow, columns: &[PublishedColumn], runner: &Runner) -> RowReport {
    let identity = identify(row, runner);
    let measured = measured_values(row, columns, runner);
    let mut published = row.published.iter();
    let mut cells = Vec::with_capacity(columns.len());
    for (column, measured) in columns.iter().zip(measured) {
        let published = if column.ours { None } else { published.next().copied() };
        let verdict = published.zip(measured).map(|(published, measured)| match &identity {
            Identity::StandIn { name, .. } => Verdict::StandIn(name.clone()),
            _ => Verdict::of(published, measured, column.better, column.tolerance, column.digits),
        });
        let recipe = recipe(&column.quantity);
        cells.push(CellReport {
            column: column.name.clone(),
            steps: recipe.as_ref().and_then(|recipe| recipe.steps),
            flags: recipe.map(|recipe| recipe.flags),
            published,
            measured: measured.map(|value| rounded(value, 6)),
            verdict,
        });
    }
    let is_measurable = columns.iter().any(|column| !matches!(column.quantity, Quantity::Unmeasured));
    let verdict = match &identity {
        _ if !is_measurable => Verdict::NotMeasured.to_string(),
        Identity::Missing => Verdict::NotAvailable.to_string(),
        Identity::StandIn { name, .. } => Verdict::StandIn(name.clone()).to_string(),
        Identity::Same { .. } => {
            let verdicts =
                cells.iter().filter_map(|cell| Some((cell.column.as_str(), cell.verdict.as_ref()?)));
            row_verdict(&verdicts.collect::<Vec<_>>())
        }
    };
    let (file, size) = match identity {
        Identity::Missing => (None, None),
        Identity::Same { size } | Identity::StandIn { size, .. } => (row.file.clone(), Some(size)),
    };
    RowReport {
        model: row.model.clone(),
        published: row.size(),
        measured: size,
        polygons: file.as_ref().and_then(|name| runner.model(name)).map(|model| model.has_polygons),
        file,
        columns: cells,
        verdict,
    }
}

fn compare_claim(claim: &Claim, paper: &Paper, runner: &Runner) -> ClaimReport {
    let measured = statistics::compute(&claim.statistic, None, paper, runner);
    let beside = claim.beside.and_then(|set| statistics::compute(&claim.statistic, Some(set), paper, runner));
    let (published, published_to) = (claim.number(paper), claim.number_to(paper));
    let criteria = (claim.better, claim.tolerance, claim.digits);
    let verdict = match measured {
        Some(Computed { value, .. }) => {
            Verdict::of_claim((published, published_to), value, claim.expects, criteria)
        }
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
        published,
        published_to,
        tolerance: (claim.expects == Expects::About).then_some(claim.tolerance),
        is_our_bar: claim.is_our_bar,
        measured: measured.map(|measured| rounded(measured.value, 6)),
        models: measured.map_or(0, |measured| measured.models),
        stand_ins: measured.map_or(0, |measured| measured.stand_ins),
        beside: beside.map(|beside| BesideReport {
            measured: rounded(beside.value, 6),
            models: beside.models,
            stand_ins: beside.stand_ins,
        }),
        verdict,
        digits: claim.digits,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repro::runner::tests::measured_sgi;

    fn row(file: &str, (vertices, triangles): (usize, usize)) -> PublishedRow {
        let file = (!file.is_empty()).then(|| file.into());
        PublishedRow {
            model: "A model".into(),
            file,
            stand_in: false,
            vertices: Some(vertices),
            triangles,
            view: None,
            published: vec![9000.0, 20.0],
        }
    }

    #[test]
    fn rows_are_compared_with_measurements() {
        let runner = measured_sgi(&["wingnut"]);
        let columns: Vec<PublishedColumn> = serde_json::from_str(
            r#"[{ "name": "SGI", "quantity": { "strips": { "flags": "--method sgi", "figure": "vertices_sent" } },
                  "better": "lower", "tolerance": { "percent": 2 }, "digits": 0 },
                { "name": "saving", "quantity": { "saving": { "of": 0, "than": 0 } },
                  "better": "higher", "tolerance": { "absolute": 2 }, "digits": 0 },
                { "name": "triangles", "quantity": { "mesh": "triangles" },
                  "better": "neither", "tolerance": { "absolute": 0 }, "digits": 0, "ours": true }]"#,
        )
        .unwrap();
        let model = runner.model("wingnut").unwrap();
        let size = (model.size.vertices, model.size.triangles);
        let same = compare_row(&row("wingnut", size), &columns, &runner);
        let measured: Vec<Option<f64>> = same.columns.iter().map(|cell| cell.measured).collect();
        assert_eq!(measured[0], model.strips(&"--method sgi".into(), "vertices_sent"));
        assert_eq!(measured[1..], [Some(0.0), Some(6090.0)]);
        // Columns without published values have no verdict.
        let verdicts: Vec<bool> = same.columns.iter().map(|cell| cell.verdict.is_some()).collect();
        assert_eq!(verdicts, [true, true, false]);
        assert_eq!(same.verdict, "better: SGI; worse: saving");
        let other = compare_row(&row("wingnut", (1, 1)), &columns, &runner);
        assert_eq!((other.verdict.as_str(), other.columns[0].measured), ("stand-in: wingnut", measured[0]));
        let missing = compare_row(&row("", (1, 1)), &columns, &runner);
        assert_eq!((missing.verdict.as_str(), missing.file.as_ref()), ("model not available", None));
        assert!(missing.columns.iter().all(|cell| cell.measured.is_none()));
    }
}
