use super::*;
use crate::stream::grid::{AttributeBits, Channel};

const BITS: AttributeBits = AttributeBits { normal: 10, uv: 14, other: 10 };

/// Returns values as numbers that are equal only if the values are.
fn value_bits(data: &AttributeData) -> Vec<i64> {
    match data {
        AttributeData::F32(values) => values.iter().map(|x| i64::from(x.to_bits())).collect(),
        AttributeData::U8(values) => values.iter().map(|&x| x.into()).collect(),
        other => panic!("{other:?}"),
    }
}

/// Returns the triangles, sorted, with the numbers of their corners' positions and attributes.
fn with_values(keys: &mut Keys, grid: &Grid, mesh: &Mesh) -> Vec<[u32; 3]> {
    let values: Vec<(usize, Vec<i64>)> =
        mesh.attributes().iter().map(|a| (usize::from(a.components), value_bits(&a.data))).collect();
    let mut corner = |v: u32| {
        let mut key: Vec<i64> = grid.place(mesh.positions()[v as usize], 14).map(i64::from).to_vec();
        values.iter().for_each(|(n, values)| key.extend(&values[v as usize * n..][..*n]));
        keys.number(key)
    };
    let triangles: Vec<_> = triangles_of(mesh.faces().corners()).map(|t| t.map(&mut corner)).collect();
    sorted(triangles)
}

/// Returns a mesh with its attributes rounded to their grids.
fn rounded(mesh: &Mesh) -> Mesh {
    let plain = Mesh::new(mesh.positions().to_vec(), mesh.faces().clone()).unwrap();
    mesh.attributes().iter().fold(plain, |plain, attribute| {
        let channel = Channel::new(attribute, BITS).unwrap();
        let integers: Vec<i32> =
            (0..mesh.vertex_count()).flat_map(|v| channel.integers(attribute, v)).collect();
        plain.with_attribute(channel.attribute(&integers)).unwrap()
    })
}

#[test]
fn attributes_are_restored_on_both_sides_of_a_seam() {
    let mesh = with_attributes(9, 7);
    for options in [small_chunks(), StreamOptions::default()] {
        let (batches, stream) = stream_of(&mesh, 0, &options);
        let part = check_stream(&mesh, &batches, &stream).unwrap();
        assert!(stream.chunks[0].triangles < 60);
        let names: Vec<_> = mesh.attributes().iter().map(|a| a.name.as_str()).collect();
        assert_eq!(part.attribute_names().collect::<Vec<_>>(), names);
        assert_eq!(part.vertex_count(), mesh.vertex_count());
        let found = part.mesh().unwrap();
        let (grid, mut keys) = (grid_of(&mesh, 14), Keys::default());
        let to_encode = with_values(&mut keys, &grid, &rounded(&mesh));
        assert_eq!(with_values(&mut keys, &grid, &found), to_encode);
    }
}

#[test]
fn every_level_has_a_value_per_vertex() {
    let (_, stream) = stream_of(&with_attributes(9, 7), 0, &small_chunks());
    let mut decoder = Decoder::new(StreamLimits::default());
    for chunk in &stream.chunks {
        decoder.update(&chunk.bytes).unwrap();
        let mesh = decoder.part(0).unwrap().mesh().unwrap();
        assert_eq!(mesh.attributes().len(), 6);
    }
}

fn floats(data: &AttributeData) -> &[f32] {
    match data {
        AttributeData::F32(values) => values,
        other => panic!("{other:?}"),
    }
}

