//! meshoptimizer: simplifies the whole model in each frame to the number of triangles of the view,
//! as strips or as a cache-ordered list.
//!
//! # References
//! Arseny Kapoulkine: *meshoptimizer*, <https://github.com/zeux/meshoptimizer>; the crate
//! `meshopt`.

use meshopt::{SimplifyOptions, VertexDataAdapter};
use tristrip::{Mesh, Strips};
use tristrip_bench::failure::Failure;
use tristrip_bench::meshoptimizer::{adapter, strips_of};

use super::alternative::{Alternative, Drawn};

use crate::frames::Frame;
use crate::proof::sorted;

/// The step after the simplification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// Strip-friendly vertex-cache order, then strips.
    Strips,
    /// Vertex-cache order, as a list.
    Cache,
}

pub(super) struct SimplifyAlternative<'a> {
    mesh: &'a Mesh,
    indices: &'a [u32],
    vertices: VertexDataAdapter<'a>,
    order: Order,
    list: Vec<u32>,
    strips: Strips,
    error: f32,
}

impl<'a> SimplifyAlternative<'a> {
    pub(super) fn new(mesh: &'a Mesh, order: Order) -> Result<Self, Failure> {
        let indices = mesh.faces().as_triangles().ok_or("meshoptimizer accepts only triangles")?;
        let vertices = adapter(mesh.positions())?;
        Ok(Self { mesh, indices, vertices, order, list: Vec::new(), strips: Strips::default(), error: 0.0 })
    }
}

impl Alternative for SimplifyAlternative<'_> {
    fn name(&self) -> &'static str {
        match self.order {
            Order::Strips => "meshopt simplify, stripify",
            Order::Cache => "meshopt simplify, cache order",
        }
    }

    fn surface(&self) -> &'static str {
        "simplified"
    }

    fn follow(&mut self, _frame: &Frame) -> Result<(), Failure> {
        Ok(())
    }

    fn finish(&mut self, frame: &Frame) -> Result<(), Failure> {
        let count = self.mesh.vertex_count();
        let simple = meshopt::simplify(
            self.indices,
            &self.vertices,
            3 * frame.triangle_count,
            f32::MAX,
            SimplifyOptions::ErrorAbsolute,
            Some(&mut self.error),
        );
        match self.order {
            Order::Strips => {
                self.list = meshopt::optimize_vertex_cache_strip(&simple, count);
                self.strips = strips_of(&meshopt::stripify(&self.list, count, u32::MAX)?);
            }
            Order::Cache => self.list = meshopt::optimize_vertex_cache(&simple, count),
        }
        Ok(())
    }

    fn drawn(&mut self, frame: &Frame) -> Result<Drawn, Failure> {
        let pixels = frame.pixels_at_nearest(self.error.into());
        let (triangles, _) = self.list.as_chunks::<3>();
        if self.order == Order::Cache {
            return Ok(Drawn::of_list(triangles.to_vec(), pixels));
        }
        if sorted(self.strips.triangles()) != sorted(triangles.iter().copied()) {
            return Err("strips of meshoptimizer draw other triangles than its simplified list".into());
        }
        Ok(Drawn::of_strips(&self.strips, pixels))
    }

    fn bytes(&self) -> [usize; 2] {
        let drawn = match self.order {
            Order::Strips => self.strips.vertices_sent() + self.strips.len(),
            Order::Cache => self.list.len(),
        };
        [size_of_val(self.indices), drawn * size_of::<u32>()]
    }
}
