//! The kinds of level models, and how to build one by kind.

use std::sync::Arc;

use super::{BlockOptions, Blocks, Encoding, ProgressiveMesh, ProgressiveStrips, Sets, SkipStrips};
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::lod::level::level_model::LevelModel;
use crate::names::names;
use crate::strip::Strips;

/// A kind of level model: how levels are stored and replayed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum ModelKind {
    /// [`ProgressiveMesh`].
    ProgressiveMesh,
    /// [`ProgressiveStrips`] with [`Encoding::Naive`].
    Naive,
    /// [`ProgressiveStrips`] with [`Encoding::Offsets`].
    Progressive,
    /// [`Sets`].
    Sets,
    /// [`Blocks`] with [`BlockOptions::default`].
    #[default]
    Blocks,
    /// [`SkipStrips`]: a vertex tree over the strips of the full mesh. It also supports
    /// view-dependent detail.
    Skip,
}

names! {
    "tristrip::lod::ModelKind", ModelKind, "model",
    ProgressiveMesh => "progressive-mesh", "Triangle list with the corners that each collapse renames (Hoppe 1996)";
    Naive => "naive", "Progressive strips that store every vertex (Kim et al. 2005, section 3.2)";
    Progressive => "progressive", "Progressive strips that refer to nearby vertices by offsets (Kim et al. 2005)";
    Sets => "sets", "Successors of each strip vertex, sorted by level (Belmonte et al. 2006)";
    Blocks => "blocks", "Index buffers at key levels, with the slots that change between them (ours)";
    Skip => "skip", "Skip Strips: vertices drawn as their first active ancestor (El-Sana et al. 2000)";
}

impl ModelKind {
    /// Builds a model of this kind from strips of the full mesh.
    ///
    /// # Errors
    /// The strips do not match the sequence, or the collapses rename too many slots.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let sequence = Arc::new(sequence);
    /// for kind in ModelKind::ALL {
    ///     let mut cursor = kind.build(&strips, &sequence)?.start();
    ///     cursor.set_level(1)?;
    ///     assert_eq!(cursor.strips().triangles().count(), 2, "{kind}");
    /// }
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn build(
        self,
        strips: &Strips,
        sequence: &Arc<CollapseSequence>,
    ) -> Result<Arc<dyn LevelModel>, Error> {
        Ok(match self {
            Self::ProgressiveMesh => Arc::new(ProgressiveMesh::new(sequence)?),
            Self::Naive => Arc::new(ProgressiveStrips::new(strips, sequence, Encoding::Naive)?),
            Self::Progressive => Arc::new(ProgressiveStrips::new(strips, sequence, Encoding::Offsets)?),
            Self::Sets => Arc::new(Sets::new(strips, sequence)?),
            Self::Blocks => Arc::new(Blocks::new(strips, Arc::clone(sequence), &BlockOptions::default())?),
            Self::Skip => Arc::new(SkipStrips::of_levels(strips, sequence)?),
        })
    }
}
