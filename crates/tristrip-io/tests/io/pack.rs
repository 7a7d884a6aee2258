//! Packed scenes: fewer bytes, the same vertices, and the same animation.

use serde_json::{Value, json};
use tristrip_io::gltf::{Rounding, pack, read};

use crate::gltf_documents::scenes::{grid, raw, shared_scene};
use crate::gltf_documents::{packed as packed_indices, *};
use crate::random::mutated_documents;

fn packed(glb: &[u8], rounding: Rounding) -> Vec<u8> {
    let packed = pack(glb.to_vec(), rounding).unwrap();
    assert!(packed.len() <= glb.len());
    packed
}

/// Checks that the parts of two files are the same, vertex for vertex, with all attributes.
fn check_parts(before: &[u8], after: &[u8]) {
    let [before, after] = [before, after].map(|glb| read(glb, None).unwrap());
    assert_eq!(before.parts.len(), after.parts.len());
    for (before, after) in before.parts.iter().zip(&after.parts) {
        assert_eq!(before.mesh.faces(), after.mesh.faces());
        let bits = |mesh: &tristrip::Mesh| format!("{:?} {:?}", mesh.positions(), mesh.attributes());
        assert_eq!(bits(&before.mesh), bits(&after.mesh));
    }
}

/// A skinned and animated scene with one node per track.
struct Animated {
    draft: Draft,
}

impl Animated {
    fn new() -> Self {
        let mut draft = Draft::new();
        let (positions, corners) = grid(3);
        let position = draft.positions(&positions);
        let list = draft.indices(U16, &corners);
        draft.primitive(position, Some(list), 4);
        draft.json["animations"] = json!([{ "channels": [], "samplers": [] }]);
        Self { draft }
    }

    fn values(&mut self, values: &[f32], count: usize, kind: &str) -> usize {
        let view = self.draft.view(&floats(values));
        self.draft.accessor(view, F32, count, kind)
    }

    fn track(&mut self, path: &str, interpolation: &str, times: &[f32], values: &[f32]) {
        let input = self.values(times, times.len(), "SCALAR");
        self.draft.json["accessors"][input]["min"] = json!([times[0]]);
        self.draft.json["accessors"][input]["max"] = json!([times[times.len() - 1]]);
        let (kind, width) = if path == "rotation" { ("VEC4", 4) } else { ("VEC3", 3) };
        let output = self.values(values, values.len() / width, kind);
        let node = push(&mut self.draft.json["nodes"], json!({ "name": format!("{path} {interpolation}") }));
        push(&mut self.draft.json["scenes"][0]["nodes"], node.into());
        let animation = &mut self.draft.json["animations"][0];
        let sampler = push(
            &mut animation["samplers"],
            json!({ "input": input, "output": output, "interpolation": interpolation }),
        );
        push(
            &mut animation["channels"],
            json!({ "sampler": sampler, "target": { "node": node, "path": path } }),
        );
    }
}

/// Returns the numbers of an accessor; normalized integers become fractions.
fn numbers(glb: &[u8], accessor: &Value) -> Vec<Vec<f64>> {
    let number = accessor.as_u64().unwrap() as usize;
    let component = json_of(glb)["accessors"][number]["componentType"].clone();
    let of = |value: &Vec<u8>| match component.as_u64() {
        Some(5126) => value.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b).into()).collect(),
        Some(5122) => value
            .as_chunks::<2>()
            .0
            .iter()
            .map(|b| (f64::from(i16::from_le_bytes(*b)) / 32767.0).max(-1.0))
            .collect(),
        Some(5123) => {
            value.as_chunks::<2>().0.iter().map(|b| f64::from(u16::from_le_bytes(*b)) / 65535.0).collect()
        }
        _ => value.iter().map(|&b| f64::from(b) / 255.0).collect(),
    };
    raw(glb, number).iter().map(of).collect()
}

