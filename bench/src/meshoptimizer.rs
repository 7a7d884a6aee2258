//! `meshoptimizer` in the same run, through its Rust crate: three pipelines whose strips are proven
//! and measured.
//!
//! # References
//! Arseny Kapoulkine: *meshoptimizer*, <https://github.com/zeux/meshoptimizer>; the crate
//! `meshopt`.

use meshopt::VertexDataAdapter;
use tristrip::{Mesh, Strips};

use crate::failure::Failure;

const RESTART: u32 = u32::MAX;

/// The step before meshoptimizer's stripification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pipeline {
    /// None: the index buffer in its own order.
    Alone,
    /// Vertex-cache order.
    Cache,
    /// Strip-friendly vertex-cache order: the reference for time ratios.
    StripCache,
}

impl Pipeline {
    /// All pipelines. The reference is the last one.
    pub const ALL: [Self; 3] = [Self::Alone, Self::Cache, Self::StripCache];

    /// Returns the name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Alone => "meshopt stripify",
            Self::Cache => "meshopt cache, stripify",
            Self::StripCache => "meshopt strip cache, stripify",
        }
    }

    /// Runs the pipeline from index buffer to index buffer. This call is timed.
    ///
    /// # Errors
    /// The mesh has faces other than triangles, or the crate reports an error.
    pub fn run(self, mesh: &Mesh) -> Result<Vec<u32>, Failure> {
        let indices = mesh.faces().as_triangles().ok_or("meshoptimizer accepts only triangles")?;
        let count = mesh.vertex_count();
        Ok(match self {
            Self::Alone => meshopt::stripify(indices, count, RESTART)?,
            Self::Cache => {
                meshopt::stripify(&meshopt::optimize_vertex_cache(indices, count), count, RESTART)?
            }
            Self::StripCache => {
                meshopt::stripify(&meshopt::optimize_vertex_cache_strip(indices, count), count, RESTART)?
            }
        })
    }
}

/// Returns positions in meshoptimizer's format.
///
/// # Errors
/// The crate reports an error.
pub fn adapter(positions: &[[f32; 3]]) -> Result<VertexDataAdapter<'_>, Failure> {
    Ok(VertexDataAdapter::new(meshopt::typed_to_bytes(positions), size_of::<[f32; 3]>(), 0)?)
}

/// Returns the strips between the restarts of an index buffer.
pub fn strips_of(indices: &[u32]) -> Strips {
    let mut strips = Strips::default();
    indices.split(|&index| index == RESTART).filter(|strip| strip.len() >= 3).for_each(|s| strips.push(s));
    strips
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_read_as_they_are() {
        let positions = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        let mut adapter = adapter(&positions).unwrap();
        assert_eq!((adapter.vertex_count, adapter.xyz_f32_at(1).unwrap()), (2, positions[1]));
    }

    #[test]
    fn restarts_separate_strips() {
        let strips = strips_of(&[0, 1, 2, 3, RESTART, 4, 5, 6]);
        assert_eq!(strips.iter().collect::<Vec<_>>(), [&[0, 1, 2, 3][..], &[4, 5, 6]]);
    }
}
