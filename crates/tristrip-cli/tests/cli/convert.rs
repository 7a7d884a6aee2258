//! `tristrip convert`: formats and layouts, without new strips.

use std::fs;

use super::{SQUARE, json, keys, model, tristrip};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;

#[test]
fn polygons_stay_polygons_if_the_format_has_them() {
    let dir = tempfile::tempdir().unwrap();
    let (obj, ply) = (dir.path().join("fish.obj"), dir.path().join("fish.ply"));
    let report =
        json(tristrip().args(["convert", "--json"]).arg(model("fish_control.ply")).arg("-o").arg(&obj));
    let expected = [
        "file",
        "seconds",
        "proven",
        "faces",
        "triangles",
        "strips",
        "parts",
        "notes",
        "output",
        "layout",
        "error",
    ];
    assert_eq!(keys(&report), expected);
    assert_eq!((&report["faces"], &report["triangles"]), (&Value::from(112), &Value::from(220)));
    assert_eq!((&report["proven"], &report["layout"]), (&Value::from(true), &Value::Null));
    tristrip().arg("convert").arg(&obj).arg("-o").arg(&ply).assert().success();
    let again = json(tristrip().args(["strip", "--json"]).arg(&ply));
    assert_eq!(again["mesh"]["faces"], 112);
}

#[test]
fn the_number_of_strips_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let (ply, glb) = (dir.path().join("a.ply"), dir.path().join("a.glb"));
    let first = json(tristrip().args(["strip", "--json"]).arg(model("wingnut.ply")).arg("-o").arg(&ply));
    let mut convert = tristrip();
    let second =
        json(convert.args(["convert", "--json", "--layout", "restart"]).arg(&ply).arg("-o").arg(&glb));
    assert_eq!(second["layout"], "restart");
    assert!(second["strips"].as_u64() <= first["strips"].as_u64());
    tristrip().arg("verify").arg(model("wingnut.ply")).arg(&glb).assert().success();
}

#[test]
fn streams_and_directories_work_as_for_strip() {
    let dir = tempfile::tempdir().unwrap();
    let piped =
        tristrip().args(["convert", "-", "-o", "-", "--to", "ply"]).write_stdin(SQUARE).assert().success();
    assert!(piped.get_output().stdout.starts_with(b"ply\n"));
    tristrip()
        .args(["convert", "--to", "obj", "-o"])
        .arg(dir.path())
        .arg(model("fish_control.ply"))
        .arg(model("catmark_bishop.ply"))
        .assert()
        .success()
        .stderr(contains("proven"));
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
}

#[test]
fn losses_of_a_format_are_reported() {
    let dir = tempfile::tempdir().unwrap();
    let mut command = tristrip();
    command.args(["convert", "--json"]).arg(model("milktruck.glb")).arg("-o").arg(dir.path().join("a.ply"));
    let notes = json(&mut command)["notes"].to_string();
    assert!(notes.contains("parts joined into one") && notes.contains("nodes with a transform"), "{notes}");
}

#[test]
fn polygons_are_cut_into_fans_only_where_no_strips_draw_them() {
    let dir = tempfile::tempdir().unwrap();
    let quad = dir.path().join("quad.obj");
    fs::write(&quad, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").unwrap();
    let notes = |command: &str| {
        let output = dir.path().join("quad.glb");
        json(tristrip().args([command, "--json"]).arg(&quad).arg("-o").arg(output))["notes"].to_string()
    };
    assert!(notes("convert").contains("polygons cut into fans: 1"), "{}", notes("convert"));
    assert!(!notes("strip").contains("polygons"), "{}", notes("strip"));
}

#[test]
fn strips_stay_strips_without_a_layout() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    let first =
        json(tristrip().args(["strip", "--json"]).arg(model("wingnut.ply")).arg("-o").arg(path("a.ply")));
    for (from, to, layout) in [
        ("a.ply", "b.glb", Value::from("degenerate")),
        ("b.glb", "c.ply", Value::from("restart")),
        ("c.ply", "d.glb", Value::from("degenerate")),
        ("d.glb", "e.obj", Value::Null),
        ("e.obj", "f.ply", Value::Null),
    ] {
        let report = json(tristrip().args(["convert", "--json"]).arg(path(from)).arg("-o").arg(path(to)));
        assert_eq!(report["layout"], layout, "{from} to {to}");
        assert_eq!(report["strips"].is_null(), layout.is_null());
        assert!(report["strips"].is_null() || report["strips"].as_u64() <= first["strips"].as_u64());
    }
    tristrip().arg("verify").arg(model("wingnut.ply")).arg(path("f.ply")).assert().success();
}

