//! Which vertices are one point, and which of those are alike in all attributes.

use std::collections::HashMap;

use crate::mesh::{Mesh, SPARSE, vertex_bits};

const NONE: u32 = u32::MAX;

/// Gives for each vertex on a seam the first one of its point with the same attributes.
pub(super) fn alike(mesh: &Mesh, vertices: &[u32], points: &[u32], on_seam: &[bool]) -> HashMap<u32, u32> {
    let (mut alike, mut first) = (HashMap::new(), HashMap::new());
    let is_on_seam = |&(_, &p): &(&u32, &u32)| on_seam.get(p as usize) == Some(&true);
    for (&v, &p) in vertices.iter().zip(points).filter(is_on_seam) {
        alike.entry(v).or_insert_with(|| {
            let mut attributes = vertex_bits(mesh, v as usize);
            attributes.drain(..size_of::<[f32; 3]>());
            *first.entry((p, attributes)).or_insert(v)
        });
    }
    alike
}

/// Points numbered in the order in which corners first use them.
pub(super) struct Numbering {
    /// The point of each corner.
    pub(super) points: Vec<u32>,
    /// A vertex of each point.
    pub(super) vertex_of: Vec<u32>,
}

impl Numbering {
    pub(super) fn new(positions: &[[f32; 3]], vertices: &[u32]) -> Self {
        let mut used = HashMap::new();
        let mut point_of =
            vec![NONE; if positions.len() / SPARSE > vertices.len() { 0 } else { positions.len() }];
        let mut vertex_of: Vec<u32> = Vec::new();
        let mut number = |v: u32| {
            // −0.0 is where 0.0 is.
            let bits = positions[v as usize].map(|x| (x + 0.0).to_bits());
            let point = *used.entry(bits).or_insert(vertex_of.len() as u32);
            match vertex_of.get_mut(point as usize) {
                Some(vertex) => *vertex = v.min(*vertex),
                None => vertex_of.push(v),
            }
            point
        };
        let mut points = Vec::with_capacity(vertices.len());
        for &v in vertices {
            let point = match point_of.get_mut(v as usize) {
                Some(known) => {
                    if *known == NONE {
                        *known = number(v);
                    }
                    *known
                }
                None => number(v),
            };
            points.push(point);
        }
        Self { points, vertex_of }
    }
}
