//! Meshes written and read back: bit-identical with PLY, and with OBJ for the data that it
//! supports.

use proptest::prelude::*;
use tristrip::{Attribute, AttributeData, Faces, Layout, Mesh, Strips};
use tristrip_io::{Drawing, Format, Model, Part, losses, read, write};

fn model(mesh: Mesh) -> Model {
    Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() }
}

fn round_trip(model: &Model, drawings: &[Drawing], format: Format, layout: Layout) -> Model {
    let bytes = write(model, drawings, format, layout).unwrap();
    read(&bytes, format).unwrap_or_else(|error| panic!("{error}\n{}", String::from_utf8_lossy(&bytes)))
}

fn bits(mesh: &Mesh) -> Vec<[u32; 3]> {
    mesh.positions().iter().map(|position| position.map(f32::to_bits)).collect()
}

/// Returns any finite number, by its bits.
fn finite() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |x| x.is_finite())
}

fn attribute(name: &str, components: u8, normalized: bool, data: AttributeData) -> Attribute {
    Attribute { name: name.into(), components, normalized, data }
}

prop_compose! {
    fn meshes(smallest_face: usize)(n in 1usize..40)(
        positions in prop::collection::vec([finite(), finite(), finite()], n),
        faces in prop::collection::vec(prop::collection::vec(0..n as u32, smallest_face..8), 0..40),
    ) -> Mesh {
        Mesh::new(positions, Faces::from_polygons(faces).unwrap()).unwrap()
    }
}

prop_compose! {
    fn meshes_with_attributes()(mesh in meshes(0))(
        normals in prop::collection::vec(finite(), 3 * mesh.vertex_count()),
        texcoords in prop::collection::vec(finite(), 2 * mesh.vertex_count()),
        colours in prop::collection::vec(any::<u8>(), 4 * mesh.vertex_count()),
        weights in prop::collection::vec(any::<i16>(), mesh.vertex_count()),
        times in prop::collection::vec(-1e300..1e300f64, mesh.vertex_count()),
        chosen in any::<[bool; 5]>(),
        mesh in Just(mesh),
    ) -> Mesh {
        let all = [
            attribute("NORMAL", 3, false, AttributeData::F32(normals)),
            attribute("TEXCOORD_0", 2, false, AttributeData::F32(texcoords)),
            attribute("COLOR_0", 4, true, AttributeData::U8(colours)),
            attribute("weight", 1, false, AttributeData::I16(weights)),
            attribute("time", 1, false, AttributeData::F64(times)),
        ];
        let chosen = all.into_iter().zip(chosen).filter_map(|(attribute, chosen)| chosen.then_some(attribute));
        chosen.fold(mesh, |mesh, attribute| mesh.with_attribute(attribute).unwrap())
    }
}

/// Writes positions and faces as PLY text or big-endian binary in the simplest way, as a reference
/// for the reader.
fn reference_ply(mesh: &Mesh, ascii: bool) -> Vec<u8> {
    let encoding = if ascii { "ascii" } else { "binary_big_endian" };
    let (vertices, faces) = (mesh.vertex_count(), mesh.faces().face_count());
    let mut out = format!(
        "ply\nformat {encoding} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar uint vertex_indices\nend_header\n"
    )
    .into_bytes();
    for position in mesh.positions() {
        if ascii {
            out.extend(format!("{} {:e} {:?}\n", position[0], position[1], position[2]).bytes());
        } else {
            out.extend(position.iter().flat_map(|x| x.to_be_bytes()));
        }
    }
    for face in mesh.faces().iter() {
        if ascii {
            let corners: Vec<String> = face.iter().map(u32::to_string).collect();
            out.extend(format!("{} {}\n", face.len(), corners.join(" ")).bytes());
        } else {
            out.push(face.len() as u8);
            out.extend(face.iter().flat_map(|v| v.to_be_bytes()));
        }
    }
    out
}

