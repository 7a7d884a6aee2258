//! Shared code of the benchmarks and the corpus checks: models as the peers read them, methods by
//! name, meshoptimizer in the same run, the memory and time of a call, and the targets of the
//! project.
//!
//! ```text
//! models ─▶ measure ─▶ Outcome ─┬─▶ text (tables on the terminal)
//!  methods ─▶ │                 ├─▶ docs (generated pages)
//!  meshoptimizer ▶ proof, then  └─▶ targets ─▶ met or not
//!  memory ──▶ │ times
//!          searches ─▶ SearchResults: long searches, with bounds and published values
//!          vertex_caches ─▶ CacheResults: indices and misses, ours and meshoptimizer's
//! ```
//!
//! A time is shown only for a result that was proven first.

#![deny(unsafe_code)]

pub mod corpus;
pub mod distance;
pub mod docs;
pub mod failure;
pub mod hostile;
pub mod levels;
pub mod measure;
pub mod memory;
pub mod meshoptimizer;
pub mod methods;
pub mod models;
pub mod papers;
pub mod peers;
pub mod scaling;
pub mod scenes;
pub mod searches;
pub mod strip_links;
pub mod targets;
pub mod text;
pub mod vertex_caches;
