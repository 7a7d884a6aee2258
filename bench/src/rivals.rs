//! `meshoptimizer` in the same run, by its Rust crate: the strips of three pipelines, as strips that can be proven and priced.
//!
//! # References
//! Arseny Kapoulkine: *meshoptimizer*, <https://github.com/zeux/meshoptimizer>; the crate `meshopt`.

use tristrip::{Mesh, Strips};

use crate::Failure;

const RESTART: u32 = u32::MAX;

/// What goes before meshoptimizer's strips.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pipeline {
    /// Strips of the index buffer as it is.
    Alone,
    /// The order for the vertex cache first.
    Cache,
    /// The order for the vertex cache that favours strips: the reference for time ratios.
    StripCache,
}

impl Pipeline {
    /// Every pipeline; the reference comes last.
    pub const ALL: [Self; 3] = [Self::Alone, Self::Cache, Self::StripCache];

    /// Gives the name that tables show.
    pub fn name(self) -> &'static str {
        match self {
            Self::Alone => "meshopt stripify",
            Self::Cache => "meshopt cache, stripify",
            Self::StripCache => "meshopt strip cache, stripify",
        }
    }

    /// Runs the pipeline from index buffer to index buffer: what is timed.
    ///
    /// # Errors
    /// The mesh has faces that are no triangles, or the crate reports an error.
    pub fn run(self, mesh: &Mesh) -> Result<Vec<u32>, Failure> {
        let indices = mesh.faces().as_triangles().ok_or("meshoptimizer takes triangles")?;
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

/// Parts an index buffer at its restarts.
pub fn strips_of(indices: &[u32]) -> Strips {
    let mut strips = Strips::default();
    indices.split(|&index| index == RESTART).filter(|strip| strip.len() >= 3).for_each(|s| strips.push(s));
    strips
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn restarts_part_strips() {
        let strips = strips_of(&[0, 1, 2, 3, RESTART, 4, 5, 6]);
        assert_eq!(strips.iter().collect::<Vec<_>>(), [&[0, 1, 2, 3][..], &[4, 5, 6]]);
    }
}
