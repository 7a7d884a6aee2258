use std::collections::HashMap;

use proptest::prelude::*;

use super::grid::Grid;
use super::samples::{
    batches, decoded, fingerprints, grid, meshes, scattered, small_chunks, stream_of, with_attributes,
};
use super::{Decoder, EncodedStream, StreamLimits, StreamOptions, StreamPart, encode};
use crate::lod::samples::sorted;
use crate::mesh::{AttributeData, Faces, Mesh, triangles_of};
use crate::simplify::MergeTree;

mod arguments;
mod attributes;
mod hostile;
mod strips;
mod vectors;

/// Numbers keys in the order in which they occur.
#[derive(Default)]
struct Keys(HashMap<Vec<i64>, u32>);

impl Keys {
    fn number(&mut self, key: Vec<i64>) -> u32 {
        let next = self.0.len() as u32;
        *self.0.entry(key).or_insert(next)
    }
}

/// Returns the grid of the positions that triangles use.
fn grid_of(mesh: &Mesh, bits: u32) -> Grid {
    Grid::new(mesh.faces().corners().iter().map(|&v| mesh.positions()[v as usize]), bits)
}

/// Returns the triangles, sorted, with the numbers of their corners' grid positions.
fn on_grid(
    keys: &mut Keys,
    grid: &Grid,
    positions: &[[f32; 3]],
    triangles: impl IntoIterator<Item = [u32; 3]>,
) -> Vec<[u32; 3]> {
    let mut corner = |v: u32| keys.number(grid.place(positions[v as usize], 14).map(i64::from).to_vec());
    let triangles: Vec<_> = triangles.into_iter().map(|t| t.map(&mut corner)).collect();
    sorted(triangles)
}