/// Returns the corners of all faces as positions, normals and texture coordinates.
fn corners(mesh: &Mesh) -> Vec<Vec<u32>> {
    let row = |name: &str, v: u32| -> Vec<u32> {
        let found = mesh.attributes().iter().find(|attribute| attribute.name == name);
        let Some(Attribute { components, data: AttributeData::F32(values), .. }) = found else {
            return vec![];
        };
        let (n, v) = (usize::from(*components), v as usize);
        values[v * n..(v + 1) * n].iter().map(|x| x.to_bits()).collect()
    };
    let corner = |&v: &u32| {
        let position = mesh.positions()[v as usize].map(f32::to_bits).to_vec();
        [position, row("NORMAL", v), row("TEXCOORD_0", v)].concat()
    };
    mesh.faces().corners().iter().map(corner).collect()
}

proptest! {
    #[test]
    fn ply_keeps_every_bit(mesh in meshes_with_attributes()) {
        let before = model(mesh);
        let after = round_trip(&before, &[Drawing::Faces], Format::Ply, Layout::List);
        let (before, after) = (&before.parts[0].mesh, &after.parts[0].mesh);
        prop_assert_eq!(before, after);
        prop_assert_eq!(bits(before), bits(after));
    }

    #[test]
    fn ply_encodings_agree(mesh in meshes(0)) {
        for ascii in [true, false] {
            let after = read(&reference_ply(&mesh, ascii), Format::Ply).unwrap();
            prop_assert_eq!(&mesh, &after.parts[0].mesh);
            prop_assert_eq!(bits(&mesh), bits(&after.parts[0].mesh));
        }
    }

    #[test]
    fn obj_keeps_vertices_and_faces(mesh in meshes(3)) {
        let after = round_trip(&model(mesh.clone()), &[Drawing::Faces], Format::Obj, Layout::List);
        prop_assert_eq!(&mesh, &after.parts[0].mesh);
        prop_assert_eq!(bits(&mesh), bits(&after.parts[0].mesh));
    }

    #[test]
    fn obj_keeps_what_each_corner_has(mesh in meshes_with_attributes()) {
        let kept = mesh.faces().iter().filter(|face| face.len() >= 3).map(<[u32]>::to_vec);
        let kept = Faces::from_polygons(kept).unwrap();
        let attributes = mesh.attributes().to_vec();
        let kept = Mesh::new(mesh.shared_positions(), kept).unwrap();
        let kept = attributes.into_iter().fold(kept, |mesh, a| mesh.with_attribute(a).unwrap());
        prop_assume!(kept.faces().face_count() > 0);
        let after = round_trip(&model(mesh), &[Drawing::Faces], Format::Obj, Layout::List);
        prop_assert_eq!(corners(&kept), corners(&after.parts[0].mesh));
    }

    #[test]
    fn strips_are_read_back_as_their_triangles(
        strips in prop::collection::vec(prop::collection::vec(0..9u32, 0..12), 0..9),
    ) {
        let mut all = Strips::default();
        for strip in &strips {
            all.push(strip);
        }
        // Joined strips are drawn in another order, and triangles may start at another corner.
        let sorted = |corners: &[u32]| {
            let mut all: Vec<[u32; 3]> = corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
            all.iter_mut().for_each(|t| while t[0] > t[1] || t[0] > t[2] { t.rotate_left(1) });
            all.sort_unstable();
            all
        };
        let expected: Vec<u32> = all.triangles().flatten().collect();
        let before = model(Mesh::new(vec![[1.0; 3]; 9], Faces::default()).unwrap());
        for format in [Format::Ply, Format::Obj] {
            for layout in [Layout::Restart, Layout::Degenerate, Layout::Separate, Layout::List] {
                let after = round_trip(&before, &[Drawing::Strips(&all)], format, layout);
                let faces = after.parts[0].mesh.faces().as_triangles().map(<[u32]>::to_vec);
                if layout == Layout::Degenerate {
                    prop_assert_eq!(faces.map(|f| sorted(&f)), Some(sorted(&expected)), "{:?}", format);
                } else {
                    prop_assert_eq!(faces.as_ref(), Some(&expected), "{:?} {:?}", format, layout);
                }
            }
        }
    }
}

