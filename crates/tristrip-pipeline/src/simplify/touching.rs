//! Finds positions of different instances that touch in the scene. A simplification keeps these
//! positions.
//!
//! Parts of different nodes touch if their positions are equal in the scene up to rounding. Two
//! instances of one part also touch, except at the same position of the part, because this position
//! moves in the same way in both instances. Parts with the same nodes are simplified together
//! instead.
//!
//! # Algorithm
//! A position in the scene is a sum of products of 32-bit numbers, each rounded once. [`ROUNDING`]
//! times the sum of their magnitudes bounds the rounding error. Space is divided into cells of
//! twice that size. Positions of different magnitude have different cell sizes, in *levels* of
//! powers of two. At each level, every position of that level or a lower one is stored in its cell,
//! and searches the eight nearest cells. Two positions of lower levels are not compared at this
//! level.
//!
//! Only positions inside the bounding box of another instance are stored. A tree of boxes finds
//! them.
//!
//! # Complexity
//! O(n log n) time for n positions in all instances. At most twice the number of positions of the
//! model, or [`FEW`] if that is more, are compared. Each position takes about 100 bytes.

use std::collections::HashMap;
use std::sync::Arc;

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree, RTreeObject};

use crate::places::Place;

/// The rounding error of a position in the scene relative to the added magnitudes: eight roundings
/// of half a unit in the last place of 32 bits, for the position and the matrices of a few nested
/// nodes.
const ROUNDING: f64 = 4.0 / (1_u32 << 24) as f64;
/// The number of powers of two from one level to the next.
const LEVEL_STEP: i32 = 4;
/// The number of powers of two between the highest and the lowest level. Positions closer to the
/// origin are not resolved more finely.
const LEVEL_RANGE: i32 = 24;
/// A number of positions that is always compared.
const FEW: usize = 1 << 23;

/// The positions of parts that share a list of transforms.
#[derive(Debug)]
pub(crate) struct PlacedPositions {
    pub(crate) places: Arc<[Place]>,
    /// The distinct positions.
    pub(crate) positions: Vec<[f32; 3]>,
}

/// The positions that touch others.
#[derive(Debug, Default)]
pub(crate) struct Touching {
    /// For each list, whether each of its positions touches another; empty if none do.
    pub(crate) touches: Vec<Vec<bool>>,
    /// The number of instances that were not compared because there are too many.
    pub(crate) skipped: usize,
}

/// A position in the scene.
#[derive(Debug, Clone, Copy)]
struct Placed {
    at: [f64; 3],
    level: i32,
    /// The index of the instance among the instances of all lists.
    place: u32,
    list: u32,
    /// The index of the position in its list.
    position: u32,
}

/// The instances and positions of a cell.
#[derive(Debug, Clone, Copy, Default)]
struct CellContent {
    first: Option<(u32, [u32; 2])>,
    has_other_places: bool,
    has_other_positions: bool,
}

impl CellContent {
    fn add(&mut self, placed: &Placed) {
        self.join(&Self { first: Some((placed.place, [placed.list, placed.position])), ..Self::default() });
    }

    fn join(&mut self, other: &Self) {
        let Some((place, position)) = other.first else { return };
        let &mut (own_place, own_position) = self.first.get_or_insert((place, position));
        self.has_other_places |= other.has_other_places || own_place != place;
        self.has_other_positions |= other.has_other_positions || own_position != position;
    }
}

/// The contents of a cell: all positions, and the positions of its own level.
type Cells = HashMap<[i32; 3], [CellContent; 2]>;

/// Finds the positions that touch a position of another instance.
pub(crate) fn touching(lists: &[PlacedPositions]) -> Touching {
    let mut found = Touching { touches: vec![Vec::new(); lists.len()], skipped: 0 };
    if lists.iter().map(|list| list.places.len()).sum::<usize>() < 2 {
        return found;
    }
    let (placed, skipped) = placed_positions(lists);
    found.skipped = skipped;
    let mut levels: Vec<i32> = placed.iter().map(|placed| placed.level).collect();
    levels.sort_unstable();
    levels.dedup();
    for level in levels {
        mark_level(&placed, level, lists, &mut found.touches);
    }
    found
}

