//! Entropy coding: a range coder, and adaptive models that learn probabilities while coding.
//!
//! ```text
//! numbers ─▶ slots  ─┐
//!            scores ─┴▶ range coder ─▶ bytes
//! ```
//! `slots` learns the probability of each decision, `scores` those of choices from features, and `numbers` codes integers as
//! decisions. Encoder and decoder run the same code over a `BitCoder`. All state is integers, so decoders in other languages
//! agree with this one. `docs/formats/progressive-glb.md` defines the bytes.

pub(crate) mod numbers;
pub(crate) mod range_coder;
pub(crate) mod scores;
pub(crate) mod slots;
