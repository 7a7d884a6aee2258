//! The base mesh as decisions.
//!
//! # Algorithm
//! The triangles are coded in the order of a walk. Each open edge is visited once, in the order in
//! which the edges were created. It is a border, the edge of a new triangle, or shared with another
//! open edge. When no edge is left, a new component begins.
//!
//! Then the fans are coded, in order of their lowest corners. Each fan is a new vertex, or belongs
//! to the vertex of an earlier fan. Each vertex is a new point, or has the position of an earlier
//! fan. New points and vertices get values. The values are predicted by the parallelogram rule
//! across the edge at which the first triangle was added.
//!
//! # Complexity
//! O(n) time.

use super::fans::SurfaceFan;
use super::fans::{GridPlace, square_distance};
use super::refiner::Refiner;
use super::surface::{NONE, next, previous};
use crate::entropy::numbers::code_small;
use crate::entropy::range_coder::{BitCoder, code_bits};
use crate::entropy::slots::Simple;

/// A base mesh to encode.
#[derive(Debug, Default)]
pub(super) struct BaseToEncode {
    /// For each fan its position, an earlier fan of its point if there is one, and one of its
    /// vertex.
    pub(super) places: Vec<GridPlace>,
    pub(super) twins: Vec<Option<u32>>,
    pub(super) same_vertex: Vec<Option<u32>>,
    pub(super) values: Vec<Vec<Vec<i32>>>,
}

/// What is on the other side of an open edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Beyond {
    Border,
    Triangle,
    /// Another open edge, as the number of edges created since this one.
    Edge(u32),
}

/// The models of a base mesh.
struct BaseModel {
    kinds: Simple,
    distances: Simple,
}

impl BaseModel {
    /// Codes the other side of an edge. `can_grow` is whether there are more triangles, `most` how
    /// many edges were created later.
    fn code<C: BitCoder>(&mut self, coder: &mut C, can_grow: bool, most: u32, to_encode: Beyond) -> Beyond {
        if can_grow && self.kinds.code(coder, 0, to_encode == Beyond::Triangle) {
            return Beyond::Triangle;
        }
        if most == 0 || self.kinds.code(coder, 1, to_encode == Beyond::Border) {
            return Beyond::Border;
        }
        let distance = if let Beyond::Edge(distance) = to_encode { distance - 1 } else { 0 };
        Beyond::Edge(code_small(coder, &mut self.distances, distance) + 1)
    }
}

/// The reason why bytes cannot be decoded as a base mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BaseFault {
    /// Two triangles should share an edge that one of them does not have or already shares.
    NoSuchEdge,
    /// The bytes end before the triangles are complete.
    TooShort,
}

/// Codes the triangles of a base mesh as a table of the opposite corner of each corner, three
/// corners per triangle. `to_encode` is the table to encode, with triangles in any order. Returns
/// the table in the order of the walk, and for each of its corners the corner in `to_encode`. The
/// corners of a triangle keep their cyclic order, but can start at another one.
pub(super) fn code_triangles<C: BitCoder>(
    coder: &mut C,
    triangle_count: usize,
    to_encode: &[u32],
) -> Result<(Vec<u32>, Vec<u32>), BaseFault> {
    let mut model = BaseModel { kinds: Simple::new(2), distances: Simple::new(32) };
    let mut opposite: Vec<u32> = Vec::new();
    // For each corner its corner in the table to encode, and the inverse.
    let mut sources: Vec<u32> = Vec::new();
    let mut numbers = vec![NONE; to_encode.len()];
    let mut next_seed = 0;
    let mut at = 0;
    while opposite.len() < 3 * triangle_count {
        if coder.is_past_end() {
            return Err(BaseFault::TooShort);
        }
        // 1. A new component.
        while numbers.get(next_seed as usize).is_some_and(|&number| number != NONE) {
            next_seed += 3;
        }
        add_triangle(next_seed, &mut sources, &mut numbers);
        opposite.extend([NONE; 3]);
        // 2. The edges in their order. Each is identified by the opposite corner, whose index is
        //    the position in the order.
        while at < opposite.len() {
            let corner = at as u32;
            at += 1;
            if opposite[corner as usize] != NONE {
                continue;
            }
            let beyond = match to_encode.get(sources[corner as usize] as usize) {
                None | Some(&NONE) => Beyond::Border,
                Some(&other) => match numbers[other as usize] {
                    NONE => Beyond::Triangle,
                    number => Beyond::Edge(number - corner),
                },
            };
            let can_grow = opposite.len() < 3 * triangle_count;
            let most = opposite.len() as u32 - corner - 1;
            match model.code(coder, can_grow, most, beyond) {
                Beyond::Border if coder.is_past_end() => return Err(BaseFault::TooShort),
                Beyond::Border => (),
                Beyond::Triangle => {
                    if coder.is_past_end() {
                        return Err(BaseFault::TooShort);
                    }
                    let new = opposite.len() as u32;
                    let source = to_encode.get(sources[corner as usize] as usize).copied().unwrap_or(0);
                    add_triangle(source, &mut sources, &mut numbers);
                    opposite.extend([NONE; 3]);
                    (opposite[corner as usize], opposite[new as usize]) = (new, corner);
                }
                Beyond::Edge(distance) => {
                    let other = corner as usize + distance as usize;
                    if opposite.get(other) != Some(&NONE) {
                        return Err(BaseFault::NoSuchEdge);
                    }
                    (opposite[corner as usize], opposite[other]) = (other as u32, corner);
                }
            }
        }
    }
    Ok((opposite, sources))
}

