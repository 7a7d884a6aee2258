//! The order of collapses: passes, queues, limits, the levels of a merge tree, and several meshes
//! simplified as one.

pub(crate) mod ahead;
pub(crate) mod collapse_order;
pub(crate) mod decimate;
pub(crate) mod joined;
pub(crate) mod merge_tree;
pub(crate) mod queue;
pub(crate) mod stopped;
