//! The levels of a chain with the keys of the JSON report.

use serde::Serialize;

use super::{Chain, ChainLevel};

/// A level.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LevelReport {
    /// The number of the level; 0 is the finest.
    pub level: usize,
    /// What was reached.
    #[serde(flatten)]
    pub figures: ChainLevel,
    /// The size of the level's file, or of the indices and vertices that it uses of a file with all levels.
    pub bytes: Option<usize>,
    /// The file of the level; `None` where one file has all levels.
    pub output: Option<String>,
}

impl Chain {
    /// Reports the levels, which are in no file yet.
    pub fn level_reports(&self) -> Vec<LevelReport> {
        let report = |(level, &figures): (usize, &ChainLevel)| LevelReport {
            level,
            figures,
            bytes: None,
            output: None,
        };
        self.levels.iter().enumerate().map(report).collect()
    }
}