/// Decodes chunk by chunk, and checks the mesh after each.
fn check_stream(
    mesh: &Mesh,
    batches: &MergeTree,
    stream: &EncodedStream,
) -> Result<StreamPart, TestCaseError> {
    let mut decoder = Decoder::new(StreamLimits::default());
    let mut levels: Vec<(usize, Vec<[u32; 3]>)> = Vec::new();
    for chunk in &stream.chunks {
        prop_assert_eq!(decoder.update(&chunk.bytes).unwrap(), 1);
        let part = decoder.parts().next().unwrap();
        part.surface().check().map_err(TestCaseError::fail)?;
        prop_assert_eq!(
            (part.level(), part.triangle_count()),
            (chunk.level as usize, chunk.triangles as usize)
        );
        prop_assert_eq!(part.error().to_bits(), chunk.error.to_bits());
        prop_assert_eq!(part.sequence().unwrap().len(), part.level());
        levels.push((part.level(), sorted(triangles_of(&part.triangles()))));
    }
    let part = decoder.parts().next().unwrap().clone();
    let full = mesh.faces().corners();
    let is_real = |&[a, b, c]: &[u32; 3]| a != b && b != c && a != c;
    // 1. The full mesh equals the input.
    let grid = grid_of(mesh, 14);
    let mut keys = Keys::default();
    let positions = part.positions();
    let of_input = on_grid(&mut keys, &grid, mesh.positions(), triangles_of(full).filter(is_real));
    let of_stream = on_grid(&mut keys, &grid, &positions, triangles_of(&part.triangles()));
    prop_assert_eq!(&of_stream, &of_input);
    prop_assert_eq!(part.level(), part.full_level());
    prop_assert_eq!(part.triangle_count(), part.full_triangle_count());
    // 2. Each chunk led to a level of the collapses, and the base mesh is that of the plan.
    let sequence = part.sequence().unwrap();
    sequence.check().unwrap();
    for (level, drawn) in &levels {
        prop_assert_eq!(&sorted(sequence.drawn(*level).unwrap()), drawn);
    }
    let of_plan = on_grid(&mut keys, &grid, mesh.positions(), triangles_of(&stream.base));
    prop_assert_eq!(on_grid(&mut keys, &grid, &positions, sequence.drawn(0).unwrap()), of_plan);
    // 3. At the end of a batch, the level is that of the encoded collapses.
    let count = batches.sequence.len();
    prop_assert_eq!(part.full_level(), count);
    let ends: Vec<usize> = batches.level_ends.iter().map(|&end| count - end as usize).collect();
    for level in ends.into_iter().chain([count]) {
        let to_encode = on_grid(&mut keys, &grid, mesh.positions(), batches.sequence.drawn(level).unwrap());
        prop_assert_eq!(on_grid(&mut keys, &grid, &positions, sequence.drawn(level).unwrap()), to_encode);
    }
    // 4. The positions are within the declared error.
    let most = f64::from(stream.position_error) * (1.0 + 1e-6) + 1e-5;
    for &v in full {
        let p = mesh.positions()[v as usize];
        let place = grid.place(p, 14);
        let near = positions.iter().find(|&&position| grid.place(position, 14) == place);
        let Some(near) = near else { continue };
        let square: f64 = (0..3).map(|j| (f64::from(p[j]) - f64::from(near[j])).powi(2)).sum();
        prop_assert!(square.sqrt() <= most, "{p:?} is {near:?}");
    }
    Ok(part)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 2))]

    #[test]
    fn any_mesh_is_restored_level_by_level(mesh in meshes(), has_small_chunks in any::<bool>()) {
        let options = if has_small_chunks { small_chunks() } else { StreamOptions::default() };
        let (batches, stream) = stream_of(&mesh, 0, &options);
        check_stream(&mesh, &batches, &stream)?;
    }

    #[test]
    fn any_pieces_build_the_same(mesh in meshes(), sizes in prop::collection::vec(1..80_usize, 1..20)) {
        let (_, stream) = stream_of(&mesh, 0, &small_chunks());
        let bytes = stream.bytes();
        let whole = decoded(&bytes);
        let mut pieces = Decoder::new(StreamLimits::default());
        let (mut rest, mut decoded) = (&bytes[..], 0);
        for size in sizes.into_iter().cycle() {
            let (piece, after) = rest.split_at(size.min(rest.len()));
            decoded += pieces.update(piece).unwrap();
            rest = after;
            if rest.is_empty() {
                break;
            }
        }
        prop_assert_eq!(decoded, stream.chunks.len());
        prop_assert_eq!(fingerprints(&pieces), fingerprints(&whole));
        prop_assert_eq!(pieces.offset(), bytes.len() as u64);
    }

    #[test]
    fn collapses_that_cannot_be_split_stay_in_the_base_mesh(mesh in meshes()) {
        // Here, vertices that cannot be restored are not locked.
        let options = crate::simplify::SimplifyOptions::default();
        let tree = crate::simplify::merge_tree(&mesh, mesh.faces().corners().to_vec(), crate::simplify::MergeOrder::Quadric, &options).unwrap();
        let stream = encode(&mesh, &tree.sequence, &tree.level_ends, 0, &small_chunks()).unwrap();
        let decoder = decoded(&stream.bytes());
        let part = decoder.part(0).unwrap();
        part.surface().check().map_err(TestCaseError::fail)?;
        let (grid, mut keys) = (grid_of(&mesh, 14), Keys::default());
        let is_real = |&[a, b, c]: &[u32; 3]| a != b && b != c && a != c;
        let of_input = on_grid(&mut keys, &grid, mesh.positions(), triangles_of(mesh.faces().corners()).filter(is_real));
        prop_assert_eq!(on_grid(&mut keys, &grid, &part.positions(), triangles_of(&part.triangles())), of_input);
        let of_plan = on_grid(&mut keys, &grid, mesh.positions(), triangles_of(&stream.base));
        let of_stream = on_grid(&mut keys, &grid, &part.positions(), part.sequence().unwrap().drawn(0).unwrap());
        prop_assert_eq!(of_stream, of_plan);
    }
}

#[test]
fn bytes_are_the_same_in_two_runs() {
    let mesh = with_attributes(8, 8);
    let bytes = || stream_of(&mesh, 3, &small_chunks()).1.bytes();
    assert_eq!(bytes(), bytes());
}

#[test]
fn a_grid_has_few_triangles_at_first_and_precise_positions_at_last() {
    let mesh = grid(20, 20);
    let (batches, stream) = stream_of(&mesh, 0, &small_chunks());
    let part = check_stream(&mesh, &batches, &stream).unwrap();
    assert!(stream.chunks.len() > 5 && stream.chunks[0].triangles < 40, "{}", stream.chunks[0].triangles);
    assert!(stream.chunks.is_sorted_by(|a, b| a.level <= b.level && a.error >= b.error));
    assert_eq!(part.position_bits(), [14, 14]);
    let base = decoded(&stream.chunks[0].bytes);
    let [known, all] = base.part(0).unwrap().position_bits();
    assert!(known < all);
    assert_eq!(base.part(0).unwrap().full_vertex_count(), mesh.vertex_count());
}