/// Marks positions of this level or a lower one that touch a position of this level.
fn mark_level(placed: &[Placed], level: i32, lists: &[PlacedPositions], touches: &mut [Vec<bool>]) {
    let size = power_of_two(-level);
    let mut cells = Cells::new();
    for placed in placed.iter().filter(|placed| placed.level <= level) {
        let cell = cells.entry(placed.at.map(|x| (x * size).floor() as i32)).or_default();
        cell[0].add(placed);
        if placed.level == level {
            cell[1].add(placed);
        }
    }
    for placed in placed.iter().filter(|placed| placed.level <= level) {
        let mut around = CellContent::default();
        around.add(placed);
        let of_level = usize::from(placed.level != level);
        for cell in nearest_cells(placed.at.map(|x| x * size)) {
            if let Some(cell) = cells.get(&cell) {
                around.join(&cell[of_level]);
            }
        }
        if around.has_other_places && around.has_other_positions {
            let list = placed.list as usize;
            touches[list].resize(lists[list].positions.len(), false);
            touches[list][placed.position as usize] = true;
        }
    }
}

/// Returns the eight cells nearest to a point, including its own.
fn nearest_cells(at: [f64; 3]) -> [[i32; 3]; 8] {
    let low = at.map(|x| (x - 0.5).floor() as i32);
    std::array::from_fn(|i| [0, 1, 2].map(|axis| low[axis].saturating_add(i32::from(i >> axis & 1 == 1))))
}

/// Returns a power of two with a small exponent.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(u64::from((1023 + exponent).unsigned_abs()) << 52)
}

/// Returns the level of a magnitude: the exponent of a cell that is larger than twice its rounding
/// error.
fn level_of(magnitude: f64) -> i32 {
    let size = 2.0 * ROUNDING * magnitude;
    let exponent = (size.to_bits() >> 52) as i32 - 1023 + 1;
    -(-exponent).div_euclid(LEVEL_STEP) * LEVEL_STEP
}

type PlaceBox = GeomWithData<Rectangle<[f64; 3]>, u32>;

/// Returns the positions inside the bounding box of another instance, and the number of instances
/// that were skipped.
fn placed_positions(lists: &[PlacedPositions]) -> (Vec<Placed>, usize) {
    // 1. The boxes of all instances: the first of each list, then the second of each, which puts
    //    every part near the start.
    let longest = lists.iter().map(|list| list.places.len()).max().unwrap_or(0);
    let mut order: Vec<(u32, u32)> = Vec::new();
    let mut remaining: Vec<u32> = (0..lists.len() as u32).collect();
    for number in 0..longest as u32 {
        remaining.retain(|&list| lists[list as usize].places.len() > number as usize);
        order.extend(remaining.iter().map(|&list| (list, number)));
    }
    let bounds: Vec<_> = lists.iter().map(|list| bounds(list.positions.iter().copied())).collect();
    let mut largest = 0.0_f64;
    let mut boxes: Vec<PlaceBox> = Vec::with_capacity(order.len());
    for (number, &(list, place)) in (0..).zip(&order) {
        let Some(bounds) = bounds[list as usize] else { continue };
        let place = lists[list as usize].places[place as usize];
        let (low, high, magnitude) = box_of(&place, bounds);
        largest = largest.max(magnitude);
        boxes.push(PlaceBox::new(Rectangle::from_corners(low, high), number));
    }
    let lowest = level_of(largest) - LEVEL_RANGE;
    let tree = RTree::bulk_load(boxes.clone());
    // 2. The positions of instances whose boxes intersect others.
    let most = FEW.max(2 * lists.iter().map(|list| list.positions.len()).sum::<usize>());
    let (mut placed, mut compared, mut skipped) = (Vec::new(), 0, 0);
    for own in &boxes {
        if !has_other(&tree, own.envelope(), own.data) {
            continue;
        }
        let (list, place) = order[own.data as usize];
        let PlacedPositions { places, positions } = &lists[list as usize];
        compared += positions.len();
        if compared > most {
            skipped += 1;
            continue;
        }
        let place = places[place as usize];
        for (position, &p) in (0..).zip(positions) {
            let at = place.at(p);
            if has_other(&tree, AABB::from_point(at), own.data) {
                let level = level_of(place.magnitude(p)).max(lowest);
                placed.push(Placed { at, level, place: own.data, list, position });
            }
        }
    }
    (placed, skipped)
}

/// Checks whether a box intersects that of another instance.
fn has_other(tree: &RTree<PlaceBox>, envelope: AABB<[f64; 3]>, own: u32) -> bool {
    tree.locate_in_envelope_intersecting(envelope).any(|other| other.data != own)
}

/// Returns the corners of a transformed box with a margin for rounding, and the magnitude of its
/// positions.
fn box_of(place: &Place, bounds: [[f32; 3]; 2]) -> ([f64; 3], [f64; 3], f64) {
    let (mut least, mut most, mut magnitude) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0.0_f64);
    for p in box_corners(bounds) {
        for (axis, x) in place.at(p).into_iter().enumerate() {
            least[axis] = least[axis].min(x);
            most[axis] = most[axis].max(x);
        }
        magnitude = magnitude.max(place.magnitude(p));
    }
    let margin = power_of_two(level_of(magnitude));
    (least.map(|x| x - margin), most.map(|x| x + margin), magnitude)
}

