use super::*;
use crate::mesh::Attribute;
use crate::{CollapseSequence, Error, Rename};

fn message<T: std::fmt::Debug>(result: Result<T, Error>) -> String {
    result.unwrap_err().to_string()
}

#[test]
fn a_sequence_of_another_mesh_is_refused() {
    let (mesh, tree) = (grid(4, 4), batches(&grid(5, 5)));
    let result = encode(&mesh, &tree.sequence, &tree.level_ends, 0, &StreamOptions::default());
    assert_eq!(
        message(result),
        "parameter `sequence`: found collapses over 36 vertices, expected the vertices of the mesh"
    );
}

#[test]
fn points_with_a_common_triangle_are_no_batch() {
    let mesh = grid(8, 8);
    let tree = batches(&mesh);
    // All collapses in one batch.
    let result = encode(&mesh, &tree.sequence, &[], 0, &StreamOptions::default());
    let found = message(result);
    assert!(found.starts_with("parameter `level_ends`: found "), "{found}");
    // Valid: ends beyond the collapses, duplicates, any order, and one collapse per batch.
    let count = tree.sequence.len() as u32;
    let mut ends: Vec<u32> = (0..count + 3).rev().collect();
    ends.push(1);
    let stream = encode(&mesh, &tree.sequence, &ends, 0, &StreamOptions::default()).unwrap();
    let decoder = decoded(&stream.bytes());
    assert_eq!(decoder.part(0).unwrap().triangle_count(), 128);
}

#[test]
fn ends_at_random_are_refused_or_right() {
    let mesh = grid(6, 6);
    let tree = batches(&mesh);
    let mut random = crate::random::Random::new(3);
    let mut refused = 0;
    for _ in 0..200 {
        let count = tree.sequence.len();
        let ends: Vec<u32> = (0..random.below(count)).map(|_| random.below(count) as u32).collect();
        let Ok(stream) = encode(&mesh, &tree.sequence, &ends, 0, &small_chunks()) else {
            refused += 1;
            continue;
        };
        let (grid, mut keys) = (grid_of(&mesh, 14), Keys::default());
        let decoder = decoded(&stream.bytes());
        let part = decoder.part(0).unwrap();
        let found = on_grid(&mut keys, &grid, &part.positions(), triangles_of(&part.triangles()));
        assert_eq!(found, on_grid(&mut keys, &grid, mesh.positions(), triangles_of(mesh.faces().corners())));
    }
    assert!((1..200).contains(&refused), "{refused}");
}

#[test]
fn any_collapses_are_encoded_or_refused() {
    // Vertices without a common triangle, and several at once.
    let mesh = grid(2, 2);
    let corners = mesh.faces().corners().to_vec();
    for removed in 0..9 {
        for kept in (0..9).filter(|&kept| kept != removed) {
            let renames = [Rename { removed, kept }];
            let sequence =
                CollapseSequence::from_collapses(9, corners.clone(), [(&renames[..], 0.5)]).unwrap();
            let stream = encode(&mesh, &sequence, &[1], 0, &StreamOptions::default()).unwrap();
            let decoder = decoded(&stream.bytes());
            assert_eq!(decoder.part(0).unwrap().triangle_count(), 8);
        }
    }
}

#[test]
fn attributes_that_are_not_finite_are_refused() {
    let mesh = |value| {
        let data = AttributeData::F32(vec![0.0, value, 0.0, 0.0]);
        let attribute = Attribute { name: "heat".into(), components: 1, normalized: false, data };
        grid(1, 1).with_attribute(attribute).unwrap()
    };
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mesh = mesh(value);
        let tree = batches(&mesh);
        let found = message(encode(&mesh, &tree.sequence, &tree.level_ends, 0, &StreamOptions::default()));
        let value = value.to_string();
        assert_eq!(
            found,
            format!(
                "parameter `attributes`: found {value} of vertex 1 in attribute `heat`, expected finite numbers"
            )
        );
    }
}

#[test]
fn attributes_of_any_size_are_restored_or_refused() {
    let data = AttributeData::F64(vec![-f64::MAX, f64::MAX, 0.0, 1.0]);
    let attribute = Attribute { name: "heat".into(), components: 1, normalized: false, data };
    let mesh = grid(1, 1).with_attribute(attribute).unwrap();
    let tree = batches(&mesh);
    let found = message(encode(&mesh, &tree.sequence, &tree.level_ends, 0, &StreamOptions::default()));
    assert!(found.starts_with("parameter `attributes`: "), "{found}");
}

#[test]
fn positions_of_any_size_are_restored_or_refused() {
    for size in [f32::MIN_POSITIVE, 1e-40, 1e30, f32::MAX / 4.0, f32::MAX] {
        let mesh = grid(3, 3);
        let positions: Vec<_> =
            mesh.positions().iter().map(|p| p.map(|x| (x / 3.0 - 0.5) * 2.0 * size)).collect();
        let mesh = Mesh::new(positions, mesh.faces().clone()).unwrap();
        let sequence = CollapseSequence::from_collapses(16, mesh.faces().corners().to_vec(), []).unwrap();
        match encode(&mesh, &sequence, &[], 0, &StreamOptions::default()) {
            Ok(stream) => {
                let decoder = decoded(&stream.bytes());
                assert!(decoder.part(0).unwrap().mesh().is_ok(), "{size}");
            }
            Err(fault) => {
                assert!(fault.to_string().starts_with("parameter `positions`: ") && size > 1e38, "{fault}")
            }
        }
    }
}

#[test]
fn too_many_attributes_are_refused() {
    let attribute = |name: String| Attribute {
        name,
        components: 1,
        normalized: false,
        data: AttributeData::U8(vec![0; 4]),
    };
    let many = (0..65).fold(grid(1, 1), |mesh, i| mesh.with_attribute(attribute(format!("_{i}"))).unwrap());
    let long = grid(1, 1).with_attribute(attribute("x".repeat(257))).unwrap();
    for mesh in [many, long] {
        let tree = batches(&mesh);
        let found = message(encode(&mesh, &tree.sequence, &tree.level_ends, 0, &StreamOptions::default()));
        assert!(found.ends_with("expected at most 64, with names of at most 256 bytes"), "{found}");
    }
}