#[test]
fn positions_have_as_many_bits_as_asked_for() {
    let mesh = grid(6, 6);
    for bits in [4, 8, 16] {
        let options = StreamOptions::default().with_position_bits(bits);
        let (_, stream) = stream_of(&mesh, 0, &options);
        let decoder = decoded(&stream.bytes());
        let part = decoder.part(0).unwrap();
        assert_eq!(part.position_bits(), [bits, bits]);
        assert_eq!(part.triangle_count(), 72);
        let least = |p: [f32; 3]| {
            mesh.positions()
                .iter()
                .map(|q| (0..3).map(|j| (p[j] - q[j]).powi(2)).sum::<f32>().sqrt())
                .fold(f32::MAX, f32::min)
        };
        assert!(part.positions().into_iter().all(|p| least(p) <= stream.position_error * 1.001));
        assert!((stream.position_error - 6.0 * 0.75_f32.sqrt() / ((1_u32 << bits) - 1) as f32).abs() < 1e-3);
    }
}

#[test]
fn small_meshes_are_restored() {
    let triangles: [&[u32]; 6] = [
        &[],
        &[0, 1, 2],
        &[0, 1, 2, 0, 1, 2, 0, 1, 2],
        &[0, 1, 2, 2, 1, 0],
        &[0, 0, 1, 1, 2, 2],
        &[0, 1, 2, 0, 1, 3, 0, 1, 4, 0, 2, 1],
    ];
    for triangles in triangles {
        let mesh = scattered(triangles.to_vec(), 5);
        let (batches, stream) = stream_of(&mesh, 0, &small_chunks());
        check_stream(&mesh, &batches, &stream).unwrap();
    }
}

#[test]
fn vertices_in_one_position_are_restored() {
    let corners = grid(6, 6).faces().corners().to_vec();
    let mesh = Mesh::new(vec![[1.5, -2.0, 0.0]; 49], Faces::from_triangles(corners).unwrap()).unwrap();
    let (_, stream) = stream_of(&mesh, 0, &small_chunks());
    let decoder = decoded(&stream.bytes());
    let part = decoder.part(0).unwrap();
    assert_eq!(part.triangle_count(), 72);
    assert!(part.positions().iter().all(|position| mesh.positions().contains(position)));
    assert_eq!(stream.position_error.to_bits(), 0);
}

#[test]
fn a_point_has_more_neighbours_than_are_counted() {
    // A cone whose tip has so many neighbours that their number wraps.
    let count = 66_000;
    let angle = |i: u32| f64::from(i) / f64::from(count) * std::f64::consts::TAU;
    let rim = |i: u32| [libm::cos(angle(i)), libm::sin(angle(i)), f64::from(i % 7) / 99.0].map(|x| x as f32);
    let positions: Vec<_> = std::iter::once([0.0, 0.0, 0.4]).chain((0..count).map(rim)).collect();
    let triangles = (0..count).flat_map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect();
    let mesh = Mesh::new(positions, Faces::from_triangles(triangles).unwrap()).unwrap();
    let (_, stream) = stream_of(&mesh, 0, &StreamOptions::default());
    let base = stream.chunks[0].triangles;
    assert!(base < 60_000, "{base}");
    let decoder = decoded(&stream.bytes());
    assert_eq!(decoder.part(0).unwrap().triangle_count(), count as usize);
}

#[test]
fn chunks_of_several_meshes_come_in_any_order() {
    let meshes = [grid(9, 9), with_attributes(6, 6), grid(3, 2)];
    let streams: Vec<_> = (0..).zip(&meshes).map(|(i, mesh)| stream_of(mesh, i, &small_chunks()).1).collect();
    let most = streams.iter().map(|stream| stream.chunks.len()).max().unwrap();
    let mut decoder = Decoder::new(StreamLimits::default());
    for i in 0..most {
        for chunk in streams.iter().rev().filter_map(|stream| stream.chunks.get(i)) {
            decoder.update(&chunk.bytes).unwrap();
        }
    }
    let alone: Vec<_> = streams.iter().flat_map(|stream| fingerprints(&decoded(&stream.bytes()))).collect();
    assert_eq!(fingerprints(&decoder), alone);
    assert_eq!(decoder.parts().count(), 3);
}

#[test]
fn bits_are_counted_without_a_change() {
    let mesh = with_attributes(10, 10);
    let (_, stream) = stream_of(&mesh, 0, &StreamOptions::default());
    let mut counting = Decoder::new(StreamLimits::default()).counting_bits();
    counting.update(&stream.bytes()).unwrap();
    let plain = decoded(&stream.bytes());
    assert_eq!(fingerprints(&counting), fingerprints(&plain));
    assert_eq!(plain.part(0).unwrap().costs(), None);
    let costs = counting.part(0).unwrap().costs().unwrap();
    let sum = costs.base + costs.connectivity() + costs.positions + costs.precision + costs.attributes;
    let bits = stream.bytes().len() as f64 * 8.0;
    // Headers and chunk ends are not counted.
    assert!(sum <= bits && sum >= 0.9 * bits, "{sum} of {bits}");
    assert!(costs.attributes > costs.marks);
}
