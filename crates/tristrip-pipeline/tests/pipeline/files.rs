//! Files of results: which files are written, which are kept, and the errors.
#![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::fs;
use std::path::Path;

use tristrip::Layout;
use tristrip_io::{Drawing, Format, Materials, Model, PlainMaterial, load_materials, read};
use tristrip_pipeline::{Error, Target, encode, format_to_write, layout_to_write};

const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";

fn model() -> Model {
    let mut model = read(OBJ, Format::Obj).unwrap();
    let red = PlainMaterial { base_colour: [1.0, 0.0, 0.0, 1.0], ..PlainMaterial::default() };
    let mut materials = Materials::default();
    assert!(materials.add_plain("red", &red));
    model.materials = Some(materials);
    model
}

fn encoded(model: &Model, format: Format) -> encode::Outcome {
    encode::run(model, &[Drawing::Faces], &encode::Options::new(format), &()).unwrap()
}

#[test]
fn an_obj_has_its_library_beside_it_and_foreign_files_stay() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("out.obj");
    let target = Target::new(Some(&path), Format::Obj);
    let mut model = model();
    assert!(target.takes_materials(&model) && !target.takes_images(None));
    target.complete(&mut model, None).unwrap();
    let written = target.write(&encoded(&model, Format::Obj)).unwrap();
    assert_eq!(written.beside, [dir.path().join("out.mtl")]);
    assert!(fs::read_to_string(&written.beside[0]).unwrap().contains("newmtl red\nKd 1 0 0"));
    // Files with the same content are not written again. Files with the same name are replaced.
    assert!(target.write(&encoded(&model, Format::Obj)).unwrap().beside.is_empty());
    fs::write(dir.path().join("out.mtl"), "other").unwrap();
    assert_eq!(target.write(&encoded(&model, Format::Obj)).unwrap().beside.len(), 1);
    // A library with another name is not replaced.
    load_materials(&mut model, None, "other");
    let other = encoded(&model, Format::Obj);
    let mut foreign = other.clone();
    foreign.files[0].name = "foreign.mtl".into();
    fs::write(dir.path().join("foreign.mtl"), "not ours").unwrap();
    let written = target.write(&foreign).unwrap();
    assert_eq!((written.beside.len(), written.warnings.len()), (0, 1));
    assert_eq!(fs::read(dir.path().join("foreign.mtl")).unwrap(), b"not ours");
}

#[test]
fn a_gltf_is_two_files_and_a_folder_is_created_if_asked() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("new/a.gltf");
    let target = Target::new(Some(&path), Format::Gltf);
    assert!(target.separate && target.format == Format::Glb);
    let glb = encoded(&model(), Format::Glb);
    let Err(Error::Format(tristrip_io::Error::Io { path: failed, .. })) = target.write(&glb) else {
        panic!("written into a folder that does not exist")
    };
    assert!(Path::new(&failed).ends_with("a.bin"), "{failed}");
    let target = Target { creates_folder: true, ..target };
    let written = target.write(&glb).unwrap();
    let sizes = ["a.gltf", "a.bin"].map(|name| fs::read(dir.path().join("new").join(name)).unwrap().len());
    assert_eq!(written.bytes, sizes[0] + sizes[1]);
    // In the directory of the source, images stay in their files.
    let source = dir.path().join("new/source.gltf");
    assert!(!target.takes_images(Some(&source)) && target.takes_images(None));
    assert!(Target::new(Some(&path), Format::Glb).takes_images(Some(&source)));
    assert!(Target::new(None, Format::Glb).write(&glb).is_err());
}

#[test]
fn formats_and_layouts_are_checked() {
    let path = |name: &'static str| Path::new(name);
    assert_eq!(format_to_write(path("a.OBJ"), None), Ok(Format::Obj));
    for wrong in ["a", "a.off", "a.txt"] {
        assert!(format_to_write(path(wrong), None).is_err(), "{wrong}");
    }
    assert!(format_to_write(path("a.bin"), Some(Format::Gltf)).is_err());
    assert!(format_to_write(path("a.bin"), Some(Format::Glb)).is_ok());
    assert!(format_to_write(path("a.glb"), Some(Format::Stl)).is_err());
    assert_eq!(layout_to_write(Format::Obj, Some(Layout::List)), Ok(Layout::List));
    assert_eq!(layout_to_write(Format::Glb, None), Ok(Layout::Degenerate));
}
