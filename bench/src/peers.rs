//! Results of other programs on the same models. They were measured once and are stored in a file
//! next to the checkout.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// The best peer by one metric.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PeerBest {
    /// The value, rounded to four digits.
    pub best: f64,
    /// The program with that value.
    pub by: String,
}

/// The best peers on one model.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Peers {
    /// The number of triangles of the index buffer.
    pub triangles: usize,
    /// Over all peers, including slow ones.
    pub indices_restart_per_triangle: PeerBest,
    /// Over all peers, including slow ones.
    pub indices_degenerate_per_triangle: PeerBest,
    /// Over all peers, including slow ones.
    pub vertices_per_triangle: PeerBest,
    /// Over all peers, including slow ones.
    pub strips: PeerBest,
    /// Over the peers that make one pass over the mesh.
    pub one_pass_indices_restart_per_triangle: PeerBest,
    /// The result of meshoptimizer, which shows whether the index buffer is the same.
    pub meshopt_strip_cache: ReferenceStrips,
}

/// The result of the reference pipeline.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ReferenceStrips {
    /// Strips.
    pub strips: usize,
}

/// Reads the results of the peers by model; empty if the file does not exist.
///
/// # Errors
/// The file exists but cannot be read.
pub fn load() -> Result<BTreeMap<String, Peers>, Failure> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/peers.json");
    if !path.is_file() {
        return Ok(BTreeMap::new());
    }
    Ok(serde_json::from_slice(&fs::read(path)?)?)
}
