//! Levels of detail: ready-to-draw strips at every level of a
//! [`CollapseSequence`](crate::CollapseSequence).
//!
//! A collapse renames vertices, and the strips can be renamed in the same way. Strips are therefore
//! built once, for the full mesh. Every other level uses the same strips with some vertices
//! renamed, and a [`Filter`] removes the degenerate triangles.
//!
//! ```text
//! Strips of the full mesh ─ renamed for a level ─▶ simplified strips ─ filter ─▶ display strips
//! ```
//! Complete example:
//!
//! ```
//! use std::sync::Arc;
//! use tristrip::lod::{Encoding, LevelCursor, ProgressiveStrips};
//! use tristrip::simplify::{SimplifyOptions, simplify_triangles};
//! use tristrip::{Faces, Mesh, Strips, stripify};
//! // A flat grid of 8 × 8 quadrilaterals.
//! let quad = |i: u32| [i, i + 1, i + 10, i + 9];
//! let faces = Faces::from_polygons((0..8).flat_map(|y| (0..8).map(move |x| quad(9 * y + x))))?;
//! let mesh = Mesh::new((0..81).map(|i| [(i % 9) as f32, (i / 9) as f32, 0.0]).collect::<Vec<_>>(), faces)?;
//! let strips = stripify(&mesh, &tristrip::StripifyOptions::default())?;
//! let sequence = simplify_triangles(&mesh, strips.to_list(), &SimplifyOptions::default())?.sequence;
//!
//! let model = Arc::new(ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?);
//! let mut cursor = model.cursor();
//! let mut buffer: Vec<u16> = Vec::new();
//! for triangles in [2, 20, 100] {
//!     cursor.set_level(sequence.level_of_triangles(triangles))?;
//!     assert_eq!(cursor.strips().triangles().count(), cursor.levels().triangle_count(cursor.level())?);
//!     // Only these ranges of the buffer must be uploaded to the GPU.
//!     let changed = cursor.strips().update_indices(tristrip::Layout::Restart, &mut buffer)?;
//!     assert!(!changed.is_empty());
//! }
//! # Ok::<(), tristrip::Error>(())
//! ```

mod blocks;
mod filter;
mod level;
mod model_kind;
mod progressive;
mod repair;
#[cfg(test)]
pub(crate) mod samples;
mod sets;
mod skip;

pub use blocks::{BlockOptions, Blocks, BlocksCursor};
pub use filter::{DrawCost, Filter, FilterCosts};
pub use level::geomorph::{Geomorph, Transit};
pub use level::hysteresis::Hysteresis;
pub use level::index_map::RESTART;
pub use level::level_model::{LevelCursor, LevelModel};
pub use level::level_table::LevelTable;
pub use level::view::View;
pub use model_kind::ModelKind;
pub use progressive::{
    Encoding, ProgressiveMesh, ProgressiveMeshCursor, ProgressiveStrips, ProgressiveStripsCursor, SlotUpdate,
    VertexSplit, decode_entries, encoded_offset,
};
pub use repair::{Repair, RepairOptions, RepairedStrips};
pub(crate) use repair::{RepairedPaths, walk_steps};
pub use sets::Sets;
pub use skip::{
    Camera, Foveation, RepairedView, SkipLevelCursor, SkipStrips, SkipView, ViewCriteria, ViewGeomorphs,
    ViewSnapshot, ViewUpdate,
};

/// Internals that the level models based on strip graphs share. They are exported for the baselines
/// in `tristrip-lab` and may change in any version.
#[doc(hidden)]
pub mod strip_graphs {
    pub use crate::csr::Csr;
    pub use crate::lod::sets::multiresolution::{
        Accesses, Graph, ListBuilder, RecoveredStrips, StripGraphs, SuccessorLists,
    };
    pub use crate::lod::sets::shortened::{NONE, SlotEdit, edits_of};
    pub use crate::lod::sets::strip_graph::StripGraph;
    pub use crate::lod::sets::strip_states::StripState;
    pub use crate::packed::{Packed, PackedRow, bits_for};
}