/// Returns the value of a channel at a time, by the formulas of the specification; `None` if there
/// is no such channel.
fn played(glb: &[u8], animation: usize, node: usize, path: &str, time: f64) -> Option<Vec<f64>> {
    let json = json_of(glb);
    let animation = &json["animations"][animation];
    let channel = animation["channels"]
        .as_array()
        .unwrap()
        .iter()
        .find(|c| c["target"] == json!({"node": node, "path": path}))?;
    let sampler = &animation["samplers"][channel["sampler"].as_u64().unwrap() as usize];
    let times: Vec<f64> = numbers(glb, &sampler["input"]).concat();
    let values = numbers(glb, &sampler["output"]);
    let next = times.partition_point(|&t| t <= time);
    if next == 0 || next == times.len() {
        return Some(values[next.saturating_sub(1)].clone());
    }
    let share = (time - times[next - 1]) / (times[next] - times[next - 1]);
    let (a, b) = (&values[next - 1], &values[next]);
    if sampler["interpolation"] == "STEP" {
        return Some(a.clone());
    }
    let mut weights = [1.0 - share, share];
    if path == "rotation" {
        let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
        let angle = dot.abs().min(1.0).acos();
        if angle > 1e-6 {
            weights = weights.map(|weight| (weight * angle).sin() / angle.sin());
        }
        weights[1] *= dot.signum();
    }
    Some(a.iter().zip(b).map(|(a, b)| weights[0] * a + weights[1] * b).collect())
}

/// Returns the start and end time of an animation.
fn extent(glb: &[u8], animation: usize) -> [f64; 2] {
    let json = json_of(glb);
    let samplers = json["animations"][animation]["samplers"].as_array().unwrap();
    let times: Vec<f64> =
        samplers.iter().flat_map(|sampler| numbers(glb, &sampler["input"]).concat()).collect();
    [
        times.iter().copied().fold(f64::INFINITY, f64::min),
        times.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    ]
}

/// Compares all channels at many times. Removed channels must equal the node's own value.
fn check_animations(before: &[u8], after: &[u8], tolerance: f64) {
    let json = json_of(before);
    for (number, animation) in json["animations"].as_array().into_iter().flatten().enumerate() {
        assert_eq!(extent(before, number).map(f64::to_bits), extent(after, number).map(f64::to_bits));
        let [start, end] = extent(before, number);
        for channel in animation["channels"].as_array().unwrap() {
            let (node, path) = (
                channel["target"]["node"].as_u64().unwrap() as usize,
                channel["target"]["path"].as_str().unwrap(),
            );
            let rest = || match (&json["nodes"][node][path], path) {
                (Value::Array(numbers), _) => numbers.iter().map(|x| x.as_f64().unwrap()).collect(),
                (_, "rotation") => vec![0.0, 0.0, 0.0, 1.0],
                (_, "scale") => vec![1.0; 3],
                _ => vec![0.0; 3],
            };
            for step in -1..=101 {
                let time = start + (end - start) * f64::from(step) / 100.0;
                let old = played(before, number, node, path, time).unwrap();
                let new = played(after, number, node, path, time).unwrap_or_else(rest);
                let greatest = old.iter().fold(1e-3_f64, |greatest, x| greatest.max(x.abs()));
                let is_near = old.iter().zip(&new).all(|(a, b)| (a - b).abs() <= tolerance * greatest);
                assert!(
                    is_near && old.len() == new.len(),
                    "{path} of node {node} at {time}: {old:?}, {new:?}"
                );
            }
        }
    }
}

fn counts(glb: &[u8]) -> Vec<u64> {
    let json = json_of(glb);
    let samplers = json["animations"][0]["samplers"].as_array().unwrap().iter();
    let count = |sampler: &Value| {
        json["accessors"][sampler["input"].as_u64().unwrap() as usize]["count"].as_u64().unwrap()
    };
    samplers.map(count).collect()
}

