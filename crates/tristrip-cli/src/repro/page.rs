//! A paper's page as Markdown: published beside measured, the same bytes every time.

use std::fmt::Write as _;

use super::judge::{ClaimReport, Counts, PaperReport, RowReport, TableReport};
use super::paper::{Better, Column, Paper, Quantity, Table, Tolerance};
use crate::text::{grouped, markdown};

/// Writes the page; pictures lie beside it.
pub(super) fn page(paper: &Paper, report: &PaperReport) -> String {
    let mut out = format!(
        "# Paper {}: {}, {}\n\n*{}*\n\n\
         Written by `tristrip repro`; change the program, not this page. Published figures stand beside measured ones. Every result was\n\
         proven to draw exactly the faces of its model before its figures were taken. A verdict says `matched` where they are equal within the\n\
         column's tolerance, else `better` or `worse`. A model counts as the published one if its vertices and triangles are within 3 % of\n\
         the published ones; else it is a stand-in, and nothing follows from its figures.\n\n",
        paper.key, paper.authors, paper.year, paper.title
    );
    for (table, judged) in paper.tables.iter().zip(&report.tables) {
        let _ = writeln!(out, "## {}\n\n{}\n\n{}", capital(&table.name), table.shows, rows(table, judged));
        out.push_str(&columns(table));
    }
    if !report.claims.is_empty() {
        let _ = writeln!(out, "## Claims of the text\n\n{}", claims(&report.claims));
    }
    for (data, chart) in paper.charts.iter().zip(&report.charts) {
        let _ = writeln!(
            out,
            "## {}\n\n{}\n\n![{}: {}]({})\n",
            capital(&chart.name),
            data.shows,
            capital(&chart.name),
            first_sentence(&data.shows),
            chart.file
        );
    }
    if !report.left_out.is_empty() {
        out.push_str("## Left out\n\n");
        report.left_out.iter().for_each(|left| {
            let _ = writeln!(out, "- {}: {}.", capital(&left.what), left.why);
        });
    }
    out.truncate(out.trim_end().len());
    out.push('\n');
    out
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn first_sentence(text: &str) -> &str {
    text.split_inclusive(". ").next().unwrap_or(text).trim_end_matches(['.', ' '])
}

fn rows(table: &Table, judged: &TableReport) -> String {
    let mut head: Vec<String> = ["model", "measured on"].map(String::from).to_vec();
    for column in &table.columns {
        if !column.ours {
            head.push(format!("{}, published", column.name));
        }
        if !matches!(column.quantity, Quantity::Unmeasured) {
            head.push(format!("{}, {}", column.name, if column.ours { "ours" } else { "measured" }));
        }
    }
    head.push("verdict".into());
    let figures = 2..head.len() - 1;
    let mut rows = vec![head];
    rows.extend(judged.rows.iter().map(|row| cells(table, row)));
    markdown(&rows, figures)
}

fn cells(table: &Table, row: &RowReport) -> Vec<String> {
    let mut cells = vec![row.model.clone(), measured_on(table, row)];
    for (column, cell) in table.columns.iter().zip(&row.columns) {
        if !column.ours {
            cells.push(figure(cell.published, column.digits));
        }
        if !matches!(column.quantity, Quantity::Unmeasured) {
            cells.push(figure(cell.measured, column.digits));
        }
    }
    cells.push(row.verdict.clone());
    cells
}

/// Names the file, and its counts where they are not the published ones.
fn measured_on(table: &Table, row: &RowReport) -> String {
    let (Some(file), Some(counts)) = (&row.file, row.measured) else { return "–".into() };
    let size = |counts: Counts| {
        let [v, t] = [counts.vertices, counts.triangles].map(|n| grouped(&n.to_string()));
        format!("{v} V, {t} T")
    };
    let kind = if table.polygons && row.polygons == Some(false) { ", triangles only" } else { "" };
    if counts == row.published {
        format!("{file}: {}{kind}", size(counts))
    } else {
        format!("{file}: {}{kind} (published: {})", size(counts), size(row.published))
    }
}

fn figure(figure: Option<f64>, digits: usize) -> String {
    figure.map_or_else(|| "–".into(), |figure| number(figure, digits))
}

fn number(figure: f64, digits: usize) -> String {
    let text = format!("{figure:.digits$}");
    let (sign, text) = text.strip_prefix('-').map_or(("", text.as_str()), |rest| ("−", rest));
    let (whole, rest) = text.split_at(text.find('.').unwrap_or(text.len()));
    format!("{sign}{}{rest}", grouped(whole))
}

/// Says how each column is measured and compared.
fn columns(table: &Table) -> String {
    let mut out = String::new();
    for column in &table.columns {
        let Some(how) = how(column, table) else { continue };
        let better = match column.better {
            Better::Lower => ", lower is better",
            Better::Higher => ", higher is better",
            Better::Neither => "",
        };
        let within = match column.tolerance {
            _ if column.ours => "no such column in the paper".into(),
            Tolerance::Percent(percent) => format!("matched within {percent} %"),
            Tolerance::Absolute(0.0) => "matched if equal".into(),
            Tolerance::Absolute(units) => format!("matched within {units}"),
        };
        let _ = writeln!(out, "- *{}*: {how}; {within}{better}.", column.name);
    }
    out.push('\n');
    out
}

fn how(column: &Column, table: &Table) -> Option<String> {
    let name = |number: usize| table.columns.get(number).map_or("", |column| column.name.as_str());
    match &column.quantity {
        Quantity::Strips { flags, figure, steps } => {
            let steps =
                steps.map(|n| format!(", stopped after {} accesses to nodes", grouped(&n.to_string())));
            Some(format!("`{figure}` of `tristrip strip {flags}`{}", steps.unwrap_or_default()))
        }
        Quantity::Levels { flags, figure } => Some(format!("`{figure}` of `tristrip lod {flags} --compare`")),
        Quantity::Mesh(figure) => Some(format!("`{figure}` of the mesh")),
        Quantity::Saving { of, than } => Some(format!("how far {} is below {}", name(*of), name(*than))),
        Quantity::Unmeasured => None,
    }
}

fn claims(claims: &[ClaimReport]) -> String {
    let head = ["where", "what", "published", "measured", "models", "verdict"].map(String::from);
    let mut rows = vec![head.to_vec()];
    for claim in claims {
        let expects = match claim.expects {
            "at least" => "≥ ",
            "at most" => "≤ ",
            _ => "",
        };
        let with_unit =
            |text: String| if claim.unit.is_empty() { text } else { format!("{text} {}", claim.unit) };
        // As the paper writes it.
        let published = with_unit(format!("{expects}{}", claim.published));
        let measured =
            claim.measured.map_or_else(|| "–".into(), |figure| with_unit(number(figure, claim.digits)));
        rows.push(vec![
            claim.at.clone(),
            claim.says.clone(),
            published,
            measured,
            claim.models.to_string(),
            claim.verdict.to_string(),
        ]);
    }
    markdown(&rows, 2..5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_for_people() {
        assert_eq!(number(31652.0, 0), "31,652");
        assert_eq!(number(-1234.56, 1), "−1,234.6");
        assert_eq!(number(0.7, 2), "0.70");
        assert_eq!(figure(None, 2), "–");
        assert_eq!(capital("figure 9"), "Figure 9");
        assert_eq!(first_sentence("Cost a T. More."), "Cost a T");
    }
}
