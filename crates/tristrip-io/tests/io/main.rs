//! Tests of formats and models, in one program because linking takes longer than the tests.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests fail by panicking")]

mod added_materials;
mod compressed;
mod doubling;
mod draco;
mod empty_models;
mod gltf_bad;
mod gltf_documents;
mod gltf_limits;
mod gltf_read;
mod gltf_text;
mod gltf_write;
mod hostile;
mod hostile_scenes;
mod images;
mod kept_scenes;
mod levels;
mod levels_of_detail;
mod limits;
mod malformed;
mod meshopt;
mod meshopt_errors;
mod models;
mod new_vertices;
mod pack;
mod random;
mod readers;
mod reorder;
mod reorder_scene;
mod reordered;
mod round_trip;
mod shrink;
mod shrunk;
mod tlod;
