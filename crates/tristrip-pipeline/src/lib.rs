//! Whole-model operations: strips, simplification, level-of-detail chains, progressive streams,
//! lower bounds, analysis and conversion. Results are verified unless an option disables it.
//!
//! ```text
//! Model ─▶ PreparedModel ─▶ strips of each part ─ proof ─▶ encode ─ read back, proof ─▶ bytes
//!   │            └▶ bounds, metrics of the mesh     │
//!   ├▶ chain: collapses ─ levels, vertices in removal order ─▶ one scene, or a file per level
//!   ├▶ simplify: collapses, across borders between parts ─▶ smaller model
//!   └▶ levels: strips ─ collapses of all parts in one order ─▶ display strips of any level, proven
//! ```
//! The functions take a model in memory and return owned results. They do not access the clock or
//! the terminal. Only `Target`, and [`unpack`] with a base directory, access files; both need the
//! feature `fs`. An [`Observer`] is notified of every stage: it can measure time, stop a search, or
//! cancel. All parts are processed in parallel in the current `rayon` pool. Results are the same
//! for any number of threads.
//!
//! ```
//! use tristrip_io::{Format, read};
//! use tristrip_pipeline::{encode, strip};
//! let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
//! let stripped = strip::run(&model, &strip::Options::default(), &())?;
//! assert_eq!((stripped.metrics.strips, stripped.metrics.indices_restart, stripped.proven), (1, 4, true));
//! let file = stripped.encode(&model, &encode::Options::new(Format::Glb), &())?;
//! assert!(file.encoded.bytes.starts_with(b"glTF"));
//! # Ok::<(), tristrip_pipeline::Error>(())
//! ```

#![forbid(unsafe_code)]

pub mod analyze;
pub mod bound;
mod bounds;
pub mod chain;
mod collapses;
pub mod compare;
pub mod convert;
mod drawing;
pub mod encode;
mod error;
mod figures;
#[cfg(feature = "fs")]
mod files;
mod goal;
pub mod inspect;
mod join;
pub mod levels;
mod method;
mod metrics;
mod observer;
pub mod pack;
mod parts;
mod places;
mod prepared;
pub mod simplify;
mod stream;
pub mod strip;
mod surface_change;
pub mod text;
pub mod unpack;
pub mod verify;
pub mod view_model;

pub use bounds::{BoundGap, Bounds};
pub use collapses::{Collapses, KeptVertices};
pub use drawing::{Drawn, DrawnAs, DrawnParts, FileCost, IndexCost};
pub use error::{Error, UnprovenMetrics};
pub use figures::MeshProperties;
#[cfg(feature = "fs")]
pub use files::{Target, WRITTEN_FORMATS, WrittenFiles, format_to_write, layout_to_write, path_of_level};
pub use goal::{Amount, Deviation, Goal, Ratio};
pub use join::{Joined, join};
pub use method::{MethodDescription, method_help, parse_method, with_method_parameter};
pub use metrics::{StripMetrics, rounded};
pub use observer::{Observer, Search, SearchStop, SimplifyProgress, Stage};
pub use parts::{PreparedPart, meshes};
pub use prepared::PreparedModel;
pub use stream::{StreamedMesh, stream_of_mesh};
pub use surface_change::{ChangedSurface, SurfaceChange, surface_change};