/// Returns the eight corners of a box.
pub(crate) fn box_corners(bounds: [[f32; 3]; 2]) -> impl Iterator<Item = [f32; 3]> {
    (0..8).map(move |corner| [0, 1, 2].map(|axis| bounds[corner >> axis & 1][axis]))
}

/// Returns the minimum and maximum coordinates; `None` without positions.
pub(crate) fn bounds(positions: impl IntoIterator<Item = [f32; 3]>) -> Option<[[f32; 3]; 2]> {
    positions.into_iter().fold(None, |bounds, p| {
        let [low, high] = bounds.unwrap_or([p; 2]);
        Some([[0, 1, 2].map(|k| p[k].min(low[k])), [0, 1, 2].map(|k| p[k].max(high[k]))])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::random::Random;

    fn moved(x: f64, y: f64, z: f64) -> Place {
        Place::new([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]])
    }

    fn list(places: &[Place], positions: &[[f32; 3]]) -> PlacedPositions {
        PlacedPositions { places: places.into(), positions: positions.to_vec() }
    }

    #[test]
    fn positions_touch_where_nodes_place_them() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let found = |other: Place| {
            let lists = [list(&[Place::IDENTITY], &corners), list(&[other], &corners)];
            touching(&lists).touches
        };
        assert_eq!(found(moved(1.0, 0.0, 0.0)), [vec![false, true, false], vec![true, false, false]]);
        assert_eq!(found(moved(9.0, 0.0, 0.0)), vec![Vec::<bool>::new(); 2]);
        // A rotation matrix that was stored with 32 bits.
        let (c, s) = (f64::from(0.8_f32), f64::from(0.6_f32));
        let turned = Place::new([[c, -s, 0.0, 1.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
        let back = turned.at([1.0, 0.0, 0.0]).map(|x| x as f32);
        let lists = [list(&[turned], &corners), list(&[Place::IDENTITY], &[back, [1.8, 0.61, 0.0]])];
        assert_eq!(touching(&lists).touches, [vec![false, true, false], vec![true, false]]);
    }

    #[test]
    fn copies_touch_only_where_they_have_different_positions() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        // Mirrored copies that share a corner, copies with one transform, and adjacent tiles.
        let mirrored = Place::new([[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
        let copies = touching(&[list(&[Place::IDENTITY, mirrored], &corners)]);
        assert_eq!(copies.touches, [Vec::<bool>::new()]);
        let tiles = [moved(0.0, 0.0, 0.0), moved(1.0, 0.0, 0.0)];
        assert_eq!(touching(&[list(&tiles, &corners)]).touches, [[true, true, false]]);
    }

    #[test]
    fn every_pair_within_rounding_is_found() {
        let mut random = Random::new(7);
        let mut number = |n: usize| random.below(n) as f64 / 1000.0;
        let places: Vec<Place> =
            (0..6).map(|_| moved(number(3000) - 1.5, number(3000) - 1.5, 1e-3 * number(3000))).collect();
        let own: Vec<Vec<[f32; 3]>> = places
            .iter()
            .map(|place| {
                let at = |_| [number(900), number(900), number(9)];
                let rough: Vec<[f64; 3]> = (0..80).map(at).collect();
                // Snap to a coarse grid of the scene, to make many positions equal.
                let snapped = |p: [f64; 3]| {
                    let p = place.at(p.map(|x| x as f32)).map(|x| (x * 8.0).round() / 8.0);
                    let origin = place.at([0.0; 3]);
                    [0, 1, 2].map(|k| (p[k] - origin[k]) as f32)
                };
                rough.into_iter().map(snapped).collect()
            })
            .collect();
        let lists: Vec<PlacedPositions> =
            places.iter().zip(&own).map(|(&place, own)| list(&[place], own)).collect();
        let found = touching(&lists);
        let mut pairs = 0;
        for (a, (place, own_a)) in places.iter().zip(&own).enumerate() {
            for (i, &p) in own_a.iter().enumerate() {
                let near =
                    places.iter().zip(&own).enumerate().filter(|&(b, _)| b != a).any(|(_, (other, all))| {
                        all.iter().any(|&q| {
                            let (p_at, q_at) = (place.at(p), other.at(q));
                            let rounding = ROUNDING * place.magnitude(p).max(other.magnitude(q));
                            (0..3).all(|k| (p_at[k] - q_at[k]).abs() <= rounding)
                        })
                    });
                let marked = found.touches[a].get(i).copied().unwrap_or(false);
                assert_eq!(marked, near, "{a} {i}");
                pairs += usize::from(near);
            }
        }
        assert!(pairs > 50, "{pairs}");
    }
}