/// Numbers the corners of the next triangle.
fn add_triangle(first: u32, sources: &mut Vec<u32>, numbers: &mut [u32]) {
    let of_triangle = first / 3 * 3;
    for source in (0..3).map(|i| of_triangle + (first + i) % 3) {
        if let Some(number) = numbers.get_mut(source as usize) {
            *number = sources.len() as u32;
        }
        sources.push(source);
    }
}

impl Refiner {
    /// Codes the fans, vertices and points of the base mesh. Its triangles must exist. Some are
    /// missing if the coder is past its end.
    pub(super) fn code_base<C: BitCoder>(&mut self, coder: &mut C, to_encode: Option<&BaseToEncode>) {
        let mut flags = Simple::new(2);
        let fan_count = self.surface.first.len();
        let mut lowest = vec![NONE; fan_count];
        for corner in self.surface.corners() {
            let lowest = &mut lowest[self.surface.fan(corner) as usize];
            *lowest = corner.min(*lowest);
        }
        let mut new_vertices = 0;
        for fan in 0..fan_count as u32 {
            if coder.is_past_end() {
                return;
            }
            let index = fan as usize;
            let bits = u32::BITS - fan.leading_zeros();
            let mut earlier = |coder: &mut C, context: usize, to_encode: Option<u32>| {
                let is_earlier = fan > 0 && flags.code(coder, context, to_encode.is_some());
                is_earlier.then(|| code_bits(coder, bits, to_encode.unwrap_or(0)) % fan.max(1))
            };
            // 1. The vertex, then the point.
            let same_vertex = earlier(coder, 0, to_encode.and_then(|to_encode| to_encode.same_vertex[index]));
            let twin = same_vertex
                .or_else(|| earlier(coder, 1, to_encode.and_then(|to_encode| to_encode.twins[index])));
            // 2. The fans at the edge where the first triangle of the fan was added.
            let corner = lowest[index];
            let opposite = self.surface.opposite(corner);
            let has_edge = opposite != NONE && opposite < corner;
            let around = if has_edge { [next(corner), previous(corner), opposite] } else { [NONE; 3] };
            let around = around.map(|corner| if corner == NONE { NONE } else { self.surface.fan(corner) });
            let is_known = around.iter().all(|&other| other < fan);
            // 3. The position.
            let place = if let Some(twin) = twin {
                self.fans[twin as usize].place()
            } else {
                let at = |fan: u32| self.fans.get(fan as usize).map_or([0; 3], SurfaceFan::place);
                let (near, square) = if is_known {
                    let [a, b, c] = around.map(at);
                    ([0, 1, 2].map(|j| a[j].wrapping_add(b[j]).wrapping_sub(c[j])), square_distance(a, b) + 1)
                } else {
                    (at(fan.wrapping_sub(1)), 1 << 24)
                };
                let place = to_encode
                    .map_or([0; 3], |to_encode| to_encode.places[index].map(|x| x >> self.unknown_bits));
                self.place_model.code_base(coder, near, square, place)
            };
            // 4. The attributes.
            let vertex = if let Some(other) = same_vertex {
                self.vertices[other as usize]
            } else {
                let values = to_encode.map(|to_encode| &to_encode.values[index][..]);
                let near =
                    if is_known { &around[..2] } else { &[fan.wrapping_sub(1)][..usize::from(fan > 0)] };
                self.code_values(coder, near, values);
                new_vertices += 1;
                new_vertices - 1
            };
            self.push_fan(place, twin, vertex, false);
        }
        self.look_around();
    }
}
