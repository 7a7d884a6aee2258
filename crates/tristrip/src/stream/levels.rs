//! A mesh of a stream as a level model: the levels that have arrived so far.
//!
//! The strips of the levels are those of [`RepairedStrips`]: a cursor starts with the strips of the mesh so far, and repairs them as it moves. The model is
//! built when it is first asked for after a chunk.

use std::sync::Arc;

use super::part::StreamPart;
use super::strips::KeptStrips;
use crate::collapse::CollapseSequence;
use crate::lod::{LevelCursor, LevelModel, LevelTable, RepairOptions, RepairedStrips};

impl StreamPart {
    /// Builds the model of the levels so far. Splits that are none of collapses, which no encoder writes, leave one level.
    fn build_model(&self) -> Arc<RepairedStrips> {
        let strips = self.strips().unwrap_or_else(|| self.emit(&KeptStrips::new(self.surface())));
        let sequence = self.sequence().or_else(|_| self.one_level());
        let model =
            sequence.and_then(|sequence| RepairedStrips::new(sequence, strips, RepairOptions::default()));
        // A mesh with more triangles than a model may have does not fit into the table of its corners either.
        Arc::new(model.unwrap_or_default())
    }

    fn one_level(&self) -> Result<CollapseSequence, crate::Error> {
        CollapseSequence::from_collapses(self.vertex_count(), self.triangles(), [])
    }

    fn model(&self) -> &Arc<RepairedStrips> {
        self.model.get_or_init(|| self.build_model())
    }
}

/// The levels that have arrived so far. More come with each chunk: cursors that were started before do not see them.
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

    /// The triangles and vertices of the mesh so far, its strips and the model of its levels. What the decoder learns of the stream is not counted.
    fn memory(&self) -> usize {
        self.mesh_bytes() + LevelModel::memory(&**self.model())
    }

    fn start(self: Arc<Self>) -> Box<dyn LevelCursor> {
        Arc::clone(self.model()).start()
    }
}
