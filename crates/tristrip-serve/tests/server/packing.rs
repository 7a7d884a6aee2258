//! Packing on demand: once for all requests, again after a file has changed, failures, and the
//! cache.

use std::fs;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use tempfile::TempDir;
use tristrip_io::gltf::ProgressiveGlb;
use tristrip_serve::{PackingOptions, ServerOptions};

use super::{Running, grid, packs, write};

const DONE: &str = "tristrip_jobs_total{kind=\"packing\",result=\"done\"}";
const FAILED: &str = "tristrip_jobs_total{kind=\"packing\",result=\"failed\"}";

fn cached(cache: &TempDir) -> Vec<std::path::PathBuf> {
    fs::read_dir(cache.path()).unwrap().map(|entry| entry.unwrap().path()).collect()
}

#[test]
fn many_clients_share_one_packing() {
    let server = Running::with_files(packs(), &[("grid.obj", &grid(60))]);
    let bodies: Vec<Vec<u8>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..50).map(|_| scope.spawn(|| server.get("/packed/grid.obj.glb"))).collect();
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap())
            .map(|response| {
                assert_eq!((response.status, response.header("content-type")), (200, "model/gltf-binary"));
                response.body
            })
            .collect()
    });
    assert!(bodies.iter().all(|body| *body == bodies[0]));
    assert!(ProgressiveGlb::open(bodies[0].clone()).unwrap().is_some_and(|glb| glb.is_complete()));
    assert_eq!(server.metric(DONE), 1);
    // The same bytes as from `pack`.
    let model = tristrip_io::read(&grid(60), tristrip_io::Format::Obj).unwrap();
    let packed =
        tristrip_pipeline::pack::run(&model, &tristrip_pipeline::pack::Options::default(), &()).unwrap();
    assert!(packed.bytes == bodies[0]);
}

#[test]
fn a_packed_file_has_ranges_and_is_made_again_when_its_source_changes() {
    let server = Running::with_files(packs(), &[("a/grid.obj", &grid(40))]);
    let first = server.get("/packed/a/grid.obj.glb");
    let part = server.get_with("/packed/a/grid.obj.glb", "Range: bytes=100-199\r\n");
    assert!(part.status == 206 && part.body == first.body[100..200]);
    assert_eq!(
        server
            .get_with("/packed/a/grid.obj.glb", &format!("If-None-Match: {}\r\n", first.header("etag")))
            .status,
        304
    );
    assert_eq!((server.metric(DONE), server.metric("tristrip_cache_misses_total")), (1, 1));
    write(server.folder.path(), "a/grid.obj", &grid(41));
    let second = server.get("/packed/a/grid.obj.glb");
    assert!(second.body != first.body && second.header("etag") != first.header("etag"));
    // A material library that an OBJ may refer to is part of its key.
    write(server.folder.path(), "a/grid.mtl", b"newmtl a\n");
    server.get("/packed/a/grid.obj.glb");
    assert_eq!(server.metric(DONE), 3);
}

#[test]
fn results_are_kept_and_damage_is_found() {
    let server = Running::with_files(packs(), &[("grid.obj", &grid(40))]);
    let first = server.get("/packed/grid.obj.glb").body;
    let (folder, cache) = ended(server);
    write(cache.path(), "tristrip-left.writing", b"half a file");
    let server = Running::with_folders(packs(), folder, cache);
    assert!(server.get("/packed/grid.obj.glb").body == first);
    assert_eq!((server.metric(DONE), server.metric("tristrip_cache_hits_total")), (0, 1));
    let files = cached(&server.cache);
    assert_eq!(files.len(), 1, "{files:?}");
    let (folder, cache) = ended(server);
    let mut bytes = fs::read(&files[0]).unwrap();
    bytes[500] ^= 1;
    fs::write(&files[0], bytes).unwrap();
    let server = Running::with_folders(packs(), folder, cache);
    assert!(server.get("/packed/grid.obj.glb").body == first);
    assert_eq!(server.metric(DONE), 1);
}

/// Ends a server and returns its directories.
fn ended(mut server: Running) -> (TempDir, TempDir) {
    server.stop.stop();
    server.thread.take().unwrap().join().unwrap().unwrap();
    let empty = || tempfile::tempdir().unwrap();
    (std::mem::replace(&mut server.folder, empty()), std::mem::replace(&mut server.cache, empty()))
}

