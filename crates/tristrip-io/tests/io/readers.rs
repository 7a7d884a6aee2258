//! Data that each reader keeps, drops and reports, on small files.

use tristrip::{AttributeData, Mesh};
use tristrip_io::{Format, Model, read};

fn model(text: &str, format: Format) -> Model {
    read(text.as_bytes(), format).unwrap_or_else(|error| panic!("{error}"))
}

fn faces(mesh: &Mesh) -> Vec<Vec<u32>> {
    mesh.faces().iter().map(<[u32]>::to_vec).collect()
}

fn bits(mesh: &Mesh, vertex: usize) -> [u32; 3] {
    mesh.positions()[vertex].map(f32::to_bits)
}

fn names(mesh: &Mesh) -> Vec<&str> {
    mesh.attributes().iter().map(|attribute| attribute.name.as_str()).collect()
}

#[test]
fn obj_without_seams_keeps_its_vertices() {
    let text = "v 9 9 9\nv 0 0 0 0.5\nv 1 0 0\nv 0 1 0\nf 2 3 4\nf -1 -2\nf\nf -3 \\\n -2 -1 2\nl 1 2\np 1\nvt 0 0\n";
    let model = model(text, Format::Obj);
    let mesh = &model.parts[0].mesh;
    assert_eq!(mesh.vertex_count(), 4);
    assert_eq!(faces(mesh), [vec![1, 2, 3], vec![3, 2], vec![], vec![1, 2, 3, 1]]);
    assert_eq!(
        model.notes,
        [
            "line elements dropped: 1",
            "point elements dropped: 1",
            "weights and additional values of vertices dropped: 1",
            "unused texture coordinates dropped: 1",
        ]
    );
}

#[test]
fn obj_seams_make_vertices_in_order_of_first_use() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 7 7 7\nvt 0 0\nvt 0.5 0.25 0\nvt nan 0\nvn 0 0 1\n\
        f 4/1/1 1/2/1 2/1/1\nf 4/1/1 2/3/1 3//1\n";
    let model = model(text, Format::Obj);
    let mesh = &model.parts[0].mesh;
    assert_eq!(faces(mesh), [[0, 1, 2], [0, 3, 4]]);
    assert_eq!(bits(mesh, 3), bits(mesh, 2));
    assert_eq!(names(mesh), ["NORMAL", "TEXCOORD_0"]);
    let texcoords = vec![0.0, 0.0, 0.5, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    assert_eq!(mesh.attributes()[1].data, AttributeData::F32(texcoords));
    assert_eq!(
        model.notes,
        [
            "texture coordinates and normals that are not finite, replaced by 0: 1",
            "corners without a texture coordinate, set to 0: 1",
            "unused vertices dropped: 1",
        ]
    );
}

#[test]
fn obj_materials_make_parts_in_order_of_first_use() {
    let text = "mtllib a.mtl\no box\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl never used\nusemtl wood and oak\n\
        f 3 2 4\nusemtl iron\nf 1 2 3\ng lid\nusemtl wood and oak\nf 1 3 2\n";
    let model = model(text, Format::Obj);
    let [wood, iron] = &model.parts[..] else { panic!() };
    assert_eq!((wood.material.as_deref(), iron.material.as_deref()), (Some("wood and oak"), Some("iron")));
    assert_eq!((wood.name.as_deref(), faces(&wood.mesh)), (Some("box"), vec![vec![0, 1, 2], vec![3, 0, 1]]));
    assert_eq!((iron.mesh.vertex_count(), faces(&iron.mesh)), (3, vec![vec![0, 1, 2]]));
    assert_eq!(model.notes, ["objects and groups merged, faces grouped by material: 2"]);
    let materials = model.materials.unwrap_or_default();
    assert!(materials.libraries == ["a.mtl"] && materials.is_empty());
}

#[test]
fn obj_faces_may_refer_to_later_vertices() {
    let model = model("f 1/1 2/1 3/1\nv 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 0 0 1\nvt 1 1\n", Format::Obj);
    let mesh = &model.parts[0].mesh;
    assert_eq!(names(mesh), ["TEXCOORD_0", "COLOR_0"]);
    let colours = vec![1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0];
    assert_eq!(mesh.attributes()[1].data, AttributeData::F32(colours));
}

