//! Reordered vertices of models in all formats: all data of a vertex moves with it, and first uses
//! are in ascending order.
#![allow(clippy::format_push_string, reason = "a test may be slow")]

use tristrip::verify::verify_models;
use tristrip::{Attribute, AttributeData, Faces, Layout, Mesh, Strips};
use tristrip_io::{Drawing, Format, Model, Part, gltf, read, reorder, write};

use crate::gltf_documents::scenes::{grid, shared_scene};
use crate::gltf_documents::*;
use crate::reordered::{check, check_first_uses, drawn, meshes, strips_of};

const LAYOUTS: [Layout; 4] = [Layout::Restart, Layout::Degenerate, Layout::Separate, Layout::List];

#[test]
fn parts_drawn_by_their_faces_are_numbered_by_first_use() {
    let corners = vec![3, 0, 2, 1, 3, 0];
    let part = |z: f32| {
        let positions = (0..4).map(|i| [i as f32, (i * i) as f32, z]).collect::<Vec<_>>();
        let mesh = Mesh::new(positions, Faces::from_triangles(corners.clone()).unwrap()).unwrap();
        Part { mesh, ..Part::default() }
    };
    let model = Model { parts: vec![part(0.0), part(1.0)], ..Model::default() };
    let strips = strips_of(&model);
    for format in [Format::Glb, Format::Ply, Format::Obj] {
        let drawings = [Drawing::Faces, Drawing::Strips(&strips[1])];
        let reordered = reorder(&model, &drawings, format, Layout::Degenerate).unwrap();
        assert!(reordered.strips[0].is_none() && reordered.strips[1].is_some());
        assert_eq!(reordered.groups[0].order.new_to_old(), [3, 0, 2, 1]);
        assert_eq!(reordered.model.parts[0].mesh.faces().corners(), [0, 1, 2, 3, 0, 1]);
        let bytes = write(&reordered.model, &reordered.drawings(), format, reordered.layout).unwrap();
        let back = read(&bytes, format).unwrap();
        assert!(verify_models(&meshes(&model), &meshes(&back)).unwrap().is_ok());
    }
}

#[test]
fn ply_attributes_move_with_their_vertices() {
    let (positions, corners) = grid(5);
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double quality\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty short label\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        positions.len(),
        corners.len() / 3
    );
    for (i, [x, y, z]) in positions.iter().enumerate() {
        text += &format!(
            "{}.25 {x} {y} {z} {} {} 7 {}\n",
            i * 3,
            i,
            255 - i,
            1000 - i64::try_from(i).unwrap() * 40
        );
    }
    corners.chunks(3).for_each(|t| text += &format!("3 {} {} {}\n", t[0], t[1], t[2]));
    let model = read(text.as_bytes(), Format::Ply).unwrap();
    assert_eq!(model.parts[0].mesh.attributes().len(), 3);
    for layout in LAYOUTS {
        let (reordered, bytes) = check(&model, Format::Ply, layout);
        let back = read(&bytes, Format::Ply).unwrap();
        let order = &reordered.groups[0].order;
        assert!(order.moved_count() > 30);
        assert_eq!(back.parts[0].mesh.positions(), order.values(&positions, 1).unwrap());
        for (old, new) in model.parts[0].mesh.attributes().iter().zip(back.parts[0].mesh.attributes()) {
            assert_eq!(order.attribute(old).unwrap(), *new, "{}", old.name);
        }
        // The file has the same length as without reordering.
        let strips = strips_of(&model);
        let plain = write(&model, &[Drawing::Strips(&strips[0])], Format::Ply, layout).unwrap();
        assert_eq!(plain.len(), bytes.len());
        if layout == Layout::Restart || layout == Layout::Degenerate {
            // The file ends with the row of strips.
            let strips = reordered.strips[0].as_ref().unwrap();
            let length = strips.vertices_sent() + strips.len() - 1;
            let (row, _) = bytes[bytes.len() - 4 * length..].as_chunks::<4>();
            check_first_uses(row.iter().map(|b| u32::from_le_bytes(*b)).filter(|&v| v != u32::MAX), 0);
        }
    }
}

