//! Scenes whose parts get new vertices: each has all values of its source except the new normal.

use serde_json::{Value, json};
use tristrip::Layout;
use tristrip_io::{
    Drawing, Format, Model, NewValues, NewVertices, fixed_vertices, gltf, with_new_vertices, with_triangles,
    write,
};

use crate::gltf_documents::scenes::{raw, shared_scene};
use crate::gltf_documents::*;
use crate::random::mutated_documents;

const NEW: [f32; 3] = [0.6, 0.0, -0.8];

/// Gives the first triangles of some parts separate vertices and writes the scene. Returns it with
/// the source of each corner.
fn rebuilt(model: &Model, parts: &[usize], left: usize) -> (Vec<u8>, Vec<Vec<u32>>) {
    with_values(model, parts, left, NewValues::Directions)
}

/// Like [`rebuilt`], with new normals or new positions, which are all [`NEW`].
fn with_values(model: &Model, parts: &[usize], left: usize, values: NewValues) -> (Vec<u8>, Vec<Vec<u32>>) {
    let list = |part: usize| model.parts[part].mesh.faces().as_triangles().unwrap();
    let sources: Vec<Vec<u32>> = (0..model.parts.len())
        .map(|part| list(part)[..3 * left.min(list(part).len() / 3)].to_vec())
        .collect();
    let new = |part: usize| {
        let sources = sources[part].clone();
        let all = vec![NEW; sources.len()];
        let (normals, positions) =
            if values == NewValues::Positions { (Vec::new(), all) } else { (all, Vec::new()) };
        let new = NewVertices { sources, normals, positions, ..NewVertices::default() };
        parts.contains(&part).then_some(new)
    };
    let added: Vec<_> = (0..model.parts.len()).map(new).collect();
    let extended = with_new_vertices(model, &added, Format::Glb).unwrap();
    let triangles = sources.iter().zip(&extended.first).map(|(sources, first)| match first {
        Some(first) => (*first..).take(sources.len()).collect(),
        None => sources.clone(),
    });
    let redrawn = with_triangles(&extended.model, triangles.collect(), Format::Glb).unwrap();
    let drawings = vec![Drawing::Faces; model.parts.len()];
    (write(&redrawn.model, &drawings, Format::Glb, Layout::List).unwrap(), sources)
}

/// Checks all values of all corners by the bytes of both files.
fn check(before: &[u8], after: &[u8], parts: &[usize], sources: &[Vec<u32>]) {
    let (old, new) = (json_of(before), json_of(after));
    let number = |value: &Value| value.as_u64().unwrap() as usize;
    let primitives = |json: &Value| -> Vec<Value> {
        let meshes = json["meshes"].as_array().unwrap().iter();
        meshes.flat_map(|mesh| mesh["primitives"].as_array().unwrap().clone()).collect()
    };
    for (part, (old, new)) in primitives(&old).into_iter().zip(primitives(&new)).enumerate() {
        assert_eq!((&old["attributes"], &old["targets"]), (&new["attributes"], &new["targets"]));
        let indices = raw(after, number(&new["indices"]));
        let drawn = indices.iter().map(|b| b.iter().rev().fold(0, |n, &b| n << 8 | usize::from(b)));
        let drawn: Vec<usize> = drawn.collect();
        assert_eq!(drawn.len(), sources[part].len());
        let objects = old["targets"].as_array().into_iter().flatten().chain([&old["attributes"]]);
        for (name, accessor) in objects.flat_map(|object| object.as_object().unwrap()) {
            let [old, new] = [before, after].map(|glb| raw(glb, number(accessor)));
            for (&source, &vertex) in sources[part].iter().zip(&drawn) {
                if name == "NORMAL" && parts.contains(&part) {
                    assert_eq!(new[vertex], floats(&NEW));
                } else {
                    assert_eq!(new[vertex], old[source as usize], "part {part}, {name}");
                }
            }
        }
    }
    for key in ["nodes", "scenes", "skins", "materials", "images"] {
        assert_eq!(old.get(key), new.get(key));
    }
}

/// Interleaved, sparse, matrix and integer values of vertices shared by two parts; one part gets
/// new normals.
#[test]
fn new_vertices_have_all_values_of_their_sources() {
    let draft = shared_scene(6);
    let glb = draft.glb();
    let model = gltf::read(&glb[..], None).unwrap();
    assert_eq!(fixed_vertices(&model, NewValues::Directions, Format::Glb).unwrap(), [None, None, None]);
    let mut files = Vec::new();
    for left in [4, 1000] {
        let (after, sources) = rebuilt(&model, &[0], left);
        check(&glb, &after, &[0], &sources);
        files.push((format!("new_{left}.glb"), after));
    }
    // The written file has no unused vertices, and is smaller if fewer remain.
    let count = json_of(&files[0].1)["accessors"][0]["count"].as_u64().unwrap();
    assert!((12 + 5..=24).contains(&count) && files[0].1.len() < glb.len());
    let again = gltf::read(&files[1].1[..], None).unwrap();
    let (twice, sources) = rebuilt(&again, &[0], 3);
    check(&files[1].1, &twice, &[0], &sources);
    files.push(("twice.glb".into(), twice));
    validate("new_vertices", &files);
}

