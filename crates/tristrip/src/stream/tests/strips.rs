use std::sync::Arc;

use super::*;
use crate::cover::PathCover;
use crate::cover::priced::PricedPaths;
use crate::dual::DualGraph;
use crate::lod::LevelModel;
use crate::mesh::is_degenerate;
use crate::random::Random;
use crate::stream::surface::NONE;
use crate::strip::{Cost, Strips};
use crate::verify::verify_drawing;

fn keeping() -> Decoder {
    Decoder::new(StreamLimits::default()).keeping_strips()
}

/// Checks the strips of a part against its triangles, and their paths against the corner table.
pub(super) fn check_strips(part: &StreamPart) {
    let Some(strips) = part.strips() else { return };
    // 1. Every triangle is drawn exactly once, with its winding.
    let triangles = part.triangles();
    let drawn = triangles_of(&triangles).filter(|&t| !is_degenerate(t)).flatten();
    let faces = Faces::from_triangles(drawn.collect()).unwrap();
    verify_drawing(&faces, &strips.triangles().collect::<Vec<_>>()).unwrap();
    assert_eq!(part.vertices_sent(), Some(strips.vertices_sent()));
    // 2. The neighbours match the corner table.
    let paths = part.paths().unwrap();
    let surface = part.surface();
    assert_eq!(paths.len(), surface.triangle_count());
    for corner in surface.corners() {
        let side = |corner: u32| 4 * (corner / 8) + (corner % 8 + 1) % 3;
        let other = surface.opposite(corner);
        assert_eq!(paths.twin(side(corner)), (other != NONE).then(|| side(other)));
    }
    // 3. The paths are valid, and their cost equals one computed from scratch.
    check_paths(paths, part.triangles());
}

fn check_paths(paths: &PricedPaths, triangles: Vec<u32>) {
    let sides = || (0..4 * paths.len() as u32).filter(|h| h % 4 < 3);
    let by_threes = |h: u32| 3 * (h / 4) + h % 4;
    let graph = DualGraph::of_triangle_twins(sides().map(|h| paths.twin(h).map(by_threes)));
    let mut cover = PathCover::isolated(paths.len());
    for h in sides().filter(|&h| paths.is_linked(h) && h < paths.across(h)) {
        cover.link_unchecked(by_threes(h), by_threes(paths.across(h)));
    }
    assert_eq!(cover.check(&graph), Ok(()));
    let faces = Faces::from_triangles(triangles).unwrap();
    let triangulation = crate::dual::Triangulation::from_parts(faces.corners().to_vec(), graph);
    let again = PricedPaths::new(&faces, &triangulation, &cover, Cost::OpenGl.prices());
    assert_eq!((again.cost(), again.strip_count()), (paths.cost(), paths.strip_count()));
    for t in (0..paths.len() as u32).filter(|&t| paths.degree(t) < 2) {
        assert_eq!(again.partner(t), paths.partner(t));
    }
    assert!((0..paths.len().div_ceil(64)).all(|block| again.ends_of(block) == paths.ends_of(block)));
}

/// Decodes chunk by chunk. Returns the strips after each.
fn strips_of(stream: &EncodedStream) -> Vec<Strips> {
    let mut decoder = keeping();
    let strips = stream.chunks.iter().map(|chunk| {
        decoder.update(&chunk.bytes).unwrap();
        let part = decoder.parts().next().unwrap();
        check_strips(part);
        part.strips().unwrap()
    });
    strips.collect()
}

