//! Published numbers that follow from other published numbers: means, extremes, excesses and growth
//! of the printed cells of a table.
//!
//! A claim does not repeat such a number. It names the cells, and the number is computed. The tests
//! recompute those that papers print.

use super::paper::{
    Claim, Paper, PrintedCells, PrintedNumber, PrintedOver, PrintedRows, PrintedSavings, PublishedRow,
    PublishedTable,
};
use super::statistics::slope;
use super::verdict::rounded;

impl Claim {
    /// Returns the number that the paper prints, or that follows from others; NaN if the claim has
    /// neither. For a range, returns the lower end.
    pub(super) fn number(&self, paper: &Paper) -> f64 {
        if let Some(number) = &self.follows {
            return number.compute(paper, self.digits);
        }
        if let Some([part, whole]) = self.percent_of {
            return rounded(100.0 * part / whole, self.digits);
        }
        match &self.range_of {
            Some(savings) => rounded(savings.all(paper).into_iter().fold(f64::NAN, f64::min), self.digits),
            None => self.published.unwrap_or(f64::NAN),
        }
    }

    /// Returns the upper end of a range.
    pub(super) fn number_to(&self, paper: &Paper) -> Option<f64> {
        let Some(savings) = &self.range_of else { return self.up_to };
        savings.all(paper).into_iter().reduce(f64::max).map(|greatest| rounded(greatest, self.digits))
    }
}

impl PrintedSavings {
    /// Returns the savings of all rows, in order.
    fn all(&self, paper: &Paper) -> Vec<f64> {
        let Some(table) = paper.tables.iter().find(|known| known.name == self.table) else {
            return Vec::new();
        };
        let saving = |row: &PublishedRow| {
            let (of, than) = (table.printed(row, &self.of)?, table.printed(row, &self.than)?);
            Some(100.0 * (1.0 - of / than))
        };
        table.rows.iter().filter_map(saving).collect()
    }
}

impl PrintedNumber {
    /// Computes the number, rounded to the shown decimals; NaN without cells.
    fn compute(&self, paper: &Paper, digits: usize) -> f64 {
        let table = paper.tables.iter().find(|known| known.name == self.table);
        let cells = table.map(|table| self.cells(table)).unwrap_or_default();
        let values: Vec<f64> = cells.iter().map(|(_, value)| *value).collect();
        let value = match self.over {
            PrintedOver::Mean => mean(&values),
            PrintedOver::Greatest => values.into_iter().fold(f64::NAN, f64::max),
            PrintedOver::Exponent => slope(&cells).unwrap_or(f64::NAN),
        };
        rounded(value, digits)
    }

    /// Returns the cells, each with the number of triangles of its row.
    fn cells(&self, table: &PublishedTable) -> Vec<(f64, f64)> {
        let available = |row: &&PublishedRow| row.file.is_some() && !row.stand_in;
        let rows = table.rows.iter().filter(|row| self.rows == PrintedRows::All || available(row));
        let cell = |row: &PublishedRow| {
            let (printed, triangles) = (table.printed(row, &self.column)?, row.triangles as f64);
            Some(match self.cells {
                PrintedCells::Value => (triangles, printed),
                PrintedCells::Excess => (triangles, 100.0 * (printed / (triangles + 2.0) - 1.0)),
            })
        };
        rows.filter_map(cell).collect()
    }
}