#[test]
fn keyframes_that_their_neighbours_give_back_are_removed() {
    let mut scene = Animated::new();
    let times: Vec<f32> = (0..61).map(|i| i as f32 / 30.0).collect();
    let track =
        |value: &dyn Fn(f32) -> Vec<f32>| -> Vec<f32> { times.iter().flat_map(|&t| value(t)).collect() };
    // A rotation by two degrees per keyframe, with the noise of 32-bit floats.
    let turn = |t: f32| vec![0.0, (t * 30.0_f32.to_radians()).sin(), 0.0, (t * 30.0_f32.to_radians()).cos()];
    scene.track("translation", "LINEAR", &times, &track(&|t| vec![t * 3.0, (t - 1.0).abs(), 7.0]));
    scene.track("rotation", "LINEAR", &times, &track(&turn));
    scene.track("translation", "STEP", &times, &track(&|t| vec![t.floor(), 0.0, 1.0]));
    scene.track("scale", "LINEAR", &times, &track(&|_| vec![2.0, 2.0, 2.0]));
    scene.track("scale", "STEP", &times, &track(&|_| vec![1.0, 1.0, 1.0]));
    scene.track("translation", "LINEAR", &times, &track(&|t| vec![t * t, t.sin(), 0.0]));
    let glb = scene.draft.glb();
    let after = packed(&glb, Rounding::None);
    check_animations(&glb, &after, 2e-6);
    check_parts(&glb, &after);
    let counts = counts(&after);
    // In order: a bend at 1; at most 32 keyframes and 46 degrees between kept keyframes; steps at 1
    // and 2; one value; removed; curved.
    assert!(
        counts[0] <= 4 && counts[1] <= 5 && counts[2] == 3 && counts[3] == 1 && counts[4] > 50,
        "{counts:?}"
    );
    assert_eq!(counts.len(), 5);
    validate("keyframes", &[("before.glb".into(), glb), ("after.glb".into(), after)]);
}

#[test]
fn an_animation_begins_and_ends_as_before() {
    // Only constant tracks; one starts first and another ends last.
    let mut scene = Animated::new();
    for times in [[0.5, 1.0, 2.0, 3.0], [1.0, 2.0, 3.0, 5.0]] {
        scene.track("scale", "LINEAR", &times, &[1.0; 12]);
    }
    let glb = scene.draft.glb();
    let after = packed(&glb, Rounding::None);
    check_animations(&glb, &after, 1e-9);
    assert_eq!(counts(&after), [2, 2]);
}

#[test]
fn channels_stay_where_another_animation_moves_their_node() {
    let times: Vec<f32> = (0..20).map(|i| i as f32).collect();
    let moving: Vec<f32> = times.iter().flat_map(|&t| [t * t, 0.0, 0.0]).collect();
    let scene = |is_shared: bool| {
        let mut scene = Animated::new();
        scene.track("translation", "LINEAR", &times, &[0.0; 60]);
        scene.track("translation", "LINEAR", &times, &moving);
        let mut other = scene.draft.json["animations"][0].clone();
        if is_shared {
            other["channels"].as_array_mut().unwrap().truncate(1);
            other["channels"][0]["sampler"] = 1.into();
            push(&mut scene.draft.json["animations"], other);
        }
        scene.draft.glb()
    };
    for (is_shared, expected) in [(false, 1), (true, 2)] {
        let glb = scene(is_shared);
        let after = packed(&glb, Rounding::None);
        check_animations(&glb, &after, 1e-6);
        assert_eq!(json_of(&after)["animations"][0]["channels"].as_array().unwrap().len(), expected);
    }
}

#[test]
fn tracks_that_are_not_understood_stay() {
    let mut scene = Animated::new();
    scene.track("translation", "CUBICSPLINE", &[0.0, 1.0, 2.0], &[0.5; 27]);
    scene.track("translation", "LINEAR", &[0.0, 1.0, 1.0], &[0.5; 9]);
    scene.track("scale", "LINEAR", &[0.0, 1.0, 2.0], &[f32::NAN; 9]);
    scene.track("scale", "LINEAR", &[0.0, 1.0, 2.0], &[0.5; 12]);
    let glb = scene.draft.glb();
    let after = packed(&glb, Rounding::WeightsAndRotations);
    assert_eq!(counts(&after), [3, 3, 3, 3]);
    let samplers = |glb: &[u8]| json_of(glb)["animations"][0]["samplers"].as_array().unwrap().clone();
    let values = |glb: &[u8], sampler: &Value, name: &str| raw(glb, sampler[name].as_u64().unwrap() as usize);
    for (before, new) in samplers(&glb).iter().zip(&samplers(&after)) {
        for name in ["input", "output"] {
            assert_eq!(values(&glb, before, name), values(&after, new, name));
        }
    }
}