/// A fitted part shares vertices with another. The other part keeps its positions, and bounds match
/// the values.
#[test]
fn new_positions_are_written_with_their_bounds() {
    let glb = shared_scene(6).glb();
    let model = gltf::read(&glb[..], None).unwrap();
    let fixed = fixed_vertices(&model, NewValues::Positions, Format::Glb).unwrap();
    assert_eq!(fixed, [Some("a morph target changes them".into()), None, None]);
    let place = |i: usize| [100.0 + i as f32, -50.0, 0.25];
    let added: Vec<Option<NewVertices>> = (0..3)
        .map(|part| {
            let sources = model.parts[part].mesh.faces().corners().to_vec();
            let positions = (0..sources.len()).map(place).collect();
            (part > 0).then_some(NewVertices { sources, positions, ..NewVertices::default() })
        })
        .collect();
    let extended = with_new_vertices(&model, &added, Format::Glb).unwrap();
    let lists = (0..3).map(|part| match extended.first[part] {
        Some(first) => (first..).take(added[part].as_ref().unwrap().sources.len()).collect(),
        None => model.parts[part].mesh.faces().corners().to_vec(),
    });
    let redrawn = with_triangles(&extended.model, lists.collect(), Format::Glb).unwrap();
    let drawings = vec![Drawing::Faces; 3];
    let after = write(&redrawn.model, &drawings, Format::Glb, Layout::List).unwrap();
    let back = gltf::read(&after[..], None).unwrap();
    for part in 0..3 {
        let [old, new] = [&model, &back].map(|model| &model.parts[part].mesh);
        assert_eq!(old.faces().corner_count(), new.faces().corner_count());
        for (i, (&a, &b)) in old.faces().corners().iter().zip(new.faces().corners()).enumerate() {
            let expected = if part == 0 { old.positions()[a as usize] } else { place(i) };
            assert_eq!(new.positions()[b as usize].map(f32::to_bits), expected.map(f32::to_bits), "{part}");
        }
    }
    let json = json_of(&after);
    for mesh in json["meshes"].as_array().unwrap() {
        for primitive in mesh["primitives"].as_array().unwrap() {
            let accessor = &json["accessors"][primitive["attributes"]["POSITION"].as_u64().unwrap() as usize];
            assert!(accessor.get("min").is_some() && accessor.get("max").is_some(), "{accessor}");
        }
    }
    assert_eq!(
        json["accessors"][0]["max"][0],
        f64::from(place(added[1].as_ref().unwrap().sources.len() - 1)[0])
    );
    validate("new_positions", &[("fitted.glb".into(), after)]);
}

#[test]
fn vertices_are_fixed_where_something_depends_on_them() {
    let why = |change: &dyn Fn(&mut Value), part: usize| {
        let mut draft = shared_scene(4);
        change(&mut draft.json);
        let model = gltf::read(draft.glb(), None).unwrap();
        fixed_vertices(&model, NewValues::Directions, Format::Glb).unwrap()[part].clone().unwrap_or_default()
    };
    assert_eq!(why(&|_| (), 0), "");
    let morph: &dyn Fn(&mut Value) =
        &|json| json["meshes"][0]["primitives"][0]["targets"][0]["NORMAL"] = 1.into();
    assert_eq!(why(morph, 0), "a morph target changes them");
    assert_eq!(why(morph, 1), "");
    let named: &dyn Fn(&mut Value) = &|json| json["asset"]["extras"] = json!([4.5, 11]);
    assert!(why(named, 2).contains("may refer to their accessors"));
    let bytes: &dyn Fn(&mut Value) = &|json| {
        json["accessors"][1]["componentType"] = 5121.into();
        json["accessors"][1]["normalized"] = true.into();
    };
    assert!(why(bytes, 0).contains("cannot represent directions"));
    let role: &dyn Fn(&mut Value) =
        &|json| json["meshes"][1]["primitives"][0]["attributes"]["POSITION"] = 1.into();
    assert_eq!(why(role, 0), "other values share their accessor");
    // Integer positions are on a grid, which other parts of a surface may not share.
    let mut draft = shared_scene(4);
    draft.json["accessors"][0]["componentType"] = 5122.into();
    draft.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let model = gltf::read(draft.glb(), None).unwrap();
    let fixed = fixed_vertices(&model, NewValues::Positions, Format::Glb).unwrap();
    assert_eq!(fixed[1].as_deref(), Some("they are stored as integers"));
}

/// Documents with a few changed bytes: a model that can be read can get new vertices, or there is a
/// reason why not.
#[test]
fn mutations_never_panic() {
    let glb = shared_scene(3).glb();
    let mut done = [0; 2];
    for changed in mutated_documents(&glb, 3000) {
        let Ok(model) = gltf::read(&changed[..], None) else { continue };
        for (values, done) in [NewValues::Directions, NewValues::Positions].into_iter().zip(&mut done) {
            let fixed = fixed_vertices(&model, values, Format::Glb).unwrap();
            let parts: Vec<usize> = (0..fixed.len()).filter(|&part| fixed[part].is_none()).collect();
            let (after, sources) = with_values(&model, &parts, 5, values);
            let back = gltf::read(after, None).unwrap();
            for (part, (before, after)) in model.parts.iter().zip(&back.parts).enumerate() {
                let is_new = parts.contains(&part);
                for (&old, &new) in sources[part].iter().zip(after.mesh.faces().corners()) {
                    let [old_at, new_at] = [(&before.mesh, old), (&after.mesh, new)]
                        .map(|(mesh, v)| mesh.positions()[v as usize]);
                    let expected = if is_new && values == NewValues::Positions { NEW } else { old_at };
                    assert_eq!(expected.map(f32::to_bits), new_at.map(f32::to_bits));
                    let normal =
                        after.mesh.attributes().iter().find(|a| a.name == "NORMAL" && a.components == 3);
                    if let Some(normal) = normal.filter(|_| is_new && values == NewValues::Directions) {
                        let x = normal.float(3 * new as usize).unwrap();
                        assert!((x - NEW[0]).abs() < 0.01, "{x}");
                    }
                }
            }
            *done += usize::from(!parts.is_empty());
        }
    }
    assert!(done.iter().all(|&done| done > 500), "{done:?}");
}
