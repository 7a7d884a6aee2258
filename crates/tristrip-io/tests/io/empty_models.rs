//! Models without triangles: each format writes a file that reads as a model without triangles, or
//! reports that there is nothing to write.

use tristrip::verify::verify_models;
use tristrip::{Faces, Layout, Mesh, Strips};
use tristrip_io::{Drawing, Format, Model, Part, read, write};

const LAYOUTS: [Layout; 4] = [Layout::Degenerate, Layout::Restart, Layout::Separate, Layout::List];

fn part(vertex_count: usize, offsets: &[u32], corners: &[u32]) -> Part {
    let positions: Vec<_> = (0..vertex_count).map(|i| [i as f32, 1.0, 2.0]).collect();
    let faces = Faces::from_offsets(offsets.to_vec(), corners.to_vec()).unwrap();
    Part { mesh: Mesh::new(positions, faces).unwrap(), name: Some("a".into()), ..Part::default() }
}

fn meshes(model: &Model) -> Vec<&Mesh> {
    model.parts.iter().map(|part| &part.mesh).collect()
}

/// Writes parts in every layout, as faces and as empty strips. Calls `check` with the model and the
/// file.
fn write_all(parts: Vec<Part>, format: Format, check: impl Fn(&Model, Result<Vec<u8>, tristrip_io::Error>)) {
    let (model, nothing) = (Model { parts, ..Model::default() }, Strips::default());
    for layout in LAYOUTS {
        for drawing in [Drawing::Faces, Drawing::Strips(&nothing)] {
            check(&model, write(&model, &vec![drawing; model.parts.len()], format, layout));
        }
    }
}

#[test]
fn models_that_draw_nothing_are_written_and_read_again() {
    let models: [fn() -> Vec<Part>; 4] = [
        || vec![part(3, &[0], &[])],
        || vec![part(3, &[0, 3, 6], &[0, 0, 1, 2, 2, 2])],
        || vec![part(3, &[0, 2, 3, 3], &[0, 1, 2])],
        || vec![part(0, &[0], &[]), part(2, &[0, 4], &[1, 1, 1, 0])],
    ];
    for parts in models {
        for format in [Format::Obj, Format::Ply, Format::Glb] {
            write_all(parts(), format, |model, written| {
                let again = read(&written.unwrap(), format).unwrap();
                assert!(verify_models(&meshes(model), &meshes(&again)).unwrap().is_ok());
            });
        }
    }
}

#[test]
fn a_model_without_vertices_is_written_where_a_format_has_such_files() {
    for parts in [Vec::new, || vec![part(0, &[0], &[])], || vec![part(0, &[0], &[]), part(0, &[0], &[])]] {
        for format in [Format::Ply, Format::Glb] {
            write_all(parts(), format, |_, written| {
                let again = read(&written.unwrap(), format).unwrap();
                assert!(meshes(&again).iter().all(|mesh| mesh.vertex_count() == 0));
            });
        }
        write_all(parts(), Format::Obj, |_, written| {
            let expected = "nothing to write: the model has no vertices, and an OBJ file needs at least one";
            assert_eq!(written.unwrap_err().to_string(), expected);
        });
    }
}

/// glTF does not allow empty arrays at the root of a document.
#[test]
fn a_scene_without_meshes_gets_no_empty_arrays() {
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"camera":0}],
        "cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":1}}]}"#;
    let model = read(json.as_bytes(), Format::Glb).unwrap();
    for layout in LAYOUTS {
        for compact in [false, true] {
            let smaller = tristrip_io::with_triangles(&model, Vec::new(), Format::Glb).unwrap().model;
            let written = write(if compact { &smaller } else { &model }, &[], Format::Glb, layout).unwrap();
            let text = String::from_utf8_lossy(&written);
            assert!(text.contains("cameras") && !text.contains("[]"), "{text}");
            assert!(read(&written, Format::Glb).unwrap().parts.is_empty());
        }
    }
}
