//! A mesh of a stream as a level model over the levels decoded so far.
//!
//! [`RepairedStrips`] provides the strips: a cursor starts with the strips of the current mesh and
//! repairs them as it moves. The model is built on first use after a chunk.

use std::sync::Arc;

use super::part::StreamPart;
use super::strips::KeptStrips;
use crate::collapse::CollapseSequence;
use crate::lod::{LevelCursor, LevelModel, LevelTable, RepairOptions, RepairedStrips};

impl StreamPart {
    /// Builds the model of the levels decoded so far. If the splits are not the inverse of valid
    /// collapses, which no encoder writes, the model has a single level.
    fn build_model(&self) -> Arc<RepairedStrips> {
        let strips = self.strips().unwrap_or_else(|| self.emit(&KeptStrips::new(self.surface())));
        let sequence = self.sequence().or_else(|_| self.one_level());
        let model =
            sequence.and_then(|sequence| RepairedStrips::new(sequence, strips, RepairOptions::default()));
        // A mesh with too many triangles for a model does not fit into the table of its corners
        // either.
        Arc::new(model.unwrap_or_default())
    }

    fn one_level(&self) -> Result<CollapseSequence, crate::Error> {
        CollapseSequence::from_collapses(self.vertex_count(), self.triangles(), [])
    }

    fn model(&self) -> &Arc<RepairedStrips> {
        self.model.get_or_init(|| self.build_model())
    }
}

/// The levels decoded so far. Each chunk adds levels. Existing cursors do not include these levels.
///
/// ```
#[doc = include_str!("example.txt")]
/// use std::sync::Arc;
/// use tristrip::lod::LevelModel;
/// use tristrip::stream::{Decoder, StreamLimits};
/// let mut decoder = Decoder::new(StreamLimits::default()).keeping_strips();
/// decoder.update(&stream.bytes())?;
/// let part = Arc::new(decoder.part(0).ok_or("no base mesh")?.clone());
/// let mut cursor = part.start();
/// cursor.set_triangles(30)?;
/// assert!(cursor.strips().triangles().count() <= 30);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
impl LevelModel for StreamPart {
    fn levels(&self) -> &LevelTable {
        self.model().levels()
    }

    /// Returns the bytes of the triangles and vertices decoded so far, their strips and the level
    /// model. The adaptive state of the decoder is not counted.
    fn memory(&self) -> usize {
        self.mesh_bytes() + LevelModel::memory(&**self.model())
    }

    fn start(self: Arc<Self>) -> Box<dyn LevelCursor> {
        Arc::clone(self.model()).start()
    }
}
