//! Reads and writes the mesh files that tristrip works on.
//!
//! | format | read | written |
//! |---|---|---|
//! | OBJ | polygons, groups, materials, seams | faces |
//! | PLY | ascii, little and big endian, polygons, `tristrips` | faces, `tristrips` |
//! | OFF | polygons | – |
//! | STL | ascii, binary; welded | – |
//! | glTF 2.0, GLB | all triangle modes, sparse accessors, restart | GLB, the scene kept |
#![forbid(unsafe_code)]

pub mod error;
pub mod gltf;
pub mod model;

pub use error::Error;
pub use model::{Drawing, Model, Part};
