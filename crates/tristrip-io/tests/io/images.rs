//! Images in separate files: which are embedded, which are not, and that the rest is unchanged.

use std::fs;
use std::path::Path;

use crate::gltf_documents::*;
use serde_json::json;
use tristrip::Layout;
use tristrip_io::{Drawing, Format, Model, embed_images, gltf, read_path, write};

/// One grey pixel.
const PNG: &[u8] =
    b"\x89PNG\x0d\x0a\x1a\x0a\x00\x00\x00\x0dIHDR\x00\x00\x00\x01\x00\x00\x00\x01\x08\x00\x00\x00\x00:~\
    \x9bU\x00\x00\x00\x0aIDATx\xdach\x00\x00\x00\x82\x00\x81\xdaE\x08;\x00\x00\x00\x00IEND\xaeB`\x82";
const JPEG: &[u8] = b"\xff\xd8\xff\xe0 of another";

/// Returns a triangle with images.
fn draft(uris: &[&str]) -> Draft {
    let mut draft = Draft::new();
    let positions = draft.positions(&bent(3));
    draft.primitive(positions, None, 4);
    draft.json["images"] = uris.iter().map(|uri| json!({ "uri": uri, "name": uri })).collect();
    draft
}

fn written(model: &Model) -> Vec<u8> {
    write(model, &vec![Drawing::Faces; model.parts.len()], Format::Glb, Layout::List).unwrap()
}

/// Returns a directory with a model and two images.
fn folder(draft: &Draft) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("textures")).unwrap();
    fs::write(dir.path().join("textures/a b.png"), PNG).unwrap();
    fs::write(dir.path().join("c.jpg"), JPEG).unwrap();
    fs::write(dir.path().join("notes.txt"), "no image").unwrap();
    fs::write(dir.path().join("empty.png"), "").unwrap();
    fs::write(dir.path().join("model.gltf"), draft.gltf()).unwrap();
    dir
}

#[test]
fn images_beside_a_document_are_in_the_glb() {
    let draft = draft(&["textures/a%20b.png", "c.jpg", "textures/a%20b.png", "data:image/png;base64,iVBO"]);
    let dir = folder(&draft);
    let path = dir.path().join("model.gltf");
    let mut model = read_path(&path).unwrap();
    assert_eq!(model.notes, ["images in separate files: 3"]);
    let plain = json_of(&written(&model));
    let images = embed_images(&mut model, Some(&path)).unwrap();
    assert_eq!((images.embedded, images.left), (3, vec![]));
    assert_eq!(model.notes[1], "images embedded from separate files: 3");
    let glb = written(&model);
    let json = json_of(&glb);
    for (image, (bytes, mime_type)) in
        [(PNG, "image/png"), (JPEG, "image/jpeg"), (PNG, "image/png")].into_iter().enumerate()
    {
        let found = &json["images"][image];
        assert_eq!((&found["mimeType"], &found["uri"]), (&json!(mime_type), &json!(null)));
        assert_eq!(found["name"], draft.json["images"][image]["name"]);
        let view = found["bufferView"].as_u64().unwrap() as usize;
        assert_eq!(view_bytes(&json, bin_of(&glb), view), bytes);
    }
    assert_eq!(json["images"][3], plain["images"][3]);
    // One view per file; everything before is unchanged.
    assert_eq!(json["bufferViews"].as_array().unwrap().len(), 3);
    assert_eq!(json["bufferViews"][0], plain["bufferViews"][0]);
    assert_eq!(json["accessors"], plain["accessors"]);
    let again = gltf::read(glb, None).unwrap();
    assert_eq!(again.parts[0].mesh, model.parts[0].mesh);
    assert!(again.notes.is_empty(), "{:?}", again.notes);
}

#[test]
fn a_glb_with_an_image_is_valid() {
    let draft = draft(&["textures/a%20b.png"]);
    let dir = folder(&draft);
    let path = dir.path().join("model.gltf");
    let mut model = read_path(&path).unwrap();
    embed_images(&mut model, Some(&path)).unwrap();
    validate("images", &[("image.glb".to_owned(), written(&model))]);
}

#[test]
fn images_that_cannot_be_taken_keep_their_uri() {
    let uris = ["none.png", "../c.jpg", "https://example.com/a.png", "notes.txt", "empty.png", "c.jpg"];
    let draft = draft(&uris);
    let dir = folder(&draft);
    let path = dir.path().join("model.gltf");
    let mut model = read_path(&path).unwrap();
    let images = embed_images(&mut model, Some(&path)).unwrap();
    assert_eq!((images.embedded, images.left.len()), (1, 5));
    let outside =
        "images[1].uri: found \"../c.jpg\", expected a data URI, or a file in the directory of the document";
    assert_eq!(images.left[1], outside);
    assert!(images.left[0].contains("none.png: "), "{}", images.left[0]);
    for place in [3, 4] {
        assert!(images.left[place].ends_with("expected a PNG, JPEG, WebP, KTX2, DDS or AVIF file"));
    }
    let count = "images not embedded: 5, such as ";
    assert!(model.notes.last().unwrap().starts_with(count), "{:?}", model.notes);
    let json = json_of(&written(&model));
    for (image, uri) in uris.iter().enumerate().take(5) {
        assert_eq!(json["images"][image], json!({ "uri": uri, "name": uri }));
    }
    assert!(json["images"][5]["bufferView"].is_u64());

    // Without a directory, and with an extension that refers to bytes.
    let mut model = read_path(&path).unwrap();
    assert_eq!(embed_images(&mut model, None).unwrap().left.len(), 6);
    let mut named = self::draft(&["c.jpg"]);
    named.json["extensions"] = json!({ "VENDOR_bytes": { "byteOffset": 4 } });
    fs::write(&path, named.gltf()).unwrap();
    let mut model = read_path(&path).unwrap();
    assert_eq!(embed_images(&mut model, Some(&path)).unwrap().left.len(), 1);
    assert_eq!(json_of(&written(&model))["images"][0]["uri"], "c.jpg");
}

#[test]
fn a_model_without_a_scene_has_no_images() {
    let mut model = Model::default();
    assert_eq!(embed_images(&mut model, Some(Path::new("none/a.obj"))).unwrap().embedded, 0);
    assert!(model.notes.is_empty());
}
