//! The coverage of a page: the models that it was measured on. A run without all models must not
//! replace a page by one with less coverage.
//!
//! The coverage is read from the page itself, old or new: whether each row of a table was measured,
//! and the number of models of each claim.

use std::collections::BTreeMap;

/// The placeholder for a value that was not measured.
const UNMEASURED: &str = "–";
/// The column with the number of models in the table of claims.
const CLAIM_MODELS: usize = 4;

/// The rows of a page, each with its number of measured models.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Coverage(BTreeMap<String, usize>);

impl Coverage {
    /// Reads the coverage of a page.
    pub(super) fn of(page: &str) -> Self {
        let mut rows = BTreeMap::new();
        let (mut section, mut in_head) = ("", true);
        for line in page.lines() {
            if let Some(title) = line.strip_prefix("## ") {
                (section, in_head) = (title, true);
            }
            if line.starts_with("|---") {
                in_head = false;
            }
            let Some(cells) = line.strip_prefix("| ").filter(|_| !in_head) else { continue };
            let cells: Vec<&str> = cells.split(" | ").collect();
            let [first, second, ..] = cells[..] else { continue };
            let claimed = cells.get(CLAIM_MODELS..).filter(|_| section.starts_with(CLAIMS));
            let (row, models) = match claimed {
                Some(cells) => (format!("{first}: {second}"), most_models(cells)),
                None => (first.to_owned(), usize::from(second != UNMEASURED)),
            };
            let most: &mut usize = rows.entry(format!("{section}, {row}")).or_default();
            *most = models.max(*most);
        }
        Self(rows)
    }

    /// Returns whether nothing was measured.
    pub(super) fn is_empty(&self) -> bool {
        self.0.values().all(|&models| models == 0)
    }

    /// Returns the rows that another page measured on more models. Rows that are on only one of the
    /// pages are ignored.
    pub(super) fn missing<'a>(&'a self, other: &'a Self) -> Vec<&'a str> {
        let more = |(row, models): &(&String, &usize)| self.0.get(*row).is_some_and(|here| here < *models);
        other.0.iter().filter(more).map(|(row, _)| row.as_str()).collect()
    }
}

/// Returns the maximum number of models in the cells of a claim: `15`, or `11.2 % on 15 models`.
fn most_models(cells: &[&str]) -> usize {
    let models = |cell: &&str| cell.split(" models").next()?.rsplit(' ').next()?.parse().ok();
    cells.iter().filter_map(models).max().unwrap_or(0)
}

/// The title of the tables of claims, or its prefix.
pub(super) const CLAIMS: &str = "Claims in the text";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_claims_are_compared() {
        let page = |bunny: &str, models: usize| {
            format!(
                "## Table 1\n\n| model | measured on | a |\n|---|---|---:|\n| Bunny | {bunny} | 1 |\n| Cow | – | – |\n\n\
                 ## Claims in the text\n\n| section | claim | p | m | models | v |\n|---|---|---|\n| 4 | less | 1 | 2 | {models} | matched |\n"
            )
        };
        let [none, some, all] =
            [page("–", 0), page("bunny: 9 V", 3), page("bunny: 9 V", 5)].map(|page| Coverage::of(&page));
        assert!(none.is_empty() && !some.is_empty());
        assert_eq!(some.missing(&all), ["Claims in the text, 4: less"]);
        assert_eq!(none.missing(&some), ["Claims in the text, 4: less", "Table 1, Bunny"]);
        assert!(all.missing(&some).is_empty() && all.missing(&all).is_empty());
        assert_eq!(most_models(&["3", "matched", "11.2 % on 15 models, 12 stand-ins |"]), 15);
        assert_eq!(most_models(&["59 models, 53 stand-ins", "matched |"]), 59);
        assert!(Coverage::of("## Table 1\n").missing(&all).is_empty(), "rows of one page only");
    }
}