impl PublishedTable {
    /// Returns the printed cell of a row in a column.
    fn printed(&self, row: &PublishedRow, column: &str) -> Option<f64> {
        let mut printed = self.columns.iter().filter(|known| !known.ours);
        row.published.get(printed.position(|known| known.name == column)?).copied()
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod paper_001;

#[cfg(test)]
mod tests {
    use super::super::paper::{Expects, ModelSet, PublishedColumn, Quantity, Statistic};
    use super::super::papers::{keys, load};
    use super::*;

    fn papers() -> Vec<Paper> {
        load(&keys().map(String::from).collect()).unwrap()
    }

    /// Checks whether a number is another number rounded to some decimals, with a margin for
    /// halves.
    fn is_rounded(printed: f64, exact: f64, digits: usize) -> bool {
        (printed - exact).abs() <= 0.51 * 0.1_f64.powi(i32::try_from(digits).unwrap())
    }

    /// Returns the number that follows from other cells of the paper for a cell; `None` if none
    /// does.
    fn follows(paper: &Paper, table: &PublishedTable, column: &PublishedColumn, row: usize) -> Option<f64> {
        let figure = |quantity: &Quantity| match quantity {
            Quantity::Levels { figure, .. } => Some(figure.clone()),
            _ => None,
        };
        match &column.quantity {
            Quantity::Saving { of, than } => {
                let published = &table.rows[row].published;
                Some(100.0 * (1.0 - published[*of] / published[*than]))
            }
            // A fraction of the vertices of single triangles, which another table of the paper has.
            Quantity::Levels { figure: share, .. } => {
                let filter = share.strip_prefix("percent_")?;
                let cell = |wanted: &str| {
                    paper.tables.iter().find_map(|table| {
                        let found =
                            table.columns.iter().find(|c| figure(&c.quantity).as_deref() == Some(wanted))?;
                        table.printed(&table.rows[row], &found.name)
                    })
                };
                Some(100.0 * cell(&format!("gbits_{filter}"))? / cell("gbits_triangles")?)
            }
            _ => None,
        }
    }

    #[test]
    fn printed_savings_and_shares_follow_from_printed_cells() {
        let (mut others, mut count) = (Vec::new(), 0);
        for paper in papers() {
            for table in &paper.tables {
                for column in table.columns.iter().filter(|column| !column.ours) {
                    for (at, row) in table.rows.iter().enumerate() {
                        let Some(exact) = follows(&paper, table, column, at) else { continue };
                        let printed = table.printed(row, &column.name).unwrap();
                        count += 1;
                        if !is_rounded(printed, exact, column.digits) {
                            assert!(
                                paper.remarks.iter().any(|text| text.contains(&format!("{exact:.1}"))),
                                "{}",
                                row.model
                            );
                            others.push(format!("{} {} {exact:.1}", paper.key, row.model));
                        }
                    }
                }
            }
        }
        assert!(count >= 48, "{count} cells");
        // The remarks of the page mention both.
        assert_eq!(others, ["000 skyscraper 13.7", "004 porsche 13.1"]);
    }

    #[test]
    fn claims_name_their_cells() {
        for paper in papers() {
            for claim in &paper.claims {
                assert!(claim.number(&paper).is_finite(), "{}", claim.says);
                assert!(claim.up_to.is_none_or(|to| Some(to) > claim.published), "{}", claim.says);
                let sources = [
                    claim.published.is_some(),
                    claim.follows.is_some(),
                    claim.range_of.is_some(),
                    claim.percent_of.is_some(),
                ];
                assert_eq!(sources.into_iter().filter(|&is| is).count(), 1, "{}", claim.says);
                // Numbers that are compared on the models of a table as printed are computed from
                // its cells, not typed.
                if let Statistic::Saving { models: ModelSet::Table, .. }
                | Statistic::Excess { models: ModelSet::Table, .. }
                | Statistic::Exponent { models: ModelSet::Table, .. } = &claim.statistic
                {
                    assert!(claim.follows.is_some(), "{}", claim.says);
                }
                // A mean over the models of a table follows from a column with the same figure.
                let Statistic::Mean { figure, models: ModelSet::Table, .. } = &claim.statistic else {
                    continue;
                };
                let column = paper.tables.iter().find_map(|table| {
                    let is_it =
                        |c: &&PublishedColumn| matches!(&c.quantity, Quantity::Strips { figure: f, .. } if f == figure);
                    let column = table.columns.iter().filter(|c| !c.ours).find(is_it)?;
                    let available = table.rows.iter().filter(|row| row.file.is_some() && !row.stand_in);
                    Some(available.filter_map(|row| table.printed(row, &column.name)).collect::<Vec<_>>())
                });
                if let (Some(cells), Expects::About) = (column, claim.expects) {
                    assert!(is_rounded(claim.number(&paper), mean(&cells), claim.digits), "{}", claim.says);
                }
            }
        }
    }

    #[test]
    fn remarks_state_what_follows_from_the_tables() {
        for paper in papers()
            .iter()
            .filter(|paper| ["000", "004"].contains(&paper.key.as_str()) && paper.section == "strips")
        {
            let table = |name: &str| paper.tables.iter().find(|table| table.name == name).unwrap();
            let number = |column: &str, cells, over| {
                let (table, column) = ("table 1".into(), column.into());
                PrintedNumber { table, column, cells, over, rows: PrintedRows::All }.compute(paper, 1)
            };
            let drawing = table("table 2");
            let faster = |than: usize| {
                let saved =
                    drawing.rows.iter().map(|row| 100.0 * (1.0 - row.published[2] / row.published[than]));
                mean(&saved.collect::<Vec<_>>())
            };
            for (what, value) in [
                ("mean saving", number("saving, %", PrintedCells::Value, PrintedOver::Mean)),
                ("mean excess", number("STRIPE", PrintedCells::Excess, PrintedOver::Mean)),
                ("faster than SGI", faster(1)),
                ("faster than single triangles", faster(0)),
            ] {
                let text = format!("{value:.1} %");
                assert!(paper.remarks.iter().any(|remark| remark.contains(&text)), "{what}: {text}");
            }
        }
    }
}