#[test]
fn the_cache_stays_within_its_bytes() {
    let packing = PackingOptions::default().with_on_demand(true).with_cache(None, 12_000);
    let files: Vec<(String, Vec<u8>)> = (0..4).map(|i| (format!("{i}.obj"), grid(40 + i))).collect();
    let files: Vec<(&str, &[u8])> =
        files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())).collect();
    let server = Running::with_files(ServerOptions::default().with_packing(packing), &files);
    for (name, _) in &files {
        assert_eq!(server.get(&format!("/packed/{name}.glb")).status, 200);
    }
    let used: u64 = cached(&server.cache).iter().map(|path| fs::metadata(path).unwrap().len()).sum();
    assert!(used <= 12_000, "{used}");
    assert_eq!(server.metric("tristrip_cache_bytes"), used);
}

#[test]
fn a_file_that_cannot_be_packed_says_why() {
    let packing = PackingOptions::default().with_on_demand(true).with_largest_input_bytes(10_000);
    let files: &[(&str, &[u8])] =
        &[("broken.ply", b"ply\nformat nothing\n"), ("large.obj", &grid(40)), ("text.txt", b"text")];
    let server = Running::with_files(ServerOptions::default().with_packing(packing), files);
    let broken = server.get("/packed/broken.ply.glb");
    assert_eq!((broken.status, broken.header("content-type")), (422, "text/plain; charset=utf-8"));
    assert!(broken.text().contains("expected"), "{}", broken.text());
    assert_eq!(server.get("/packed/broken.ply.glb").status, 422);
    assert_eq!(server.metric(FAILED), 1, "a failure is remembered");
    let large = server.get("/packed/large.obj.glb");
    assert!(large.status == 422 && large.text().contains("expected at most 10000"), "{}", large.text());
    assert_eq!(server.get("/packed/text.txt.glb").status, 404);
    assert_eq!(server.get("/thumbnails/broken.ply.png").status, 422);
    let plain = Running::with_files(ServerOptions::default(), &[("grid.obj", &grid(10))]);
    assert_eq!(plain.get("/packed/grid.obj.glb").status, 404, "only with --pack-on-demand");
}

#[test]
fn a_slow_reader_holds_no_packing() {
    let packing = PackingOptions::default().with_on_demand(true).with_at_once(1);
    let options = ServerOptions::default().with_packing(packing).with_bandwidth(Some(80_000));
    let server = Running::with_files(
        options,
        &[("a.obj", &grid(60)), ("b.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")],
    );
    let is_read = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let slow = scope.spawn(|| {
            let status = server.get("/packed/a.obj.glb").status;
            is_read.store(true, Ordering::SeqCst);
            status
        });
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(server.get("/packed/b.obj.glb").status, 200);
        assert!(!is_read.load(Ordering::SeqCst), "it waited for the slow reader");
        assert_eq!(slow.join().unwrap(), 200);
    });
}

#[test]
fn thumbnails_are_drawn_once() {
    let obj = [b"mtllib a.mtl\nusemtl red\n".to_vec(), grid(20)].concat();
    let files: &[(&str, &[u8])] = &[("a.obj", &obj), ("a.mtl", b"newmtl red\nKd 1 0 0\n"), ("b.stl", b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n")];
    let server = Running::with_files(ServerOptions::default(), files);
    let first = server.get("/thumbnails/a.obj.png");
    assert_eq!((first.status, first.header("content-type")), (200, "image/png"));
    assert!(server.get("/thumbnails/a.obj.png").body == first.body);
    assert_eq!(server.get("/thumbnails/b.stl.png").status, 200);
    assert_eq!(server.metric("tristrip_jobs_total{kind=\"thumbnail\",result=\"done\"}"), 2);
    assert_eq!(server.get("/thumbnails/none.obj.png").status, 404);
}

#[test]
fn a_client_that_would_wait_too_long_is_told_to_come_back() {
    let packing = PackingOptions::default().with_on_demand(true).with_wait_time(Duration::ZERO);
    let server =
        Running::with_files(ServerOptions::default().with_packing(packing), &[("grid.obj", &grid(60))]);
    let first = server.get("/packed/grid.obj.glb");
    assert_eq!((first.status, first.header("retry-after")), (503, "2"), "{}", first.text());
    assert_eq!(first.header("cache-control"), "no-store");
    let start = Instant::now();
    while server.metric(DONE) == 0 {
        assert!(start.elapsed() < Duration::from_mins(1));
        std::thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(server.get("/packed/grid.obj.glb").status, 200);
}

#[test]
fn a_packing_is_given_up_at_its_deadline() {
    let packing = PackingOptions::default().with_on_demand(true).with_job_time(Duration::ZERO);
    let server =
        Running::with_files(ServerOptions::default().with_packing(packing), &[("grid.obj", &grid(60))]);
    let given_up = server.get("/packed/grid.obj.glb");
    assert_eq!((given_up.status, given_up.text().as_str()), (422, "the job takes longer than 0ns\n"));
    assert_eq!(server.get("/thumbnails/grid.obj.png").status, 422);
    assert_eq!((server.metric(DONE), server.metric(FAILED)), (0, 1));
}
