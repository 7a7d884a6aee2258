//! What the benchmarks and the corpus checks share: models as the peers had them, methods by name, peers in the same run, the
//! memory and the time of a call, and the bars that the project holds itself to.
//!
//! ```text
//! models ─▶ measure ─▶ Outcome ─┬─▶ text (tables to read)
//!  methods ─▶ │                 ├─▶ docs (tables to keep)
//!  rivals ──▶ │ proof, then     └─▶ bars ─▶ met or not
//!  memory ──▶ │ times
//!          searches ─▶ Searched: the same of long searches, with bounds and what was published
//!          buffers ──▶ Buffered: indices and misses of a vertex buffer, ours and meshoptimizer's
//! ```
//!
//! No time is shown of an answer that was not proven before.

#![deny(unsafe_code)]

pub mod bars;
pub mod buffers;
pub mod corpus;
pub mod docs;
pub mod levels;
pub mod measure;
pub mod memory;
pub mod methods;
pub mod models;
pub mod papers;
pub mod peers;
pub mod rivals;
pub mod scaling;
pub mod searches;
pub mod text;

/// Anything that stops a benchmark, with what it was about.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;
