//! Published values: the tables of papers, from the data that `tristrip-lab repro` uses.

use std::collections::BTreeMap;

use serde::Deserialize;
use tristrip_lab::repro::published;

use crate::failure::Failure;

/// Porcu, Scateni: *Partitioning Meshes into Strips using the Enhanced Tunnelling Algorithm (ETA)*,
/// 2006.
pub const ETA_2006: &str = "003";
/// Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996.
pub const STRIPE_1996: &str = "004";
/// El-Sana et al.: *Efficiently Computing and Updating Triangle Strips for Real-Time Rendering*,
/// 2000.
pub const STRIPE_2000: &str = "000";

#[derive(Deserialize)]
struct Paper {
    tables: Vec<PaperTable>,
}

#[derive(Deserialize)]
struct PaperTable {
    name: String,
    columns: Vec<PaperColumn>,
    rows: Vec<PaperRow>,
}

#[derive(Deserialize)]
struct PaperColumn {
    name: String,
    #[serde(default)]
    ours: bool,
}

#[derive(Deserialize)]
struct PaperRow {
    file: Option<String>,
    #[serde(default)]
    stand_in: bool,
    published: Vec<f64>,
}

/// Returns a column of a table of a paper, by model, without models that are replaced by a
/// stand-in.
///
/// # Errors
/// The paper, table or column does not exist.
pub fn column(paper: &str, table: &str, column: &str) -> Result<BTreeMap<String, f64>, Failure> {
    let data = published(paper).ok_or_else(|| format!("no paper {paper}"))?;
    let paper: Paper = serde_json::from_str(data)?;
    let found = paper.tables.iter().find(|known| known.name == table).ok_or_else(|| format!("no {table}"))?;
    let mut published = found.columns.iter().filter(|column| !column.ours);
    let at = published.position(|known| known.name == column).ok_or_else(|| format!("no column {column}"))?;
    let rows = found.rows.iter().filter(|row| !row.stand_in);
    Ok(rows.filter_map(|row| Some((row.file.clone()?, *row.published.get(at)?))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stand_ins_are_left_out() {
        let strips = column(ETA_2006, "table 3", "strips").unwrap();
        let models: Vec<&str> = strips.keys().map(String::as_str).collect();
        assert_eq!(models, ["bunny", "cessna", "dragon", "fandisk", "goblet", "horse"]);
        assert_eq!(strips.get("dragon"), Some(&477.0));
        assert!(
            column(ETA_2006, "table 9", "strips").is_err() && column(ETA_2006, "table 3", "best").is_err()
        );
    }
}