#[test]
fn equal_arrays_are_stored_once_and_unused_ones_not_at_all() {
    let mut draft = Draft::new();
    let (positions, corners) = grid(4);
    for _ in 0..2 {
        let position = draft.positions(&positions);
        let list = draft.indices(U16, &corners);
        draft.primitive(position, Some(list), 4);
        draft.positions(&positions[1..]);
    }
    draft.json["nodes"][0]["rotation"] = json!([0, 0, 0, 1]);
    draft.json["nodes"][0]["extras"] = json!({ "mode": "4.0", "x": 0.50 });
    let glb = draft.glb();
    let after = packed(&glb, Rounding::None);
    check_parts(&glb, &after);
    let json = json_of(&after);
    assert_eq!([&json["accessors"], &json["bufferViews"]].map(|list| list.as_array().unwrap().len()), [2, 2]);
    assert_eq!(bin_of(&after).len(), (12 * positions.len() + corners.len()).next_multiple_of(4));
    assert!(
        json["nodes"][0].get("rotation").is_none()
            && json["meshes"][0]["primitives"][0].get("mode").is_none()
    );
    assert_eq!(json["nodes"][0]["extras"], draft.json["nodes"][0]["extras"]);
    validate("equal_arrays", &[("after.glb".into(), after.clone())]);
    assert_eq!(packed(&after, Rounding::None), after);
}

#[test]
fn accessors_that_an_extension_may_name_keep_their_numbers() {
    let mut draft = Draft::new();
    let (positions, corners) = grid(4);
    let unused = draft.positions(&positions[1..]);
    let position = draft.positions(&positions);
    let equal = draft.positions(&positions);
    let list = draft.indices(U16, &corners);
    draft.primitive(position, Some(list), 4);
    draft.primitive(equal, Some(list), 4);
    draft.json["extensionsUsed"] = json!(["EXT_unknown_thing"]);
    draft.json["extensions"] = json!({ "EXT_unknown_thing": { "of": 1 } });
    let glb = draft.glb();
    let after = packed(&glb, Rounding::None);
    check_parts(&glb, &after);
    for accessor in [unused, position] {
        assert_eq!(raw(&glb, accessor), raw(&after, accessor));
        let lowest = |glb: &[u8]| -> Vec<Option<f64>> {
            let bound = json_of(glb)["accessors"][accessor]["min"].clone();
            bound.as_array().unwrap().iter().map(Value::as_f64).collect()
        };
        assert_eq!(lowest(&glb), lowest(&after));
        let view = |glb: &[u8]| view_bytes(&json_of(glb), bin_of(glb), accessor).to_vec();
        assert_eq!(view(&glb), view(&after));
    }
    // If an extension may refer to bytes, nothing moves.
    draft.json["extensions"] = json!({ "EXT_unknown_thing": { "byteOffset": 1 } });
    assert_eq!(packed(&draft.glb(), Rounding::None), draft.glb());
}

#[test]
fn interleaved_and_sparse_values_stay_as_they_are() {
    let glb = shared_scene(5).glb();
    let after = packed(&glb, Rounding::None);
    assert!(after.len() < glb.len());
    check_parts(&glb, &after);
    let json = json_of(&after);
    let (before, after_primitive) =
        (json_of(&glb)["meshes"][0]["primitives"][0].clone(), &json["meshes"][0]["primitives"][0]);
    for (before, after_object) in [(&before["attributes"], &after_primitive["attributes"])].into_iter().chain(
        before["targets"].as_array().unwrap().iter().zip(after_primitive["targets"].as_array().unwrap()),
    ) {
        for (name, old) in before.as_object().unwrap() {
            let new = after_object[name].as_u64().unwrap() as usize;
            assert_eq!(raw(&glb, old.as_u64().unwrap() as usize), raw(&after, new), "{name}");
        }
    }
    let of = |name: &str| {
        let accessor = &json["accessors"][after_primitive["attributes"][name].as_u64().unwrap() as usize];
        (accessor["bufferView"].clone(), accessor["byteOffset"].as_u64().unwrap_or(0))
    };
    assert_eq!((of("POSITION").0, of("POSITION").1 + 12), of("NORMAL"));
    validate("interleaved", &[("after.glb".into(), after)]);
}

