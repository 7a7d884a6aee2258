//! Malformed material libraries of OBJ files: they give materials or reported problems, never a
//! panic. Memory and time are proportional to the bytes, and no file outside the directory is read.
#![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

#[path = "io/doubling.rs"]
mod doubling;
#[path = "io/gltf_documents/mod.rs"]
mod gltf_documents;
#[path = "io/random.rs"]
mod random;

use std::fmt::Write as _;
use std::fs;
use std::sync::Arc;

use doubling::check_linear;
use gltf_documents::json_of;
use random::{mutate, random};
use tristrip::Layout;
use tristrip_io::{Drawing, Format, Materials, Model, load_materials, read, read_path, write};

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x02\0\0\0\0\x40\x08\x02\0\0\0";
const LIBRARY: &str = "newmtl wood\nKd 0.5 0.25 0\nd 0.5\nNs 30\nmap_Kd -s 2 2 -o 0.5 1 0 maps\\oak wood.png\n\
    map_Bump -bm 2 b.png\nnewmtl m\nKe 9 1 0.5\nTr 0.5\nPr 0.25\nPm 1\nmap_Ke glow.jpg\nmap_d glow.jpg\nnorm -clamp on n.png\n";

fn obj(lines: &str) -> String {
    format!("{lines}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n")
}

fn library(name: &str, bytes: impl Into<Vec<u8>>) -> (Materials, Vec<String>) {
    let mut materials = Materials::default();
    let images = materials.add_library(name, Arc::new(bytes.into()));
    (materials, images)
}

/// Returns a model with these materials as GLB; all their images are the same PNG.
fn glb(materials: Materials, images: Vec<String>) -> Vec<u8> {
    let mut model = read(obj("").as_bytes(), Format::Obj).unwrap();
    let file = |name: String| tristrip_io::SideFile { name, bytes: Arc::new(PNG.to_vec()) };
    let mut materials = materials;
    materials.files.extend(images.into_iter().map(file));
    model.materials = Some(materials);
    write(&model, &[Drawing::Faces], Format::Glb, Layout::List).unwrap()
}

/// Returns the peak memory of the process in bytes, if the system reports it.
fn peak_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

#[test]
fn mutations_never_panic() {
    let mut random = random();
    let mut done = 0;
    for _ in 0..4000 {
        let mut changed = LIBRARY.as_bytes().to_vec();
        mutate(&mut changed, 5, &mut random);
        let (materials, images) = library("maps/a.mtl", changed);
        assert!(images.iter().all(|image| image.starts_with("maps/")) && images.len() <= 5, "{images:?}");
        let json = json_of(&glb(materials, images));
        let material = &json["materials"][0];
        let surface = &material["pbrMetallicRoughness"];
        let numbers = [&surface["baseColorFactor"], &material["emissiveFactor"]].into_iter();
        let numbers = numbers.flat_map(|list| list.as_array().cloned().unwrap_or_default());
        let numbers: Vec<f64> = numbers.map(|x| x.as_f64().unwrap()).collect();
        assert!(numbers.iter().all(|x| (0.0..=1.0).contains(x)), "{material}");
        done += usize::from(!surface.is_null());
    }
    assert!((2000..4000).contains(&done), "{done}");
}

#[test]
fn numbers_that_are_none_count_as_missing() {
    for line in
        ["Kd nan inf 1", "Kd 1e999 0 0", "Kd 1 1", "d inf", "Tr -nan", "Ns 1e999", "Pm x", "Ke 1 1 -inf"]
    {
        let json = json_of(&glb(library("a.mtl", format!("newmtl m\n{line}\n")).0, Vec::new()));
        let without = json_of(&glb(library("a.mtl", "newmtl m\n").0, Vec::new()));
        assert_eq!(json["materials"], without["materials"], "{line}");
    }
    for (line, factor) in [("Tr -3e38", 1.0), ("Tr 3e38", 0.0), ("d -5", 0.0), ("d 5", 1.0)] {
        let json = json_of(&glb(library("a.mtl", format!("newmtl m\n{line}\n")).0, Vec::new()));
        assert_eq!(json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][3], factor, "{line}");
    }
}

#[test]
fn lines_of_any_length_and_bytes_are_read() {
    let long = "x".repeat(8 << 20);
    let (materials, images) = library("a.mtl", format!("newmtl m\nmap_Kd {long}\n{long} 1\nKd {long}\n"));
    assert_eq!((images.len(), images[0].len(), materials.problems.len()), (1, long.len(), 0));
    // Many options; the last word is the image.
    let options = "-s 1 1 1 ".repeat(1 << 16);
    let (_, images) = library("a.mtl", format!("newmtl m\nmap_Kd {options}\nmap_Ke {options}a.png\n"));
    assert_eq!(images, ["1", "a.png"]);
    // Bytes that are not UTF-8, in the names of both files.
    let (materials, images) = library("a.mtl", b"newmtl \xff\xfe\nmap_Kd \xc0\x80.png\n");
    assert_eq!((materials.is_empty(), &*images[0]), (false, "\u{fffd}\u{fffd}.png"));
    let model =
        read(b"mtllib \xff.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl \xff\xfe\nf 1 2 3\n", Format::Obj).unwrap();
    assert_eq!(model.parts[0].material.as_deref(), Some("\u{fffd}\u{fffd}"));
    assert_eq!(model.materials.unwrap().libraries, ["\u{fffd}.mtl"]);
}

