//! Hostile and regular shapes. They expose searches and data structures whose cost per triangle is
//! not bounded: it may depend on the length of strips, the faces per vertex or edge, the corners
//! per polygon, or the order of the faces.
//!
//! ```text
//! ribbons, fans, bipyramids, tori, Klein bottles   one long path, or many of equal length;
//!                                                  no irregular place to start a search
//! polygons of 100,000 corners, stars, pillows      one face is the mesh
//! books, walls, twins, duplicates                  edges of many faces
//! isolated triangles, trees, combs                 many components, many ends
//! ```
//! Every shape is a function of the approximate number of triangles, which allows measuring growth.
//! Random shapes have a fixed seed.

mod crowded;
mod draft;
mod polygons;
mod run;
mod scattered;
mod surfaces;

pub use draft::{Draft, Order};
pub use run::{HostileMethod, HostileRun, METHODS};

use tristrip::Mesh;

use crate::failure::Failure;

/// A shape with a variable number of triangles.
#[derive(Debug, Clone, Copy)]
pub struct HostileShape {
    /// Its name.
    pub name: &'static str,
    draft: fn(u32) -> Draft,
}

impl HostileShape {
    /// Builds the shape with about this number of triangles.
    ///
    /// # Errors
    /// The shape has too many corners for 32-bit ids.
    pub fn mesh(&self, triangles: u32) -> Result<Mesh, Failure> {
        Ok((self.draft)(triangles).into_mesh()?)
    }
}

/// Returns all shapes.
pub fn shapes() -> Vec<HostileShape> {
    let families =
        [surfaces::SHAPES, polygons::SHAPES, crowded::SHAPES, scattered::SHAPES].into_iter().flatten();
    families.map(|&(name, draft)| HostileShape { name, draft }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn there_are_sixty_shapes_of_the_requested_size() {
        let all = shapes();
        assert!(all.len() >= 60, "{}", all.len());
        assert_eq!(all.iter().map(|shape| shape.name).collect::<HashSet<_>>().len(), all.len());
        for shape in all {
            let triangles = shape.mesh(10_000).unwrap().faces().triangle_count();
            assert!((8_000..=12_500).contains(&triangles), "{}: {triangles} triangles", shape.name);
        }
    }

    #[test]
    fn every_method_proves_every_shape() {
        for shape in shapes() {
            let mesh = shape.mesh(400).unwrap();
            for method in METHODS {
                method.run(&mesh).unwrap_or_else(|error| panic!("{}, {}: {error}", shape.name, method.name));
            }
        }
    }
}