#[test]
fn obj_seams_and_normals_move_with_their_vertices() {
    let mut text = String::new();
    let (positions, corners) = grid(4);
    positions.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z} 0.5 {} 0.25\n", x / 8.0));
    (0..positions.len())
        .for_each(|i| text += &format!("vt {} 0.5\nvn {} 0 1\n", i as f32 / 64.0, i as f32 / 8.0));
    for (face, t) in corners.chunks(3).enumerate() {
        let material = if face % 5 == 0 { "usemtl a\n" } else { "usemtl b\n" };
        text += material;
        let other = |v: u32| (v as usize + face / 9) % positions.len() + 1;
        let corner = |v: u32| format!(" {}/{}/{}", v + 1, other(v), other(v + 2));
        text += &format!("f{}{}{}\n", corner(t[0]), corner(t[1]), corner(t[2]));
    }
    let model = read(text.as_bytes(), Format::Obj).unwrap();
    assert_eq!((model.parts.len(), model.parts[0].mesh.attributes().len()), (2, 3));
    for layout in LAYOUTS {
        check(&model, Format::Ply, layout);
        check(&model, Format::Glb, layout);
    }
    for format in [Format::Obj, Format::Ply, Format::Glb] {
        let (reordered, bytes) = check(&model, format, Layout::List);
        assert_eq!(reordered.groups.len(), 2);
        let corner_values = |model: &Model| {
            let mut all = Vec::new();
            for part in &model.parts {
                let value = |v: u32, a: &Attribute| {
                    let AttributeData::F32(values) = &a.data else { return Vec::new() };
                    let n = usize::from(a.components);
                    values[v as usize * n..][..n].iter().map(|x| x.to_bits()).collect()
                };
                let mut names: Vec<&Attribute> = part.mesh.attributes().iter().collect();
                names.sort_by_key(|a| a.name.trim_start_matches('_'));
                for face in part.mesh.faces().iter() {
                    let corner = |&v: &u32| {
                        let position = part.mesh.positions()[v as usize].map(f32::to_bits);
                        (position, names.iter().map(|a| value(v, a)).collect::<Vec<_>>())
                    };
                    let mut face: Vec<_> = face.iter().map(corner).collect();
                    let lowest = (0..3).min_by_key(|&i| face[i].clone()).unwrap();
                    face.rotate_left(lowest);
                    all.push(face);
                }
            }
            all.sort_unstable();
            all
        };
        // Every corner of every face has its old values.
        assert_eq!(corner_values(&read(&bytes, format).unwrap()), corner_values(&model), "{}", format.name());
    }
}

#[test]
fn parts_that_share_vertices_share_an_order() {
    let (positions, corners) = grid(4);
    let count = positions.len();
    let (first, second) = corners.split_at(30);
    let mesh = Mesh::new(positions, Faces::from_triangles(second.to_vec()).unwrap()).unwrap();
    let ids = AttributeData::U16((0..count as u16).collect());
    let id = Attribute { name: "_ID".into(), components: 1, normalized: false, data: ids };
    let other = mesh.clone().with_attribute(id).unwrap();
    let third = other.with_faces(Faces::from_triangles(first.to_vec()).unwrap()).unwrap();
    let part = |mesh: &Mesh| Part { mesh: mesh.clone(), ..Part::default() };
    let model = Model { parts: vec![part(&mesh), part(&other), part(&third)], ..Model::default() };
    let (reordered, glb) = check(&model, Format::Glb, Layout::Degenerate);
    assert_eq!(reordered.groups.iter().map(|g| g.parts.clone()).collect::<Vec<_>>(), [[0, 1, 2]]);
    let [a, b, c] = [0, 1, 2].map(|i| &reordered.model.parts[i].mesh);
    assert!(std::ptr::eq(a.positions(), b.positions()) && b.shares_vertices(c));
    assert_eq!(json_of(&glb)["accessors"].as_array().unwrap().len(), 2 + 3);
    // PLY writes separate vertices for each part with different attributes.
    let (reordered, _) = check(&model, Format::Ply, Layout::Restart);
    let parts: Vec<_> = reordered.groups.iter().map(|g| g.parts.clone()).collect();
    assert_eq!(parts, [[0], [1], [2]]);
    validate("parts_share_an_order", &[("built.glb".into(), glb)]);
}

#[test]
fn models_without_triangles_or_in_order_stay() {
    let part = |mesh| Part { mesh, ..Part::default() };
    let points = Mesh::new(bent(4), Faces::default()).unwrap();
    let sorted = Mesh::new(bent(3), Faces::from_triangles(vec![0, 1, 2]).unwrap()).unwrap();
    let parts = vec![part(Mesh::default()), part(points), part(sorted), part(Mesh::default())];
    let model = Model { parts, ..Model::default() };
    for (format, layout) in [Format::Ply, Format::Glb, Format::Obj].into_iter().zip(LAYOUTS) {
        let (reordered, _) = check(&model, format, layout);
        assert!(reordered.groups.iter().all(|group| group.order.moved_count() == 0 && group.kept.is_none()));
    }
    assert!(reorder(&Model::default(), &[], Format::Glb, Layout::Restart).unwrap().groups.is_empty());
    assert!(reorder(&model, &[], Format::Glb, Layout::Restart).is_err());
    let mut strips = vec![Strips::default(); 4];
    strips[2].push(&[0, 1, 3]);
    assert!(reorder(&model, &drawn(&strips), Format::Glb, Layout::Restart).is_err());
    let mut other = gltf::read(shared_scene(2).glb(), None).unwrap();
    other.parts.pop();
    let wrong =
        reorder(&other, &drawn(&[Strips::default(), Strips::default()]), Format::Glb, Layout::Restart);
    assert!(wrong.unwrap_err().to_string().contains("expected 3 as in the scene"));
    // The meshes of a scene's parts may have been replaced.
    other.parts.push(Part {
        mesh: Mesh::new(bent(4), Faces::from_triangles(vec![3, 2, 1]).unwrap()).unwrap(),
        ..Part::default()
    });
    let reordered = reorder(&other, &drawn(&strips_of(&other)), Format::Glb, Layout::Restart).unwrap();
    assert!(reordered.groups[1].kept.as_ref().unwrap().contains("one value per vertex"));
}
