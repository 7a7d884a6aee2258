//! Levels of detail as bytes: the base mesh first, then what leads from each level to the next, so that every prefix can be drawn.
//!
//! ```text
//! (Strips, CollapseSequence, positions) ─ encode ─▶ bytes ─ a network, in pieces ─▶ decoder ─▶ display strips of every level that has arrived
//! ```

pub mod paper;