#[test]
fn values_are_within_the_steps_of_their_grids() {
    let mesh = with_attributes(12, 12);
    let near = rounded(&mesh);
    // An octahedron of 1023 steps, where two steps are at most 1/256; texture coordinates in 4095
    // steps; weights in 1023.
    let most = [0.004, 1.0 / 4095.0, 0.0, 0.0, 2.0 / 1023.0, 0.004];
    for ((a, b), most) in mesh.attributes().iter().zip(near.attributes()).zip(most) {
        assert_eq!((&a.name, a.components, a.normalized), (&b.name, b.components, b.normalized));
        if most == 0.0 {
            assert_eq!(a.data, b.data, "{}", a.name);
            continue;
        }
        for (x, y) in floats(&a.data).iter().zip(floats(&b.data)) {
            assert!((x - y).abs() <= most, "{}: {x} became {y}", a.name);
        }
    }
    // Weights still add up to one, and the signs of tangents are preserved.
    let weights = floats(&near.attributes()[4].data);
    assert!(weights.chunks_exact(4).all(|weights| (weights.iter().sum::<f32>() - 1.0).abs() < 1e-6));
    let signs = |mesh: &Mesh| {
        floats(&mesh.attributes()[5].data).iter().skip(3).step_by(4).copied().collect::<Vec<_>>()
    };
    assert_eq!(signs(&mesh), signs(&near));
}

fn one_attribute(name: &str, data: AttributeData) -> Mesh {
    let attribute = crate::Attribute { name: name.into(), components: 1, normalized: false, data };
    grid(2, 1).with_attribute(attribute).unwrap()
}

#[test]
fn integers_of_any_type_are_exact() {
    let data = [
        AttributeData::I8(vec![-128, 127, 0, 1, -1, 5]),
        AttributeData::U16(vec![0, 65535, 1, 2, 3, 4]),
        AttributeData::I16(vec![-32768, 32767, 1, 2, 3, 4]),
        AttributeData::U32(vec![
            4_000_000_000,
            4_000_000_001,
            4_010_000_000,
            4_000_000_003,
            4_000_000_004,
            4_000_000_005,
        ]),
        AttributeData::I32(vec![
            -2_000_000_000,
            -1_999_999_999,
            -1_990_000_000,
            -2_000_000_000,
            -1_999_999_990,
            -1_999_999_000,
        ]),
    ];
    for data in data {
        let mesh = one_attribute("_ID", data);
        assert_eq!(rounded(&mesh).attributes(), mesh.attributes());
        let (_, stream) = stream_of(&mesh, 0, &small_chunks());
        let found = decoded(&stream.bytes()).part(0).unwrap().mesh().unwrap();
        assert_eq!(found.vertex_count(), 6);
        assert_eq!(
            std::mem::discriminant(&found.attributes()[0].data),
            std::mem::discriminant(&mesh.attributes()[0].data)
        );
    }
}

#[test]
fn whole_floats_are_exact_and_repeated_textures_have_as_many_steps() {
    let mesh = one_attribute("_FEATURE_ID_0", AttributeData::F32(vec![0.0, 2697.0, 1.0, 1200.0, 3.0, 9.0]));
    assert_eq!(rounded(&mesh).attributes(), mesh.attributes());
    let mesh = one_attribute("TEXCOORD_0", AttributeData::F32(vec![0.0, 499.75, 0.3, 1.7, 120.1, 9.9]));
    for (x, y) in floats(&mesh.attributes()[0].data).iter().zip(floats(&rounded(&mesh).attributes()[0].data))
    {
        assert!((x - y).abs() < 1.0 / 4095.0, "{x} became {y}");
    }
}

#[test]
fn weights_that_are_no_shares_are_kept() {
    let mesh = one_attribute("WEIGHTS_0", AttributeData::F32(vec![-1.0, 3.0, 0.5, 1.0, 2.0, 0.0]));
    let near = rounded(&mesh);
    for (x, y) in floats(&mesh.attributes()[0].data).iter().zip(floats(&near.attributes()[0].data)) {
        assert!((x - y).abs() < 0.004, "{x} became {y}");
    }
}

#[test]
fn normals_of_no_length_are_kept() {
    let normals = AttributeData::F32([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0]].concat().repeat(3));
    let attribute =
        crate::Attribute { name: "NORMAL".into(), components: 3, normalized: false, data: normals };
    let mesh = grid(2, 1).with_attribute(attribute).unwrap();
    for (x, y) in floats(&mesh.attributes()[0].data).iter().zip(floats(&rounded(&mesh).attributes()[0].data))
    {
        assert!((x - y).abs() < 0.002, "{x} became {y}");
    }
}
