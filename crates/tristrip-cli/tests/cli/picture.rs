//! `--picture` of `strip` and `simplify`: the picture, its report, and wrong usage.

use std::fs;

use super::{json, model, tristrip};
use predicates::str::contains;

/// Returns the width and height that the header of a PNG file states.
fn size(png: &[u8]) -> (u32, u32) {
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    let number = |at: usize| png[at..at + 4].iter().fold(0, |number, &byte| number << 8 | u32::from(byte));
    (number(16), number(20))
}

#[test]
fn a_picture_is_the_same_with_any_number_of_threads() {
    let dir = tempfile::tempdir().unwrap();
    let pictures = ["1", "3"].map(|threads| {
        let path = dir.path().join(format!("{threads}.png"));
        let mut command = tristrip();
        command
            .args(["strip", "--threads", threads, "--json", "--picture"])
            .arg(&path)
            .arg(model("milktruck.glb"));
        assert_eq!(json(&mut command)["picture"], path.display().to_string());
        fs::read(path).unwrap()
    });
    assert_eq!(size(&pictures[0]), (1200, 900));
    assert!(pictures[0] == pictures[1]);
}

#[test]
fn other_methods_give_other_pictures_and_a_file_can_be_written_beside() {
    let dir = tempfile::tempdir().unwrap();
    let picture = |method: &str| {
        let (png, ply) = (dir.path().join("strips.png"), dir.path().join("strips.ply"));
        let mut command = tristrip();
        command.args(["strip", "--method", method, "--picture"]).arg(&png).arg("-o").arg(&ply);
        command.arg(model("fish_control.ply")).assert().success().stderr(contains("1200 × 900 pixels"));
        assert!(fs::read(ply).unwrap().starts_with(b"ply"));
        fs::read(png).unwrap()
    };
    assert!(picture("sgi") != picture("input"));
}

#[test]
fn a_picture_is_a_png_of_one_input() {
    let fish = model("fish_control.ply");
    let refused = |arguments: &[&str], why: &str| {
        tristrip().arg("strip").args(arguments).arg(&fish).assert().code(2).stderr(contains(why));
    };
    refused(&["--picture", "strips.jpg"], "--picture writes PNG; use the extension .png");
    let again = fish.display().to_string();
    refused(&["--picture", "strips.png", &again], "--picture: found 2 inputs, expected one");
    let mut command = tristrip();
    command.args(["strip", "--picture", "/nonexistent/strips.png"]).arg(&fish);
    command.assert().code(1).stderr(contains("/nonexistent/strips.png"));
}

#[test]
fn a_simplified_model_is_drawn_below_the_original() {
    let dir = tempfile::tempdir().unwrap();
    let picture = |ratio: &str| {
        let path = dir.path().join("before-after.png");
        let mut command = tristrip();
        command
            .args(["simplify", "--ratio", ratio, "--json", "--picture"])
            .arg(&path)
            .arg(model("milktruck.glb"));
        assert_eq!(json(&mut command)["picture"], path.display().to_string());
        fs::read(path).unwrap()
    };
    let (half, all) = (picture("50%"), picture("100%"));
    assert_eq!((size(&half), size(&all)), ((2048, 512), (2048, 512)));
    assert!(half != all);
    let mut command = tristrip();
    command.args(["simplify", "--ratio", "50%", "--picture", "a.jpg"]).arg(model("milktruck.glb"));
    command.assert().code(2).stderr(contains("--picture writes PNG; use the extension .png"));
}
