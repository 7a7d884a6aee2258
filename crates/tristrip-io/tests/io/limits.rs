//! The uses of `Error::LimitExceeded` listed in its documentation. Those that need a larger
//! document are in `gltf_limits` and `hostile_scenes`. A GLB of more than 4 GiB is not built.

use std::path::Path;
use std::sync::Arc;

use tristrip_io::gltf::{self, ArrivalLimits, ArrivingGlb};
use tristrip_io::tlod::{self, TlodLimits};
use tristrip_io::{Error, Format, read, read_beside};

/// Reads a file of `testdata`.
fn file(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata").join(name)).unwrap()
}

/// Returns the location of an exceeded limit, and the limit.
fn exceeded<T>(result: Result<T, Error>) -> (String, u64) {
    let error = result.map(drop).unwrap_err();
    let Error::LimitExceeded { at, found, limit } = error else { panic!("{error}") };
    assert!(found > limit, "{at}");
    (at, limit)
}

#[test]
fn limit_exceeded_is_returned_for_every_use_that_is_documented() {
    let result = read(&file("bad/vertices_beyond_32_bits.ply"), Format::Ply);
    assert_eq!(exceeded(result), ("line 3".into(), u64::from(u32::MAX) - 1));

    let values = format!(r#"{{"asset":{{"version":"2.0"}},"extras":[0{}]}}"#, ",0".repeat(4 << 20));
    assert_eq!(exceeded(gltf::read(values, None)), ("values of the JSON".into(), 4 << 20));

    let result = read(&file("bad/accessor_zeros_huge.glb"), Format::Glb);
    assert_eq!(exceeded(result).0, "accessors[0], bytes decoded so far");

    let few = TlodLimits::default().with_triangles(3);
    let result = tlod::read(&file("models/fish_control.tlod")[..], &few);
    assert_eq!(exceeded(result), ("byte 40, triangles".into(), 3));

    let mut arriving = ArrivingGlb::new(ArrivalLimits::default().with_kept_bytes(100));
    let result = arriving.update(&file("models/milktruck.glb"));
    assert_eq!(exceeded(result), ("bytes before the first chunk".into(), 100));

    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("a.bin"), [0; 36]).unwrap();
    let text = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"a.bin"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]}"#;
    let bytes = Arc::new(text.as_bytes().to_vec());
    let path = dir.path().join("a.gltf");
    assert!(read_beside(&bytes, Format::Gltf, &path, 36).is_ok());
    let (at, limit) = exceeded(read_beside(&bytes, Format::Gltf, &path, 35));
    assert!(at.ends_with("a.bin") && limit == 35, "{at}");
}
