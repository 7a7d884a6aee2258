//! What other programs reach on the same models, as measured once and kept in a file beside the checkout.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::Failure;

/// The best of all peers by one figure.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Best {
    /// The figure, rounded to four digits.
    pub best: f64,
    /// Who reaches it.
    pub by: String,
}

/// The best of all peers on one model.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Peers {
    /// Triangles of the index buffer.
    pub triangles: usize,
    /// Of all peers, also slow ones.
    pub indices_restart_per_triangle: Best,
    /// Of all peers, also slow ones.
    pub indices_degenerate_per_triangle: Best,
    /// Of all peers, also slow ones.
    pub vertices_per_triangle: Best,
    /// Of all peers, also slow ones.
    pub strips: Best,
    /// Of the peers that pass over the mesh once.
    pub one_pass_indices_restart_per_triangle: Best,
    /// What meshoptimizer gave there, which shows whether the index buffer is the same.
    pub meshopt_strip_cache: Reference,
}

/// The result of the reference pipeline.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Reference {
    /// Strips.
    pub strips: usize,
}

/// Reads the peers' figures by model; none where there is no such file.
///
/// # Errors
/// The file is there and cannot be read.
pub fn load() -> Result<BTreeMap<String, Peers>, Failure> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/peers.json");
    if !path.is_file() {
        return Ok(BTreeMap::new());
    }
    Ok(serde_json::from_slice(&fs::read(path)?)?)
}
