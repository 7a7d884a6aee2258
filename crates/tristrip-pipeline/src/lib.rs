//! What happens to a whole model, from the parts that a reader returned to the bytes that a writer stores: strips, simplification,
//! levels of detail, bounds, analysis and conversion, each with its proof.
//!
//! ```text
//! Model ─▶ PreparedModel ─▶ strips of each part ─ proof ─▶ encode ─ read back, proof ─▶ bytes
//!   │            └▶ bounds, figures of the mesh     │
//!   ├▶ chain: collapses ─ levels asked for, vertices in the order of removal ─▶ one scene, or a file per level, proven
//!   ├▶ simplify: parts that share borders together ─▶ smaller model
//!   └▶ levels: strips ─ collapses of all parts in one order ─▶ display strips of any level, proven
//! ```
//! The functions take a model in memory and return owned results. Except for `Target`, which exists under the feature `fs`, they read no files, no clock and no terminal: an [`Observer`] learns
//! of every stage, may measure its time, and may stop a search or cancel. All parts are processed in parallel, on the threads of the
//! current `rayon` pool; the results are the same for any number of threads.
//!
//! ```
//! use tristrip_io::{Format, read};
//! use tristrip_pipeline::{EncodeOptions, StripOptions, strip};
//! let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
//! let stripped = strip(&model, &StripOptions::default())?;
//! assert_eq!((stripped.figures.strips, stripped.figures.indices_restart, stripped.proven), (1, 4, true));
//! let encoded = stripped.encode(&model, &EncodeOptions::new(Format::Glb))?;
//! assert!(encoded.bytes.starts_with(b"glTF"));
//! # Ok::<(), tristrip_pipeline::Error>(())
//! ```

#![forbid(unsafe_code)]

mod analyze;
mod bound;
mod bounds;
mod chain;
mod collapses;
mod convert;
mod drawing;
mod encode;
mod error;
mod figures;
#[cfg(feature = "fs")]
mod files;
mod goal;
mod join;
mod levels;
mod method;
mod observer;
mod pack;
mod parts;
mod places;
mod prepared;
mod simplify;
mod stream;
mod strip;
mod surface_change;
pub mod text;
mod unpack;
mod verify;
mod view_model;

pub use analyze::{
    Analysis, AnalyzeOptions, DrawMode, LengthBin, PartAnalysis, PartReport, StoredFigures, StripLengths,
    VertexCacheList, VertexCacheReport, analyze,
};
pub use bound::{Bounded, ComponentReport, PartBound, bound, bound_observed};
pub use bounds::{BoundGap, Bounds};
pub use chain::{
    Chain, ChainLevel, ChainOptions, ChainRatios, EncodedChain, LevelReport, chain, chain_observed,
};
pub use collapses::Collapses;
pub use convert::{ConvertOptions, Converted, convert, convert_observed, strips_as_stored};
pub use drawing::{DrawCost, Drawn, DrawnAs, DrawnParts, FileFigures};
pub use encode::{EncodeOptions, Encoded, default_layout, encode, encode_observed};
pub use error::Error;
pub use figures::{Figures, MeshFigures, rounded};
#[cfg(feature = "fs")]
pub use files::{Target, WRITTEN_FORMATS, WrittenFiles, format_to_write, layout_to_write, path_of_level};
pub use goal::{Amount, Deviation, Goal, Ratio};
pub use join::{Joined, join};
pub use levels::{
    DisplayFilter, DisplayedLevel, DisplayedView, Level, LevelGoal, LevelPart, LevelsOptions, ModelCursor,
    ModelLevels, levels, levels_observed,
};
pub use method::{
    MethodReport, MethodRow, compared_methods, method_help, methods_to_compare, parse_method,
    with_method_parameter,
};
pub use observer::{Event, Observer, Search, SimplifyProgress, Stage, Stopped};
pub use pack::{PackOptions, Packed, PackedReport, pack};
pub use parts::{PreparedPart, meshes};
pub use prepared::{PreparedModel, Survey};
pub use simplify::{
    CollapseRules, LevelOrder, NormalCounts, Normals, Simplified, SimplifyFigures, SimplifyOptions,
    StoppedReport, simplify, simplify_observed, simplify_parts,
};
pub use stream::{StreamedMesh, stream_of_mesh};
pub use strip::{StripOptions, Stripped, strip, strip_observed, with_strips};
pub use surface_change::{ChangedSurface, SurfaceChange, surface_change};
pub use unpack::{
    ChunkFigures, ComponentBits, StreamFigures, StreamGoal, StreamReport, Unpacked, UnpackedReport,
    stream_figures, unpack,
};
pub use verify::{DifferenceReport, verify};
pub use view_model::{
    EncodedViewModel, ViewModel, ViewModelOptions, ViewModelReport, prove_view, view_model,
};