/// A triangle in a `.gltf` with two textures in separate files, one of which does not exist.
const TEXTURED: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"triangle.bin"}],
    "images":[{"uri":"texture.png"},{"uri":"none.png"}],"textures":[{"source":0},{"source":1}]}"#;

#[test]
fn the_images_of_a_gltf_travel_into_the_glb() {
    const PNG: &[u8] = b"\x89PNG\r\n\x1a\n of a texture";
    let (source, target) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (input, glb) = (source.path().join("triangle.gltf"), target.path().join("triangle.glb"));
    fs::write(&input, TEXTURED).unwrap();
    fs::write(source.path().join("texture.png"), PNG).unwrap();
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    fs::write(source.path().join("triangle.bin"), corners.map(f32::to_le_bytes).as_flattened()).unwrap();
    for command in ["convert", "strip"] {
        let run = || {
            let mut run = tristrip();
            run.arg(command).arg(&input).arg("-o").arg(&glb);
            run
        };
        let missing = "images not embedded: 1, such as ";
        run().arg("-q").assert().success().stderr(contains(missing).and(contains("none.png")));
        let notes = json(run().arg("--json"))["notes"].to_string();
        assert!(notes.contains(missing) && notes.contains("embedded from separate files: 1"), "{notes}");
        let written = fs::read(&glb).unwrap();
        assert!(written.windows(PNG.len()).any(|bytes| bytes == PNG));
        assert_eq!(fs::read_dir(target.path()).unwrap().count(), 1);
        fs::write(source.path().join("none.png"), PNG).unwrap();
        run().arg("-q").assert().success().stderr("");
        fs::remove_file(source.path().join("none.png")).unwrap();
    }
}

#[test]
fn a_gltf_is_written_with_its_buffer_beside_it() {
    let dir = tempfile::tempdir().unwrap();
    let (gltf, bin) = (dir.path().join("the truck.gltf"), dir.path().join("the truck.bin"));
    for command in ["convert", "strip", "simplify", "level"] {
        fs::write(&bin, "old").unwrap();
        let mut run = tristrip();
        run.arg(command).arg(model("milktruck.glb")).arg("-o").arg(&gltf);
        if command == "simplify" {
            run.args(["--ratio", "50%"]);
        }
        run.assert().success().stderr(contains("proven"));
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
        let json: Value = serde_json::from_slice(&fs::read(&gltf).unwrap()).unwrap();
        assert_eq!(json["buffers"][0]["uri"], "the%20truck.bin");
        assert_eq!(json["buffers"][0]["byteLength"], fs::metadata(&bin).unwrap().len());
        assert_eq!(json["nodes"].as_array().map(Vec::len), Some(5));
        if command == "convert" || command == "strip" {
            tristrip().arg("verify").arg(model("milktruck.glb")).arg(&gltf).assert().success();
        }
    }
    // Several inputs, of formats without a scene.
    let out = dir.path().join("out");
    let inputs = [model("fish_control.ply"), model("catmark_bishop.ply")];
    tristrip().args(["convert", "--to", "gltf", "-o"]).arg(&out).args(&inputs).assert().success();
    assert_eq!(fs::read_dir(&out).unwrap().count(), 4);
    tristrip().arg("verify").arg(&inputs[0]).arg(out.join("fish_control.gltf")).assert().success();
}

#[test]
fn the_images_of_a_gltf_stay_files_in_its_folder_and_travel_elsewhere() {
    const PNG: &[u8] = b"\x89PNG\r\n\x1a\n of a texture";
    let (source, target) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let input = source.path().join("triangle.gltf");
    fs::write(&input, TEXTURED.replace("none.png", "texture.png")).unwrap();
    fs::write(source.path().join("texture.png"), PNG).unwrap();
    fs::write(source.path().join("triangle.bin"), [0; 36]).unwrap();
    for (folder, uri) in [(source.path(), Value::from("texture.png")), (target.path(), Value::Null)] {
        let out = folder.join("out.gltf");
        tristrip().args(["convert", "-q"]).arg(&input).arg("-o").arg(&out).assert().success().stderr("");
        let json: Value = serde_json::from_slice(&fs::read(&out).unwrap()).unwrap();
        assert_eq!((&json["images"][0]["uri"], &json["images"][1]["uri"]), (&uri, &uri));
        let bin = fs::read(folder.join("out.bin")).unwrap();
        assert_eq!(bin.windows(PNG.len()).filter(|bytes| *bytes == PNG).count(), usize::from(uri.is_null()));
    }
    assert_eq!(fs::read_dir(target.path()).unwrap().count(), 2);
}