#[test]
fn many_obj_parts_hold_only_the_vertices_they_use() {
    let vertices = (0..3000).map(|i| format!("v {i} 0 0\n"));
    let faces = (1..1000).map(|i| format!("usemtl m{i}\nf {i} {} {}\n", i + 1, i + 2));
    let text: String = vertices.chain(faces).collect();
    let model = model(&text, Format::Obj);
    assert_eq!(model.parts.len(), 999);
    assert!(model.parts.iter().all(|part| part.mesh.vertex_count() == 3));
}

const STRIPS: &str = "ply\nformat ascii 1.0\nelement tristrips 2\nproperty list int int vertex_indices\n\
    element camera 1\nproperty float fov\nproperty list uchar int shots\nelement nothing 4000000000\n\
    element vertex 5\nproperty double x\nproperty list uchar int near\nproperty uchar blue\nproperty int y\n\
    property uchar red\nproperty uchar green\nproperty float quality\nproperty float32 z\nend_header\n\
    9 0 1 2 3 -1 2 1 4 -1\n6 4 4 1 2 -1 0\n45 2 7 7\n\
    0 0 3 0 1 2 0.5 0\n1.5 1 9 3 1 1 2 nan 0\n0 0 3 1 1 2 0 0\n1 0 3 1 1 2 0 0\n2 0 3 1 1 2 0 0.1\n";

#[test]
fn ply_strips_become_triangles_with_their_winding() {
    let model = model(STRIPS, Format::Ply);
    let mesh = &model.parts[0].mesh;
    // The second row starts with a swap: its only real triangle has an odd index.
    assert_eq!(faces(mesh), [[0, 1, 2], [2, 1, 3], [2, 1, 4], [1, 4, 2]]);
    assert_eq!(bits(mesh, 4), [2.0, 1.0, 0.1].map(f32::to_bits));
    assert_eq!(names(mesh), ["COLOR_0", "quality"]);
    assert_eq!(mesh.attributes()[0].data, AttributeData::U8([1, 2, 3].repeat(5)));
    assert_eq!(
        model.notes,
        [
            "strips of fewer than three vertices, without triangles: 1",
            "rows of element `camera` dropped: 1",
            "rows of element `nothing` dropped: 4000000000",
            "list property `near` of vertices dropped",
            "values in vertex lists dropped: 1",
        ]
    );
}

#[test]
fn ply_doubles_are_rounded_and_counted() {
    let text = "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty double z\n\
        property double nx\nproperty double ny\nproperty double nz\nproperty float u\nproperty float v\n\
        property double time\nend_header\n0.1 0 0 0 0 1 .5 nan 0.1\n0.5 0 0 0 0 1 1 1 0.1\n";
    let model = model(text, Format::Ply);
    let mesh = &model.parts[0].mesh;
    assert_eq!(names(mesh), ["NORMAL", "TEXCOORD_0", "time"]);
    assert_eq!(mesh.attributes()[2].data, AttributeData::F64(vec![0.1, 0.1]));
    assert_eq!(
        model.notes,
        [
            "vertices rounded to 32-bit floats: 1",
            "values of TEXCOORD_0 that are not finite, replaced by 0: 1"
        ]
    );
}

#[test]
fn ply_rows_may_wrap_and_lists_may_be_anywhere() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 2\nproperty uchar red\nproperty list uchar int vertex_index\nproperty list uchar float uv\n\
        end_header\n0 0 0\n1 0\n0\n0 1 0\n9 3 0 1\n2 2 .5 .5\n\n9 1 2 0\n";
    let model = model(text, Format::Ply);
    assert_eq!(faces(&model.parts[0].mesh), [vec![0, 1, 2], vec![2]]);
    assert_eq!(
        model.notes,
        ["values of face property `red` dropped: 2", "values of face property `uv` dropped: 2"]
    );
}

