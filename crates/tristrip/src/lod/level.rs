//! Levels: the traits of models and cursors, the table of triangle counts and errors, the choice of
//! a level for a view, and geomorphs between levels.

pub(crate) mod geomorph;
pub(crate) mod hysteresis;
pub(crate) mod index_map;
pub(crate) mod level_mesh;
pub(crate) mod level_model;
pub(crate) mod level_table;
pub(crate) mod replay;
pub(crate) mod vertex_ranges;
pub(crate) mod view;
