//! The papers with the published results of each section.

use std::collections::BTreeSet;

use super::paper::Paper;
use crate::error::Error;

/// The key and the JSON text of each section, in the order of the papers.
const PAPERS: [(&str, &str); 6] = [
    ("000", include_str!("papers/000.json")),
    ("000", include_str!("papers/000_skip_strips.json")),
    ("001", include_str!("papers/001.json")),
    ("002", include_str!("papers/002.json")),
    ("003", include_str!("papers/003.json")),
    ("004", include_str!("papers/004.json")),
];

/// Iterates over the keys of all papers.
///
/// ```
/// assert!(tristrip_lab::repro::keys().any(|key| key == "003"));
/// ```
pub fn keys() -> impl Iterator<Item = &'static str> {
    let mut last = "";
    PAPERS.iter().map(|(key, _)| *key).filter(move |key| std::mem::replace(&mut last, key) != *key)
}

/// Returns the sections of a paper by its key, in order; empty for an unknown key.
///
/// ```
/// assert_eq!(tristrip_lab::repro::sections("000"), ["strips", "skip-strips"]);
/// ```
pub fn sections(key: &str) -> Vec<String> {
    let papers = load(&BTreeSet::from([key.to_owned()])).unwrap_or_default();
    papers.into_iter().map(|paper| paper.section).collect()
}

/// Returns the published results of the first section of a paper as JSON, by the key of the paper.
///
/// ```
/// assert!(tristrip_lab::repro::published("003").is_some_and(|data| data.contains("Porcu")));
/// ```
pub fn published(key: &str) -> Option<&'static str> {
    PAPERS.iter().find(|(known, _)| *known == key).map(|(_, data)| *data)
}

/// Loads all sections of papers by their keys, in the order of the keys.
pub(crate) fn load(keys: &BTreeSet<String>) -> Result<Vec<Paper>, Error> {
    let chosen = PAPERS.iter().filter(|(key, _)| keys.contains(*key));
    chosen
        .map(|(key, text)| {
            serde_json::from_str(text).map_err(|error| Error::Data(format!("paper {key}: {error}")))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::paper::{Quantity, Statistic};
    use super::super::recipe::parse_flags;
    use super::*;

    #[test]
    fn every_paper_is_complete() {
        let papers = load(&keys().map(String::from).collect()).unwrap();
        assert_eq!(papers.len(), PAPERS.len());
        for pair in papers.windows(2).filter(|pair| pair[0].key == pair[1].key) {
            let head = |paper: &Paper| (paper.authors.clone(), paper.title.clone(), paper.year);
            assert_eq!(head(&pair[0]), head(&pair[1]));
            assert_ne!(pair[0].section, pair[1].section);
        }
        for (paper, (key, _)) in papers.iter().zip(PAPERS) {
            assert_eq!(paper.key, key);
            for table in &paper.tables {
                let published = table.columns.iter().filter(|column| !column.ours).count();
                for row in &table.rows {
                    assert_eq!(row.published.len(), published, "{key}, {}, {}", table.name, row.model);
                }
                for column in &table.columns {
                    match &column.quantity {
                        Quantity::Strips { flags, .. }
                        | Quantity::Views { flags, .. }
                        | Quantity::Levels { flags, .. }
                        | Quantity::Recovery { flags, .. } => {
                            assert!(parse_flags(flags).is_ok(), "{flags}");
                        }
                        _ => (),
                    }
                }
            }
            for claim in &paper.claims {
                if let Statistic::Columns { table, of, than, .. } = &claim.statistic {
                    let table = paper.tables.iter().find(|known| known.name == *table).unwrap();
                    let has = |name: &String| table.columns.iter().any(|column| column.name == *name);
                    assert!(has(of) && has(than), "{}", claim.says);
                }
                if let Statistic::LruSaving { chart, .. }
                | Statistic::SavedBy { chart, .. }
                | Statistic::Speed { chart, .. } = &claim.statistic
                {
                    assert!(paper.charts.iter().any(|known| known.name == *chart), "{chart}");
                }
            }
        }
    }
}