/// Returns two parts that share vertices, and one with separate vertices.
fn three_parts() -> Model {
    let faces = |t: [u32; 3]| Faces::from_triangles(t.to_vec()).unwrap();
    let normals = || attribute("NORMAL", 3, false, AttributeData::F32(vec![0.5; 12]));
    let square = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let first = Mesh::new(square, faces([0, 1, 2])).unwrap();
    let second = Mesh::new(first.shared_positions(), faces([0, 2, 3])).unwrap();
    let third = Mesh::new(vec![[5.0; 3]; 4], faces([1, 2, 3])).unwrap();
    let part = |mesh: Mesh, material: Option<&str>| Part {
        name: None,
        material: material.map(str::to_owned),
        mesh: mesh.with_attribute(normals()).unwrap(),
        ..Part::default()
    };
    let parts = vec![part(first, Some("red\nf 1 1 1")), part(second, None), part(third, Some("blue"))];
    Model { parts, ..Model::default() }
}

#[test]
fn parts_share_vertices_and_keep_their_materials_in_obj() {
    let before = three_parts();
    let bytes = write(&before, &[Drawing::Faces; 3], Format::Obj, Layout::List).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    assert_eq!(text.lines().filter(|line| line.starts_with("v ")).count(), 8);
    let after = read(text.as_bytes(), Format::Obj).unwrap();
    let materials: Vec<_> = after.parts.iter().map(|part| part.material.as_deref()).collect();
    assert_eq!(materials, [Some("red_f 1 1 1"), Some("part_1"), Some("blue")]);
    for (before, after) in before.parts.iter().zip(&after.parts) {
        assert_eq!(corners(&before.mesh), corners(&after.mesh));
    }
}

#[test]
fn ply_joins_parts_and_reports_it() {
    let before = three_parts();
    let mut strips = Strips::default();
    strips.push(&[0, 2, 3]);
    let drawings = [Drawing::Strips(&strips), Drawing::Strips(&strips), Drawing::Faces];
    for layout in [Layout::Restart, Layout::Degenerate, Layout::Separate, Layout::List] {
        let bytes = write(&before, &drawings, Format::Ply, layout).unwrap();
        let comment = b"\ncomment parts joined into one: 3\n";
        assert!(bytes.windows(comment.len()).any(|window| window == comment));
        let mesh = &read(&bytes, Format::Ply).unwrap().parts[0].mesh;
        assert_eq!(mesh.vertex_count(), 8);
        let mut faces: Vec<Vec<u32>> = mesh.faces().iter().map(<[u32]>::to_vec).collect();
        faces.sort();
        assert_eq!(faces, [[0, 2, 3], [0, 2, 3], [5, 6, 7]]);
    }
}

#[test]
fn losses_list_what_a_format_cannot_hold() {
    let mesh = Mesh::new(vec![[0.0; 3]; 2], Faces::from_polygons([[0, 1]]).unwrap()).unwrap();
    let mesh = mesh
        .with_attribute(attribute("_ID\n", 1, false, AttributeData::U32(vec![1, 2])))
        .unwrap()
        .with_attribute(attribute("COLOR_0", 4, true, AttributeData::U16(vec![9; 8])))
        .unwrap();
    assert_eq!(
        losses(&model(mesh.clone()), &[Drawing::Faces], Format::Obj),
        [
            "attribute _ID not written",
            "alpha of COLOR_0 not written",
            "faces of fewer than three corners not written: 1",
        ]
    );
    let bare = Part { mesh: Mesh::new(vec![[0.0; 3]], Faces::default()).unwrap(), ..Part::default() };
    let mut two = model(mesh);
    two.parts.push(bare);
    assert_eq!(
        losses(&two, &[Drawing::Faces; 2], Format::Ply),
        [
            "parts joined into one: 2",
            "attribute _ID not written: some parts lack it",
            "attribute COLOR_0 not written: some parts lack it",
        ]
    );
}

#[test]
fn losses_include_the_scene() {
    let json = br#"{"asset":{"version":"2.0"},"nodes":[{"scale":[2,2,2]}],"cameras":[{}]}"#;
    let scene = read(json, Format::Gltf).unwrap();
    let beyond = ["not written: nodes with a transform: 1", "not written: cameras: 1"];
    assert_eq!(losses(&scene, &[], Format::Ply), beyond);
    assert_eq!(losses(&scene, &[], Format::Obj), beyond);
    assert!(losses(&scene, &[], Format::Glb).is_empty());
    let ply = write(&scene, &[], Format::Ply, Layout::List).unwrap();
    assert!(String::from_utf8_lossy(&ply).contains("\ncomment not written: nodes with a transform: 1\n"));
}

