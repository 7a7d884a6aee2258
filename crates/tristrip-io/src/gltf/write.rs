//! Builds the GLB of a model: a scene with new indices (`keep`), or a minimal document (`build`).

pub(in crate::gltf) mod build;
pub(in crate::gltf) mod index;
pub(in crate::gltf) mod keep;
mod material_builder;
pub(in crate::gltf) mod separate;
