//! Connected components of a model, and the components that one strip draws.

use std::collections::HashMap;

use tristrip::Strips;
use tristrip_pipeline::{PreparedModel, PreparedPart};

/// Counts the components of exactly two triangles.
pub(super) fn of_two_triangles(prepared: &PreparedModel<'_>) -> usize {
    let of_part = |part: &PreparedPart<'_>| {
        let (component, count) = part.graph.components();
        let mut sizes = vec![0_usize; count];
        for (face, component) in part.surface.faces().iter().zip(component) {
            sizes[component as usize] += face.len().saturating_sub(2);
        }
        sizes.into_iter().filter(|&size| size == 2).count()
    };
    prepared.parts().iter().map(of_part).sum()
}

/// Counts the components that one strip draws. Works only for parts of triangles; of duplicate
/// triangles, the last one counts.
pub(super) fn drawn_by_one_strip(prepared: &PreparedModel<'_>, strips: &[Strips]) -> usize {
    let of_part = |(part, strips): (&PreparedPart<'_>, &Strips)| {
        let (component, count) = part.graph.components();
        let sorted = |face: &[u32]| {
            let mut face = <[u32; 3]>::try_from(face).unwrap_or_default();
            face.sort_unstable();
            face
        };
        let faces = part.surface.faces().iter().map(sorted);
        let component_of: HashMap<[u32; 3], u32> = faces.zip(component).collect();
        let mut strips_of = vec![0_usize; count];
        for strip in strips.iter() {
            let first = tristrip::strip_triangles(strip).next().map(|triangle| sorted(&triangle));
            if let Some(&component) = first.and_then(|first| component_of.get(&first)) {
                strips_of[component as usize] += 1;
            }
        }
        strips_of.into_iter().filter(|&strips| strips == 1).count()
    };
    prepared.parts().iter().zip(strips).map(of_part).sum()
}