#[test]
fn losses_know_which_parts_are_drawn_by_strips() {
    let quad = Faces::from_polygons([[0, 1, 2, 3]]).unwrap();
    let polygons = model(Mesh::new(vec![[0.0; 3]; 4], quad).unwrap());
    let mut strips = Strips::default();
    strips.push(&[0, 1, 3, 2]);
    assert_eq!(losses(&polygons, &[Drawing::Faces], Format::Glb), ["polygons cut into fans: 1"]);
    assert!(losses(&polygons, &[Drawing::Strips(&strips)], Format::Glb).is_empty());
    let small = model(Mesh::new(vec![[0.0; 3]; 2], Faces::from_polygons([[0, 1]]).unwrap()).unwrap());
    let note = ["faces of fewer than three corners not written: 1"];
    assert_eq!(losses(&small, &[Drawing::Faces], Format::Obj), note);
    assert!(losses(&small, &[Drawing::Strips(&Strips::default())], Format::Obj).is_empty());
}

#[test]
fn parts_keep_the_stored_strips() {
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2, 1, 3]);
    strips.push(&[4, 5, 6]);
    let faces = Faces::from_triangles(strips.to_list()).unwrap();
    let corners: Vec<_> = (0..7_u8).map(|i| [f32::from(i), f32::from(i * i), 0.0]).collect();
    let model = model(Mesh::new(corners, faces).unwrap());
    for format in [Format::Ply, Format::Glb] {
        let stored = |layout| {
            let bytes = write(&model, &[Drawing::Strips(&strips)], format, layout).unwrap();
            let parts = read(&bytes, format).unwrap().parts;
            parts.into_iter().map(|part| part.stored).collect::<Option<Vec<_>>>()
        };
        let restart = stored(Layout::Restart).unwrap().remove(0);
        assert_eq!((&restart.runs, restart.restarts, restart.fans), (&strips, 1, false));
        assert_eq!(restart.indices(), strips.to_restart(u32::MAX).len());
        let joined = stored(Layout::Degenerate).unwrap().remove(0);
        assert_eq!((joined.runs.vertices(), joined.runs.len()), (&strips.to_degenerate()[..], 1));
        let separate = stored(Layout::Separate).unwrap();
        let runs: Vec<&[u32]> = separate.iter().flat_map(|stored| stored.runs.iter()).collect();
        assert_eq!(runs, strips.iter().collect::<Vec<_>>());
        assert!(separate.iter().all(|stored| stored.restarts == 0));
        assert_eq!(stored(Layout::List), None);
    }
}

#[test]
fn parts_know_whether_they_are_drawn_as_strips() {
    let faces = Faces::from_triangles(vec![0, 1, 2, 2, 1, 3]).unwrap();
    let flat = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let model = model(Mesh::new(flat, faces).unwrap());
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2, 3]);
    let stripped = |drawing: Drawing, format, layout| {
        let bytes = write(&model, &[drawing], format, layout).unwrap();
        read(&bytes, format).unwrap().parts.iter().map(|part| part.stripped).collect::<Vec<_>>()
    };
    for format in [Format::Ply, Format::Glb] {
        for layout in [Layout::Restart, Layout::Degenerate, Layout::Separate] {
            assert_eq!(stripped(Drawing::Strips(&strips), format, layout), [true], "{format:?} {layout:?}");
        }
        assert_eq!(stripped(Drawing::Strips(&strips), format, Layout::List), [false]);
        assert_eq!(stripped(Drawing::Faces, format, Layout::List), [false]);
    }
    // A file with both polygons and strips keeps its polygons.
    let both =
        b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2\n";
    let both = read(both, Format::Ply).unwrap();
    assert_eq!((both.parts[0].stripped, both.parts[0].mesh.faces().face_count()), (false, 2));
    assert_eq!(both.parts[0].stored, None);
}

#[test]
fn formats_without_a_writer_list_those_with_one() {
    for format in [Format::Stl, Format::Off, Format::Gltf] {
        let error = write(&Model::default(), &[], format, Layout::List).unwrap_err();
        assert!(error.to_string().ends_with("cannot be written; use .obj, .ply or .glb"), "{error}");
    }
}