/// Returns a skinned grid with 16-bit joints.
fn skinned(weights: impl Fn(usize) -> [f32; 4]) -> Vec<u8> {
    let mut draft = Draft::new();
    let (positions, corners) = grid(4);
    let position = draft.positions(&positions);
    let list = draft.indices(U16, &corners);
    let joints: Vec<u32> =
        (0..positions.len()).flat_map(|i| [i as u32 % 2, 1 - i as u32 % 2, 0, 0]).collect();
    let joints = draft.view(&packed_indices(U16, &joints));
    let joints = draft.accessor(joints, U16, positions.len(), "VEC4");
    let all: Vec<f32> = (0..positions.len()).flat_map(weights).collect();
    let weights = draft.view(&floats(&all));
    let weights = draft.accessor(weights, F32, positions.len(), "VEC4");
    draft.primitive(position, Some(list), 4);
    let attributes = &mut draft.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (joints.into(), weights.into());
    draft.json["nodes"] = json!([{ "mesh": 0, "skin": 0 }, { "name": "bone", "children": [2] }, {}]);
    draft.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    draft.json["skins"] = json!([{ "joints": [1, 2] }]);
    draft.glb()
}

fn attribute(glb: &[u8], name: &str) -> (Value, Vec<Vec<u8>>, Value) {
    let json = json_of(glb);
    let number = json["meshes"][0]["primitives"][0]["attributes"][name].clone();
    let accessor = number.as_u64().unwrap() as usize;
    (json["accessors"][accessor]["componentType"].clone(), raw(glb, accessor), number)
}

#[test]
fn joints_get_bytes_and_weights_on_request() {
    let glb = skinned(|i| [1.0 - (i + 1) as f32 / 64.0, (i + 1) as f32 / 64.0, 0.0, 0.0]);
    let exact = packed(&glb, Rounding::None);
    let [old, new] = [&glb, &exact].map(|glb| attribute(glb, "JOINTS_0"));
    assert_eq!((old.0, new.0), (json!(U16), json!(U8)));
    for (old, new) in old.1.iter().zip(&new.1) {
        assert_eq!(old.iter().step_by(2).collect::<Vec<_>>(), new.iter().collect::<Vec<_>>());
    }
    assert_eq!(attribute(&exact, "WEIGHTS_0").1, attribute(&glb, "WEIGHTS_0").1);
    let before = numbers(&glb, &attribute(&glb, "WEIGHTS_0").2);
    let mut files = vec![("exact.glb".into(), exact)];
    for (rounding, highest) in [(Rounding::Weights, 65535), (Rounding::WeightsAndRotations, 255)] {
        let rounded = packed(&glb, rounding);
        let (component, bytes, number) = attribute(&rounded, "WEIGHTS_0");
        let width = if highest == 255 { 1 } else { 2 };
        assert_eq!(component, json!(if width == 1 { U8 } else { U16 }));
        let mut changed = 0;
        for ((before, after), bytes) in before.iter().zip(numbers(&rounded, &number)).zip(bytes) {
            let parts =
                bytes.chunks(width).map(|part| part.iter().rev().fold(0, |sum, &b| 256 * sum + u32::from(b)));
            assert_eq!(parts.sum::<u32>(), highest);
            let least = 1.0 / f64::from(highest);
            assert!(before.iter().zip(&after).all(|(a, b)| (a - b).abs() < least));
            changed += usize::from(*before != after);
        }
        assert!(changed > 5);
        files.push((format!("{highest}.glb"), rounded));
    }
    validate("weights", &files);
}

