//! Materials of OBJ: libraries and images next to the file are written with every result that can
//! store them.

#![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::fs;
use std::path::Path;

use super::{json, tristrip};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::{Value, json};

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x02\0\0\0\0\x40\x08\x02\0\0\0 of oak";
const OBJ: &str = "mtllib mats/box.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nvt 0 0.25\nvt 1 0.25\nvt 1 1\nvt 0 1\n\
                   usemtl wood\nf 1/1 2/2 3/3 4/4\nusemtl lamp\nf 2/1 5/2 6/3 3/4\n";
const MTL: &str = "newmtl wood\nKd 0.5 0.25 1\nd 0.5\nmap_Kd maps/oak.png\n\nnewmtl lamp\nKd 1 0 0\nKe 0 1 0\nPr 0.5\nPm 1\n";

/// Writes the model, its library and its image.
fn source(folder: &Path) -> std::path::PathBuf {
    fs::create_dir_all(folder.join("mats/maps")).unwrap();
    fs::write(folder.join("mats/box.mtl"), MTL).unwrap();
    fs::write(folder.join("mats/maps/oak.png"), PNG).unwrap();
    fs::write(folder.join("box.obj"), OBJ).unwrap();
    folder.join("box.obj")
}

/// Returns the JSON of a GLB.
fn document(path: &Path) -> Value {
    let bytes = fs::read(path).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

/// Returns the numbers of an array: 1 and 1.0 are the same.
fn numbers(array: &Value) -> Vec<f64> {
    array.as_array().unwrap().iter().filter_map(Value::as_f64).collect()
}

#[test]
fn an_obj_becomes_a_glb_with_its_materials_and_images() {
    let (from, to) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (obj, glb) = (source(from.path()), to.path().join("box.glb"));
    for command in [&["convert"][..], &["strip"], &["simplify", "--ratio", "100%"]] {
        tristrip().args(command).arg("-q").arg(&obj).arg("-o").arg(&glb).assert().success().stderr("");
        let document = document(&glb);
        let [wood, lamp] = [0, 1].map(|i| &document["materials"][i]);
        assert_eq!(
            numbers(&wood["pbrMetallicRoughness"]["baseColorFactor"]),
            [0.5, 0.25, 1.0, 0.5],
            "{document}"
        );
        assert_eq!((&wood["alphaMode"], &wood["name"]), (&json!("BLEND"), &json!("wood")));
        assert_eq!(wood["pbrMetallicRoughness"]["baseColorTexture"], json!({ "index": 0 }));
        assert_eq!(numbers(&lamp["emissiveFactor"]), [0.0, 1.0, 0.0]);
        let surface = &lamp["pbrMetallicRoughness"];
        let [roughness, metallic] =
            ["roughnessFactor", "metallicFactor"].map(|factor| surface[factor].as_f64());
        assert_eq!((roughness, metallic.unwrap_or(1.0)), (Some(0.5), 1.0));
        assert_eq!(document["images"][0]["mimeType"], "image/png");
        let bytes = fs::read(&glb).unwrap();
        assert!(bytes.windows(PNG.len()).any(|window| window == PNG));
        assert_eq!(fs::read_dir(to.path()).unwrap().count(), 1);
    }
    // Texture coordinates count downwards there: the least v of the file, 0.25, is the greatest.
    let model = tristrip_io::read_path(&glb).unwrap();
    let uv = &model.parts[0].mesh.attributes()[0];
    let v = (0..4).filter_map(|i| uv.float(2 * i + 1)).fold(f32::MIN, f32::max);
    assert!((v - 0.75).abs() < 1e-6, "{v}");
    let report = json(tristrip().args(["simplify", "--json"]).arg(&obj).arg("-o").arg(&glb));
    assert!(report["uv_deviation_texels"].is_number(), "{report}");
}

#[test]
fn an_obj_takes_its_library_and_images_along() {
    let (from, to) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (obj, out) = (source(from.path()), to.path().join("out.obj"));
    let run = || {
        let mut run = tristrip();
        run.args(["convert", "-q"]).arg(&obj).arg("-o").arg(&out);
        run
    };
    run().assert().success().stderr("");
    assert!(fs::read_to_string(&out).unwrap().contains("mtllib mats/box.mtl\n"));
    assert_eq!(fs::read_to_string(to.path().join("mats/box.mtl")).unwrap(), MTL);
    assert_eq!(fs::read(to.path().join("mats/maps/oak.png")).unwrap(), PNG);
    // The copy is as good as the original.
    let glb = to.path().join("again.glb");
    tristrip().args(["convert", "-q"]).arg(&out).arg("-o").arg(&glb).assert().success().stderr("");
    assert_eq!(document(&glb)["images"].as_array().map(Vec::len), Some(1));
    // A file with other content is not replaced.
    fs::write(to.path().join("mats/box.mtl"), "mine").unwrap();
    let kept = "box.mtl exists with other content and was not replaced";
    run().assert().success().stderr(contains(kept));
    let notes = json(run().arg("--json"))["notes"].to_string();
    assert!(notes.contains(kept), "{notes}");
    assert_eq!(fs::read_to_string(to.path().join("mats/box.mtl")).unwrap(), "mine");
}

#[test]
fn a_glb_becomes_an_obj_with_a_library() {
    let dir = tempfile::tempdir().unwrap();
    let (obj, glb, back) = (source(dir.path()), dir.path().join("box.glb"), dir.path().join("back.obj"));
    tristrip().args(["convert", "-q"]).arg(&obj).arg("-o").arg(&glb).assert().success();
    let lost = "materials with maps or emission, written with only their base colours: 1";
    tristrip()
        .args(["convert", "-q"])
        .arg(&glb)
        .arg("-o")
        .arg(&back)
        .assert()
        .success()
        .stderr(contains(lost));
    let library = fs::read_to_string(dir.path().join("back.mtl")).unwrap();
    assert!(library.contains("newmtl wood\nKd 0.5 0.25 1\nd 0.5\nmap_Kd back_0.png\n"), "{library}");
    assert_eq!(fs::read(dir.path().join("back_0.png")).unwrap(), PNG);
    let text = fs::read_to_string(&back).unwrap();
    assert!(text.contains("mtllib back.mtl\n") && text.contains("vt 0 0.25\n"), "{text}");
    assert!(!text.contains("not written: textures"), "{text}");
}

#[test]
fn what_cannot_travel_gives_one_warning_also_in_quiet_mode() {
    let dir = tempfile::tempdir().unwrap();
    let obj = source(dir.path());
    let to = |name: &str| {
        let mut run = tristrip();
        run.args(["convert", "-q"]).arg(&obj).arg("-o").arg(dir.path().join(name));
        run.assert().success()
    };
    to("a.ply").stderr(contains("materials are not written: PLY does not support them"));
    fs::write(dir.path().join("mats/box.mtl"), [MTL, "bump b.png\n"].concat()).unwrap();
    to("a.glb").stderr(contains("bump map in 1 material").and(contains("b.png")));
    fs::remove_file(dir.path().join("mats/box.mtl")).unwrap();
    to("a.glb").stderr(contains("box.mtl: "));
    // A name that leads out of the directory is not followed.
    fs::write(&obj, OBJ.replace("mats/box.mtl", "../box.mtl")).unwrap();
    to("a.glb").stderr(contains("../box.mtl: not a file in the directory of the OBJ"));
}