/// Implements the rule without O(1) insertions: cuts the link, inserts the triangle, joins both
/// sides.
#[test]
fn insertions_cost_as_much_as_cuts_and_joins() {
    let mut random = Random::new(3);
    // A fan of triangles. Each has the next one across edge 1 and the previous one across edge 2,
    // or, at random, the reverse.
    let mut paths = PricedPaths::empty(400, Cost::OpenGl.prices());
    (0..3).for_each(|t| paths.insert_triangle(t));
    let pair = |paths: &mut PricedPaths, a: u32, b: u32| {
        paths.set_twin(a, Some(b));
        paths.set_twin(b, Some(a));
    };
    for [a, b] in [[1, 4], [5, 10]] {
        pair(&mut paths, a, b);
        paths.join(a).unwrap();
    }
    for t in 3..400 {
        let link = loop {
            let h = random.below(4 * t as usize) as u32;
            if h % 4 < 3 && paths.is_linked(h) {
                break h;
            }
        };
        let first = random.below(3) as u32;
        let sides = [4 * t + first, 4 * t + (first + 1 + random.below(2) as u32) % 3];
        let mut other = paths.clone();
        let twin = other.across(link);
        other.cut(link);
        other.insert_triangle(t);
        for (outer, inner) in [(link, sides[0]), (twin, sides[1])] {
            pair(&mut other, outer, inner);
            other.join(outer).unwrap();
        }
        paths.insert_triangle(t);
        paths.insert_into_link(link, sides);
        assert_eq!((paths.cost(), paths.strip_count()), (other.cost(), other.strip_count()));
        let state = |paths: &PricedPaths| -> Vec<(u32, [Option<u32>; 3], Option<u32>)> {
            let twins = |t: u32| [0, 1, 2].map(|e| paths.twin(4 * t + e));
            let partner = |t: u32| (paths.degree(t) < 2).then(|| paths.partner(t));
            (0..=t).map(|t| (paths.mask(t), twins(t), partner(t))).collect()
        };
        assert_eq!(state(&paths), state(&other));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 2))]

    #[test]
    fn strips_of_any_mesh_draw_its_triangles(mesh in meshes(), has_small_chunks in any::<bool>()) {
        let options = if has_small_chunks { small_chunks() } else { StreamOptions::default() };
        strips_of(&stream_of(&mesh, 0, &options).1);
    }

    #[test]
    fn strips_do_not_depend_on_pieces(mesh in meshes(), sizes in prop::collection::vec(1..80_usize, 1..20)) {
        let (_, stream) = stream_of(&mesh, 0, &small_chunks());
        let bytes = stream.bytes();
        let mut whole = keeping();
        whole.update(&bytes).unwrap();
        let mut pieces = keeping();
        let mut rest = &bytes[..];
        for size in sizes.into_iter().cycle() {
            let (piece, after) = rest.split_at(size.min(rest.len()));
            pieces.update(piece).unwrap();
            rest = after;
            if rest.is_empty() {
                break;
            }
        }
        let strips = |decoder: &Decoder| decoder.part(0).and_then(StreamPart::strips);
        prop_assert_eq!(strips(&pieces), strips(&whole));
        prop_assert_eq!(strips(&whole), strips_of(&stream).pop());
        prop_assert_eq!(strips(&decoded(&bytes)), None);
    }

    /// The oracle is the triangles that remain after the collapses.
    #[test]
    fn a_part_is_a_level_model(mesh in meshes(), keeps in any::<bool>(), jumps in prop::collection::vec(any::<usize>(), 1..6)) {
        let (_, stream) = stream_of(&mesh, 0, &small_chunks());
        let mut decoder = if keeps { keeping() } else { Decoder::new(StreamLimits::default()) };
        for chunk in &stream.chunks {
            decoder.update(&chunk.bytes).unwrap();
            let part = decoder.part(0).unwrap();
            let sequence = part.sequence().unwrap();
            prop_assert_eq!(part.levels().collapse_count(), part.level());
            prop_assert_eq!(part.levels(), &crate::lod::LevelTable::of(&sequence));
            prop_assert!(LevelModel::memory(part) >= 32 * part.triangle_count());
            let mut cursor = Arc::new(part.clone()).start();
            prop_assert_eq!(part.strips().is_none_or(|strips| &strips == cursor.strips()), true);
            for level in jumps.iter().map(|jump| jump % (sequence.len() + 1)) {
                cursor.set_level(level).unwrap();
                prop_assert_eq!(sorted(cursor.strips().triangles()), sorted(sequence.drawn(level).unwrap()));
            }
            prop_assert!(cursor.set_level(sequence.len() + 1).is_err());
        }
    }
}

#[test]
fn strips_stay_long() {
    let (_, stream) = stream_of(&grid(40, 40), 0, &small_chunks());
    let strips = strips_of(&stream);
    let sent: f64 =
        strips.iter().map(|strips| strips.vertices_sent() as f64 / strips.triangles().count() as f64).sum();
    let mean = sent / strips.len() as f64 / 3.0;
    assert!(strips.len() > 10 && mean < 0.45, "{mean}");
}

/// A ribbon is one strip, and a split in it must not walk to its ends.
#[test]
fn a_long_ribbon_is_followed_in_linear_time() {
    let (_, stream) = stream_of(&grid(20_000, 1), 0, &StreamOptions::default());
    let mut decoder = keeping();
    decoder.update(&stream.bytes()).unwrap();
    let part = decoder.part(0).unwrap();
    assert_eq!(part.triangle_count(), 40_000);
    check_strips(part);
    assert!(part.vertices_sent() < Some(44_000), "{:?}", part.vertices_sent());
}