#[test]
fn rotations_are_rounded_on_request() {
    let mut scene = Animated::new();
    let times: Vec<f32> = (0..40).map(|i| i as f32).collect();
    let turn = |t: f32| [(t * t).sin() * 0.6, (t * t).cos() * 0.6, 0.0, 0.8];
    let values: Vec<f32> = times.iter().flat_map(|&t| turn(t)).collect();
    scene.track("rotation", "LINEAR", &times, &values);
    let glb = scene.draft.glb();
    let after = packed(&glb, Rounding::WeightsAndRotations);
    let sampler = &json_of(&after)["animations"][0]["samplers"][0];
    let mut greatest: f64 = 0.0;
    for (row, old) in numbers(&after, &sampler["output"]).concat().iter().zip(values) {
        greatest = greatest.max((row - f64::from(old)).abs());
    }
    assert!(greatest > 1e-6 && greatest <= 1.0 / 65534.0 + 1e-9, "{greatest}");
    assert!(after.len() + 36 * 8 < packed(&glb, Rounding::None).len());
    validate("rotations", &[("after.glb".into(), after)]);
}

/// Documents with a few changed digits: if they can be read, they can be packed, and their parts
/// are the same.
#[test]
fn mutations_never_panic() {
    let mut scene = Animated::new();
    let times: Vec<f32> = (0..12).map(|i| i as f32).collect();
    scene.track(
        "rotation",
        "LINEAR",
        &times,
        &times.iter().flat_map(|t| [0.0, 0.0, (t / 9.0).sin(), (t / 9.0).cos()]).collect::<Vec<_>>(),
    );
    scene.track("translation", "STEP", &times, &[1.0; 36]);
    let scenes = [scene.draft.glb(), shared_scene(3).glb(), skinned(|_| [1.0, 0.0, 0.0, 0.0])];
    let mut done = 0;
    for changed in scenes.iter().flat_map(|glb| mutated_documents(glb, 500)) {
        let is_readable = read(changed.clone(), None).is_ok();
        let Ok(packed) = pack(changed.clone(), Rounding::WeightsAndRotations) else { continue };
        assert!(packed.len() <= changed.len());
        if is_readable {
            let [before, after] = [changed, packed].map(|glb| read(glb, None).unwrap());
            for (before, after) in before.parts.iter().zip(&after.parts) {
                assert_eq!(
                    (before.mesh.faces(), before.mesh.positions()),
                    (after.mesh.faces(), after.mesh.positions())
                );
            }
            done += 1;
        }
    }
    assert!(done > 400, "{done}");
}

#[test]
fn real_scenes_are_packed() {
    check_real_scenes("real_scenes_are_packed", |name, glb| {
        let after = packed(glb, Rounding::None);
        check_parts(glb, &after);
        vec![(format!("{name}_packed.glb"), after)]
    });
    let Some(folder) = std::env::var_os("TRISTRIP_MODELS").map(std::path::PathBuf::from) else { return };
    let man = std::fs::read(folder.join("textured/CesiumMan.glb")).unwrap();
    let after = packed(&man, Rounding::None);
    check_animations(&man, &after, 2e-6);
    assert!(after.len() + 40_000 < man.len());
    check_animations(&man, &packed(&man, Rounding::WeightsAndRotations), 1e-4);
}

#[test]
fn places_of_nodes_keep_their_floats() {
    let glb = skinned(|i| [1.0 - (i + 1) as f32 / 64.0, (i + 1) as f32 / 64.0, 0.0, 0.0]);
    let mut json = json_of(&glb);
    let third = 1.0_f32 / 3.0;
    // The last number is not a 32-bit float.
    let numbers = [f64::from(third), f64::from(0.1_f32), 0.1];
    json["nodes"][0]["translation"] = json!(numbers);
    json["nodes"][0]["extras"] = json!([f64::from(third)]);
    let glb = glb_of(json.to_string().as_bytes(), Some(bin_of(&glb)));
    let text = |rounding| json_of(&packed(&glb, rounding))["nodes"][0].clone();
    assert_eq!(text(Rounding::None)["translation"], json!(numbers));
    for rounding in [Rounding::Weights, Rounding::WeightsAndRotations] {
        let node = text(rounding);
        assert_eq!(node["translation"], json!([0.333_333_34, 0.1, 0.1]));
        assert_eq!(node["extras"], json!([f64::from(third)]));
    }
}
