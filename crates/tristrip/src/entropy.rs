//! Entropy coding: a range coder and adaptive models that learn probabilities while coding.
//!
//! ```text
//! numbers ─▶ slots  ─┐
//!            scores ─┴▶ range coder ─▶ bytes
//! ```
//! `slots` learns the probability of each decision. `scores` learns the probabilities of choices
//! from their features. `numbers` codes integers as sequences of decisions. Encoder and decoder run
//! the same code over a `BitCoder`. All state is integer, so decoders in other languages produce
//! the same result. `docs/formats/progressive-glb.md` defines the bytes.

pub(crate) mod numbers;
pub(crate) mod range_coder;
pub(crate) mod scores;
pub(crate) mod slots;
