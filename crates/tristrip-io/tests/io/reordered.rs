//! Compares models with reordered vertices with their orders, and files with their sources.
#![allow(dead_code, reason = "each test file uses a part of it")]

use tristrip::verify::verify_models;
use tristrip::{Layout, Mesh, Strips};
use tristrip_io::{Drawing, Format, Model, Part, Reordered, read, reorder, write};

use crate::gltf_documents::greedy;

pub(crate) fn strips_of(model: &Model) -> Vec<Strips> {
    let of = |part: &Part| {
        let list = part.mesh.faces().iter().flat_map(|face| {
            let fan = |i: usize| [face[0], face[i - 1], face[i]];
            (2..face.len()).map(fan).collect::<Vec<_>>()
        });
        greedy(&list.filter(|t| t[0] != t[1] && t[1] != t[2] && t[0] != t[2]).collect::<Vec<_>>())
    };
    model.parts.iter().map(of).collect()
}

pub(crate) fn meshes(model: &Model) -> Vec<&Mesh> {
    model.parts.iter().map(|part| &part.mesh).collect()
}

pub(crate) fn drawn(strips: &[Strips]) -> Vec<Drawing<'_>> {
    strips.iter().map(Drawing::Strips).collect()
}

/// Checks that the first uses in a list of indices are `next`, `next` + 1 and so on. Returns the
/// first unused index.
pub(crate) fn check_first_uses(indices: impl IntoIterator<Item = u32>, mut next: u32) -> u32 {
    for index in indices {
        assert!(index <= next, "{index} comes before {next}");
        next = next.max(index + 1);
    }
    next
}

/// Reorders a model for a format. Checks the result against its orders, and the file against its
/// source.
pub(crate) fn check(model: &Model, format: Format, layout: Layout) -> (Reordered, Vec<u8>) {
    let strips = strips_of(model);
    let reordered = reorder(model, &drawn(&strips), format, layout).unwrap();
    let bytes = write(&reordered.model, &reordered.drawings(), format, reordered.layout).unwrap();
    // Each part is in exactly one group, and its vertices are the old ones in the group's order.
    let mut parts: Vec<usize> = reordered.groups.iter().flat_map(|group| group.parts.clone()).collect();
    parts.sort_unstable();
    assert_eq!(parts, (0..model.parts.len()).collect::<Vec<_>>());
    for group in &reordered.groups {
        assert!(group.order.check());
        assert!(group.kept.is_none() || group.order.moved_count() == 0);
        let mut next = 0;
        for &part in &group.parts {
            let (old, new) = (&model.parts[part].mesh, &reordered.model.parts[part].mesh);
            assert_eq!(group.order.mesh(old).unwrap(), *new);
            let strips = reordered.strips[part].as_ref().unwrap();
            if group.kept.is_none() {
                let listed =
                    if layout == Layout::List { strips.to_list() } else { strips.vertices().to_vec() };
                next = check_first_uses(listed, next);
            }
        }
    }
    let back = read(&bytes, format).unwrap();
    assert!(verify_models(&meshes(model), &meshes(&back)).unwrap().is_ok());
    (reordered, bytes)
}
