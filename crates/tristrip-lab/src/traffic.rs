//! The traffic of levels of detail: the vertices that every filter sends at each level, and the
//! updates between levels.
//!
//! ```text
//! ModelLevels ─▶ TrafficModel ─▶ measure_levels: rows of chosen levels    ─▶ table, chart
//!                            └▶ totals: sums over all levels
//! ```

mod chart;
mod levels;
mod measure;
mod rows;
mod totals;
mod updates;

pub use chart::draw;
pub use levels::{
    BIN_COUNT, LevelTraffic, SplitTraffic, TrafficBin, TrafficTotals, VERTEX_BITS, gigabits, walk,
};
pub use measure::{as_text, measure_levels};
pub use rows::{FilterTotal, LevelRow, Refinement, SINGLE_TRIANGLES, VerticesSent};
pub use totals::{as_text as totals_as_text, totals};
pub use updates::TrafficModel;