/// Returns a PLY file of rows of numbers in their types.
fn ply(encoding: &str, vertices: &[[f64; 8]], lists: &[(&str, Vec<f64>)]) -> Vec<u8> {
    let kinds = ["float", "double", "short", "uchar", "float", "float", "float", "int"];
    let names = ["x", "y", "z", "tag", "nx", "ny", "nz", "id"];
    let mut header = format!("ply\nformat {encoding} 1.0\nelement vertex {}\n", vertices.len());
    header.extend(kinds.iter().zip(names).map(|(kind, name)| format!("property {kind} {name}\n")));
    for name in ["face", "tristrips"] {
        let rows = lists.iter().filter(|(element, _)| *element == name).count();
        let count = if name == "face" { "uchar" } else { "int" };
        let element = format!("element {name} {rows}\nproperty list {count} int vertex_indices\n");
        header.push_str(&element);
    }
    let mut out = (header + "end_header\n").into_bytes();
    let mut put = |kind: &str, value: f64, end: &str| {
        let mut bytes = match kind {
            "float" => (value as f32).to_le_bytes().to_vec(),
            "double" => value.to_le_bytes().to_vec(),
            "short" => (value as i16).to_le_bytes().to_vec(),
            "uchar" => (value as i16).to_le_bytes()[..1].to_vec(),
            _ => (value as i32).to_le_bytes().to_vec(),
        };
        match encoding {
            "ascii" => bytes = format!("{value}{end}").into_bytes(),
            "binary_big_endian" => bytes.reverse(),
            _ => {}
        }
        out.extend(bytes);
    };
    for row in vertices {
        for (i, (kind, &value)) in kinds.iter().zip(row).enumerate() {
            put(kind, value, if i == 7 { "\n" } else { " " });
        }
    }
    for element in ["face", "tristrips"] {
        for (_, list) in lists.iter().filter(|(name, _)| *name == element) {
            let end = |i: usize| if i == list.len() { "\n" } else { " " };
            put(if element == "face" { "uchar" } else { "int" }, list.len() as f64, end(0));
            (1..).zip(list).for_each(|(i, &value)| put("int", value, end(i)));
        }
    }
    out
}

#[test]
fn ply_means_the_same_in_text_and_in_both_byte_orders() {
    let mut vertices = vec![[0.5, 0.1, -7.0, 250.0, 0.0, 1.0, 0.25, -9.0]; 5];
    vertices[2][4] = f64::NAN;
    let triangle = || ("face", vec![0.0, 1.0, 2.0]);
    let faces =
        vec![triangle(), triangle(), ("face", vec![4.0, 3.0, 2.0, 1.0]), ("face", vec![]), triangle()];
    let strips =
        vec![("tristrips", vec![-1.0, 0.0, 1.0, 2.0, 3.0, -1.0, -1.0, 4.0, 1.0]), ("tristrips", vec![])];
    let load = |encoding: &str, vertices: &[[f64; 8]], lists: &[(&str, Vec<f64>)]| {
        read(&ply(encoding, vertices, lists), Format::Ply)
    };
    for lists in [faces.clone(), strips] {
        let text = load("ascii", &vertices, &lists).unwrap();
        let expected = [
            "vertices rounded to 32-bit floats: 5",
            "values of NORMAL that are not finite, replaced by 0: 1",
        ];
        assert_eq!(text.notes[..2], expected);
        for encoding in ["binary_little_endian", "binary_big_endian"] {
            let model = load(encoding, &vertices, &lists).unwrap();
            assert_eq!(model.parts[0].mesh, text.parts[0].mesh);
            assert_eq!((&model.notes, &model.parts[0].stored), (&text.notes, &text.parts[0].stored));
        }
    }
    // The found value is also the same; only the location differs.
    let what = |encoding: &str, vertices: &[[f64; 8]], lists: &[(&str, Vec<f64>)]| {
        let message = load(encoding, vertices, lists).unwrap_err().to_string();
        message.split_once(": ").unwrap().1.to_owned()
    };
    let mut infinite = vertices.clone();
    infinite[3][1] = f64::INFINITY;
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let expected = "found inf, expected a finite 32-bit number for `y`";
        assert_eq!(what(encoding, &infinite, &faces), expected, "{encoding}");
        for (name, index) in [("face", 5), ("face", -2), ("tristrips", 5), ("tristrips", -2)] {
            let lists = [triangle(), (name, vec![0.0, 1.0, f64::from(index)])];
            let expected = format!("found vertex index {index}, expected at least 0 and less than 5");
            assert_eq!(what(encoding, &vertices, &lists), expected, "{encoding}");
        }
    }
}
