//! Levels of detail: the strips of the full mesh, render-ready at every level of a [`CollapseSequence`](crate::CollapseSequence).

pub mod filter;