#[test]
fn libraries_take_linear_time() {
    let materials = |count: usize| {
        let mut text = String::new();
        for i in 0..count {
            writeln!(text, "newmtl m{i}\nKd 1 0 0\n\nmap_Kd a{}.png\nk{i} 1\nmap_{i} b", i % 5000).unwrap();
        }
        (count, Arc::new(text.into_bytes()))
    };
    check_linear(4000, materials, |(count, bytes)| {
        let mut materials = Materials::default();
        let images = materials.add_library("a.mtl", Arc::clone(bytes));
        assert_eq!(images.len(), (count + 1).min(4096));
    });
    check_linear(
        4000,
        |lines| obj(&"mtllib a.mtl\nmtllib ./a.mtl\nusemtl m\n".repeat(lines)),
        |text| {
            assert_eq!(read(text.as_bytes(), Format::Obj).unwrap().materials.unwrap().libraries, ["a.mtl"]);
        },
    );
}

#[test]
fn a_long_folder_is_not_repeated_for_every_material() {
    const COUNT: usize = 150_000;
    let folder = "f".repeat(4000);
    let lines = (0..COUNT).map(|i| format!("newmtl m{i}\nmap_Kd {i}.png\n"));
    let (materials, images) = library(&format!("{folder}/a.mtl"), lines.collect::<String>());
    assert_eq!(images.len(), 4096);
    assert!(images.iter().all(|image| image.len() < 4020 && image.starts_with("fff")));
    assert!(materials.problems[0].ends_with("only the first 4096 of 150000 images are read"));
    // Repeating each name would take 600 MB.
    assert!(peak_bytes().is_none_or(|peak| peak < 400 << 20), "{:?}", peak_bytes());
}

/// Returns a directory with a model, next to a file that must not be read.
fn folder(lines: &str, library: &str) -> (tempfile::TempDir, Model) {
    let dir = tempfile::tempdir().unwrap();
    let inside = dir.path().join("inside");
    fs::create_dir_all(inside.join("maps")).unwrap();
    fs::write(dir.path().join("secret.png"), PNG).unwrap();
    fs::write(inside.join("a.png"), PNG).unwrap();
    fs::write(inside.join("a.mtl"), library).unwrap();
    fs::write(inside.join("maps/b.mtl"), library).unwrap();
    fs::write(inside.join("model.obj"), obj(lines)).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(dir.path().join("secret.png"), inside.join("link.png")).unwrap();
    let path = inside.join("model.obj");
    let mut model = read_path(&path).unwrap();
    load_materials(&mut model, Some(&path), "out");
    (dir, model)
}

fn names(model: &Model) -> Vec<&str> {
    model.materials.as_ref().unwrap().files.iter().map(|file| &*file.name).collect()
}

#[test]
fn nothing_outside_the_folder_is_read() {
    for name in [
        "../secret.png",
        "maps/../../secret.png",
        "/etc/hostname",
        "C:\\secret.png",
        "..\\secret.png",
        "link.png",
    ] {
        let (_dir, model) = folder("mtllib a.mtl", &format!("newmtl m\nmap_Kd {name}\n"));
        assert_eq!(names(&model), ["a.mtl"], "{name}");
        let problems = &model.materials.as_ref().unwrap().problems;
        assert_eq!(problems.len(), 1, "{name}: {problems:?}");
        if !cfg!(unix) && name == "link.png" {
            continue;
        }
        let expected = format!("{}: not a file in the directory of the OBJ", name.replace('\\', "/"));
        assert_eq!(problems[0], expected);
    }
    for name in ["../secret.png", "/etc/hostname", "maps", "none.mtl", "maps/\0.mtl", &"x/".repeat(3000)] {
        let (_dir, model) = folder(&format!("mtllib {name}"), "newmtl m\n");
        assert!(names(&model).is_empty() && model.materials.unwrap().is_empty(), "{name}");
    }
}

#[test]
fn libraries_and_images_that_name_each_other_are_read_once() {
    // A library that is its own image is a file without an image in it.
    let (_dir, model) = folder(
        "mtllib a.mtl\nmtllib ././a.mtl\nmtllib .//a.mtl\nmtllib model.obj",
        "newmtl m\nmap_Kd a.mtl\nmap_Ke model.obj\n",
    );
    assert_eq!(names(&model), ["a.mtl", "a.mtl", "model.obj", "model.obj"]);
    let materials = model.materials.as_ref().unwrap();
    assert_eq!(materials.problems, ["model.obj: contains no materials"]);
    assert_eq!(materials.image_size("m"), None);
    let glb = write(&model, &[Drawing::Faces], Format::Glb, Layout::List).unwrap();
    assert!(json_of(&glb).get("images").is_none());
    // The same image under many names is stored once.
    let many: Vec<String> =
        (1..200).map(|i| format!("newmtl m{i}\nmap_Kd {}a.png\n", "./".repeat(i))).collect();
    let (_dir, model) = folder("mtllib a.mtl", &many.concat());
    let files = &model.materials.as_ref().unwrap().files;
    assert_eq!(files.len(), 200);
    assert!(files[1..].iter().all(|file| Arc::ptr_eq(&file.bytes, &files[1].bytes)));
}
