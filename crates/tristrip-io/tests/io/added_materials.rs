//! Materials that a program adds to a model: written to GLB and OBJ, and read back.

use std::fs;
use std::sync::Arc;

use tristrip::{Attribute, AttributeData, Faces, Layout, Mesh};
use tristrip_io::gltf::with_scene;
use tristrip_io::{
    Drawing, Format, Materials, Model, Part, PlainMaterial, load_materials, material_losses, plain_materials,
    read, read_file, write,
};

const UV: [f32; 6] = [0.0, 0.0, 1.0, 0.25, 0.5, 1.0];

fn image(name: &[u8]) -> Arc<Vec<u8>> {
    Arc::new([b"\x89PNG\r\n\x1a\n", name].concat())
}

fn textured() -> PlainMaterial {
    let base_colour = [1.0, 0.5, 0.25, 0.5];
    PlainMaterial { base_colour, metalness: 0.5, roughness: 0.25, is_blended: true, image: Some(image(b"a")) }
}

/// Returns a part per material, with texture coordinates of a type.
fn model(materials: &[(&str, PlainMaterial)], data: AttributeData, counts_down: bool) -> Model {
    let mesh = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], Faces::default()).unwrap();
    let mesh = mesh.with_faces(Faces::from_triangles(vec![0, 1, 2]).unwrap()).unwrap();
    let normalized = !matches!(data, AttributeData::F32(_));
    let uv = Attribute { name: "TEXCOORD_0".into(), components: 2, normalized, data };
    let mesh = mesh.with_attribute(uv).unwrap();
    let mut known = Materials::default();
    known.counts_down = counts_down;
    let part = |(name, material): &(&str, PlainMaterial)| {
        assert!(known.add_plain(name, material));
        Part { material: Some((*name).into()), mesh: mesh.clone(), ..Part::default() }
    };
    let parts = materials.iter().map(part).collect();
    Model { parts, materials: Some(known), ..Model::default() }
}

fn glb(model: &Model) -> Model {
    let drawings = vec![Drawing::Faces; model.parts.len()];
    read(&write(model, &drawings, Format::Glb, Layout::List).unwrap(), Format::Glb).unwrap()
}

fn coordinates(model: &Model) -> &AttributeData {
    &model.parts[0].mesh.attributes()[0].data
}

#[test]
fn a_glb_has_the_materials_and_each_image_once() {
    let other = PlainMaterial { image: Some(image(b"b")), ..PlainMaterial::default() };
    let plain = PlainMaterial { base_colour: [0.0, 1.0, 0.0, 1.0], ..PlainMaterial::default() };
    let same = PlainMaterial { image: textured().image, ..PlainMaterial::default() };
    let all = [("a", textured()), ("b", other), ("c", plain), ("d", same)];
    let before = model(&all, AttributeData::F32(UV.to_vec()), true);
    let after = glb(&before);
    let expected: Vec<_> = all.iter().map(|(_, material)| Some(material.clone())).collect();
    assert_eq!(plain_materials(&before).unwrap().0, expected);
    assert_eq!(plain_materials(&after).unwrap(), (expected, Vec::new()));
    assert_eq!(after.scene.unwrap().appearance().unwrap().images.len(), 2);
    assert!(material_losses(&before, Format::Glb).is_empty());
    assert_eq!(
        material_losses(&before, Format::Ply),
        ["materials are not written: PLY does not support them"]
    );
}

#[test]
fn texture_coordinates_count_as_the_materials_say() {
    let floats = AttributeData::F32(UV.to_vec());
    let kept = glb(&model(&[("a", textured())], floats.clone(), true));
    assert_eq!(*coordinates(&kept), floats);
    let flipped = glb(&model(&[("a", textured())], floats, false));
    assert_eq!(*coordinates(&flipped), AttributeData::F32(vec![0.0, 1.0, 1.0, 0.75, 0.5, 0.0]));
    let bytes = glb(&model(&[("a", textured())], AttributeData::U8(vec![0, 0, 255, 1, 7, 255]), false));
    assert_eq!(*coordinates(&bytes), AttributeData::U8(vec![0, 255, 255, 254, 7, 0]));
    let words = AttributeData::U16(vec![0, 0, 9, 1, 7, 65535]);
    let words = glb(&model(&[("a", textured())], words, false));
    assert_eq!(*coordinates(&words), AttributeData::U16(vec![0, 65535, 9, 65534, 7, 0]));
}

#[test]
fn an_obj_gets_a_library_of_its_name() {
    for counts_down in [false, true] {
        let plain = PlainMaterial { base_colour: [0.0, 1.0, 0.0, 1.0], ..PlainMaterial::default() };
        let uv = AttributeData::F32(UV.to_vec());
        let mut before = model(&[("wood", textured()), ("paint", plain)], uv, counts_down);
        let dir = tempfile::tempdir().unwrap();
        load_materials(&mut before, None, "out");
        let obj = write(&before, &[Drawing::Faces; 2], Format::Obj, Layout::List).unwrap();
        fs::write(dir.path().join("out.obj"), obj).unwrap();
        let files = &before.materials.as_ref().unwrap().files;
        let names: Vec<&str> = files.iter().map(|file| &*file.name).collect();
        assert_eq!(names, ["out_0.png", "out.mtl"]);
        for file in files {
            fs::write(dir.path().join(&file.name), &**file.bytes).unwrap();
        }
        let path = dir.path().join("out.obj");
        let mut after = read_file(&path, None).unwrap().model;
        load_materials(&mut after, Some(&path), "");
        assert_eq!(plain_materials(&after).unwrap(), plain_materials(&before).unwrap());
        let expected = if counts_down { vec![0.0, 1.0, 1.0, 0.75, 0.5, 0.0] } else { UV.to_vec() };
        assert_eq!(*coordinates(&after), AttributeData::F32(expected));
    }
}

#[test]
fn materials_of_one_name_are_one() {
    let mut known = Materials::default();
    assert!(known.add_plain("a", &textured()) && known.add_plain("a", &textured()));
    assert!(!known.add_plain("a", &PlainMaterial::default()));
    assert_eq!((known.plain("a"), known.plain("b"), known.files.len()), (Some(textured()), None, 1));
}

/// A scene built in memory equals the scene read from the file: materials, flipped coordinates,
/// polygons, shared vertices, and parts without vertices or faces.
#[test]
fn a_scene_in_memory_is_that_of_the_file() {
    let all = [("a", textured()), ("b", PlainMaterial::default()), ("a", textured())];
    let coordinates = [AttributeData::F32(UV.to_vec()), AttributeData::U16(vec![0, 1, 7, 65535, 3, 4])];
    let mut models: Vec<Model> = coordinates
        .into_iter()
        .flat_map(|data| [false, true].map(|down| model(&all, data.clone(), down)))
        .collect();
    let obj =
        b"o one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 2\nf 1//1 2//1 3//1 4//1\nusemtl m\nf 1 2 3\n";
    models.push(read(obj, Format::Obj).unwrap());
    models.push(Model { parts: vec![Part::default()], ..Model::default() });
    models[4].parts.push(Part::default());
    for model in models {
        let (built, read) = (with_scene(&model).unwrap(), glb(&model));
        assert_eq!(built.parts.len(), read.parts.len());
        for (built, read) in built.parts.iter().zip(&read.parts) {
            assert_eq!((&built.name, &built.material, &built.mesh), (&read.name, &read.material, &read.mesh));
        }
        let faces = vec![Drawing::Faces; read.parts.len()];
        let again = |model: &Model| write(model, &faces, Format::Glb, Layout::List).unwrap();
        assert_eq!(again(&built), again(&read));
    }
}
