//! Files, the viewer and the list: types, tags, ranges, compression, CORS.

use std::fs;
use std::io::{Read, Write};
use std::time::Duration;

use tristrip_serve::{Content, Limits, MemoryFile, Server, ServerOptions};

use super::client::{connect, read, request};
use super::{Running, grid, packs, write};

#[test]
fn files_have_types_tags_and_ranges() {
    let bytes: Vec<u8> = (0..200_000_u32).map(|i| (i.wrapping_mul(i) >> 7) as u8).collect();
    let server = Running::with_files(ServerOptions::default(), &[("a/b c.glb", &bytes), ("empty.txt", b"")]);
    let whole = server.get("/files/a/b%20c.glb");
    assert_eq!(
        (whole.status, whole.header("content-type"), whole.body.len()),
        (200, "model/gltf-binary", 200_000)
    );
    assert!(whole.body == bytes);
    assert_eq!((whole.header("accept-ranges"), whole.header("x-content-type-options")), ("bytes", "nosniff"));
    let etag = whole.header("etag");
    assert!(etag.starts_with('"') && !whole.header("last-modified").is_empty());
    let part = server.get_with("/files/a/b%20c.glb", "Range: bytes=70000-139999\r\n");
    assert_eq!((part.status, part.header("content-range")), (206, "bytes 70000-139999/200000"));
    assert!(part.body == bytes[70_000..140_000]);
    let end = server.get_with("/files/a/b%20c.glb", &format!("Range: bytes=-5\r\nIf-Range: {etag}\r\n"));
    assert!(end.status == 206 && end.body == bytes[199_995..]);
    let behind = server.get_with("/files/a/b%20c.glb", "Range: bytes=200000-\r\n");
    assert_eq!((behind.status, behind.header("content-range")), (416, "bytes */200000"));
    let known = server.get_with("/files/a/b%20c.glb", &format!("If-None-Match: {etag}\r\n"));
    assert_eq!((known.status, known.body.len(), known.header("etag")), (304, 0, etag));
    let since = format!("If-Modified-Since: {}\r\n", whole.header("last-modified"));
    assert_eq!(server.get_with("/files/a/b%20c.glb", &since).status, 304);
    write(server.folder.path(), "a/b c.glb", &bytes[..100_000]);
    let changed = server.get_with("/files/a/b%20c.glb", &format!("Range: bytes=0-9\r\nIf-Range: {etag}\r\n"));
    assert_eq!((changed.status, changed.body.len()), (200, 100_000));
    assert_eq!(server.get("/files/empty.txt").header("content-length"), "0");
    assert_eq!(server.get("/files/none.glb").status, 404);
    assert_eq!(server.get("/files/a").status, 404);
}

#[test]
fn heads_are_those_of_gets_without_bodies() {
    let server = Running::with_files(ServerOptions::default(), &[("a.stl", &[7; 5000])]);
    for path in ["/files/a.stl", "/", "/models.json", "/healthz", "/none", "/viewer.js"] {
        let get = server.get(path);
        let head = request(server.address, &format!("HEAD {path} HTTP/1.1\r\nHost: localhost\r\n"));
        assert_eq!((head.status, head.body.len()), (get.status, 0), "{path}");
        for name in ["content-type", "content-length", "etag", "accept-ranges", "cache-control"] {
            assert_eq!(head.header(name), get.header(name), "{path}: {name}");
        }
    }
    // Ranges are defined for GET only.
    for range in ["bytes=0-9", "bytes=9000-"] {
        let lines = format!("HEAD /files/a.stl HTTP/1.1\r\nHost: localhost\r\nRange: {range}\r\n");
        let whole = request(server.address, &lines);
        assert_eq!(
            (whole.status, whole.header("content-length"), whole.header("content-range")),
            (200, "5000", "")
        );
    }
}

#[test]
fn only_get_and_head_are_answered() {
    let server = Running::with_files(ServerOptions::default(), &[("a.stl", b"a")]);
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PROPFIND"] {
        let lines = format!("{method} /files/a.stl HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n");
        let response = request(server.address, &lines);
        assert_eq!((response.status, response.header("allow")), (405, "GET, HEAD"), "{method}");
    }
}

#[test]
fn text_is_compressed_and_models_are_not() {
    let obj = grid(20);
    let server = Running::with_files(
        ServerOptions::default(),
        &[("a.obj", &obj), ("a.glb", &obj), ("small.obj", b"v 0 0 0\n")],
    );
    let plain = server.get("/files/a.obj");
    let gzip = server.get_with("/files/a.obj", "Accept-Encoding: br, gzip\r\n");
    assert_eq!(
        (gzip.status, gzip.header("content-encoding"), plain.header("content-encoding")),
        (200, "gzip", "")
    );
    assert!(gzip.header("vary").to_ascii_lowercase().contains("accept-encoding"));
    assert!(gzip.body.len() < obj.len() / 2);
    let mut again = Vec::new();
    flate2::read::GzDecoder::new(&gzip.body[..]).read_to_end(&mut again).unwrap();
    assert!(again == obj);
    assert_eq!(gzip.header("etag"), format!("W/{}", plain.header("etag")));
    let known = format!("Accept-Encoding: gzip\r\nIf-None-Match: {}\r\n", gzip.header("etag"));
    assert_eq!(server.get_with("/files/a.obj", &known).status, 304);
    // A range of compressed bytes would be useless.
    let part = server.get_with("/files/a.obj", "Accept-Encoding: gzip\r\nRange: bytes=0-1999\r\n");
    assert_eq!((part.status, part.header("content-encoding"), part.body.len()), (206, "", 2000));
    for path in ["/files/a.glb", "/files/small.obj"] {
        assert_eq!(
            server.get_with(path, "Accept-Encoding: gzip\r\n").header("content-encoding"),
            "",
            "{path}"
        );
    }
}

#[test]
fn the_viewer_is_compressed_and_tagged() {
    let server = Running::new(ServerOptions::default());
    let page = server.get("/");
    assert_eq!((page.status, page.header("content-type")), (200, "text/html; charset=utf-8"));
    assert!(
        page.header("content-security-policy").starts_with("default-src 'self'; img-src 'self' blob: data:")
    );
    assert_eq!(page.header("cache-control"), "no-cache");
    let mut tags = Vec::new();
    for encoding in ["identity", "gzip", "br"] {
        let lines = format!("Accept-Encoding: {encoding}\r\n");
        let script = server.get_with("/worker.js", &lines);
        assert_eq!((script.status, script.header("content-type")), (200, "text/javascript; charset=utf-8"));
        assert_eq!(script.header("content-encoding"), if encoding == "identity" { "" } else { encoding });
        tags.push(script.header("etag").to_owned());
        let known =
            server.get_with("/worker.js", &format!("{lines}If-None-Match: {}\r\n", tags[tags.len() - 1]));
        assert_eq!(known.status, 304);
    }
    tags.dedup();
    assert_eq!(tags.len(), 3);
    assert_eq!(server.get("/package.json").status, 404);
    assert_eq!(server.get("/healthz").text(), "ok\n");
}

#[test]
fn models_are_listed_as_they_change() {
    let server = Running::with_files(packs(), &[("z.obj", &grid(30)), ("b/a.stl", b""), ("readme.txt", b"")]);
    let list = server.get("/models.json");
    let json: serde_json::Value = serde_json::from_slice(&list.body).unwrap();
    let urls: Vec<&str> =
        json["models"].as_array().unwrap().iter().map(|model| model["url"].as_str().unwrap()).collect();
    assert_eq!(urls, ["packed/b/a.stl.glb", "packed/z.obj.glb"]);
    let model = &json["models"][1];
    let keys: Vec<&String> = model.as_object().unwrap().keys().collect();
    assert_eq!(keys, ["name", "url", "kind", "bytes", "triangles", "vertices", "thumbnail"]);
    assert_eq!((&model["kind"], &model["triangles"]), (&"packed".into(), &serde_json::Value::Null));
    let packed = server.get("/packed/z.obj.glb");
    write(server.folder.path(), "c.glb", &packed.body);
    std::thread::sleep(Duration::from_millis(2100));
    let json: serde_json::Value = serde_json::from_slice(&server.get("/models.json").body).unwrap();
    let model = &json["models"][1];
    assert_eq!((&model["url"], &model["kind"]), (&"files/c.glb".into(), &"progressive".into()));
    assert_eq!((&model["triangles"], &model["vertices"]), (&1800.into(), &961.into()));
}

#[test]
fn origins_that_are_named_may_read() {
    let files: &[(&str, &[u8])] = &[("a.glb", b"glb")];
    let server =
        Running::with_files(ServerOptions::default().with_cors(vec!["https://example.org".into()]), files);
    let from = |origin: &str| server.get_with("/files/a.glb", &format!("Origin: {origin}\r\n"));
    let allowed = from("https://example.org");
    assert_eq!(allowed.header("access-control-allow-origin"), "https://example.org");
    let exposed = allowed.header("access-control-expose-headers").to_ascii_lowercase();
    for name in ["etag", "content-range", "accept-ranges", "content-length"] {
        assert!(exposed.contains(name), "{name}");
    }
    assert_eq!(from("https://evil.example").header("access-control-allow-origin"), "");
    let preflight = request(
        server.address,
        "OPTIONS /files/a.glb HTTP/1.1\r\nHost: localhost\r\nOrigin: https://example.org\r\nAccess-Control-Request-Method: GET\r\nAccess-Control-Request-Headers: range\r\n",
    );
    assert_eq!(preflight.status, 200);
    assert!(preflight.header("access-control-allow-headers").to_ascii_lowercase().contains("if-range"));
    let any = Running::with_files(ServerOptions::default().with_cors(vec!["*".into()]), files);
    assert_eq!(
        any.get_with("/files/a.glb", "Origin: https://evil.example\r\n")
            .header("access-control-allow-origin"),
        "*"
    );
    let none = Running::with_files(ServerOptions::default(), files);
    assert_eq!(
        none.get_with("/files/a.glb", "Origin: https://example.org\r\n")
            .header("access-control-allow-origin"),
        ""
    );
}

#[test]
fn a_file_that_becomes_shorter_ends_its_response_alone() {
    let server = Running::with_files(
        ServerOptions::default().with_bandwidth(Some(8_000_000)),
        &[("a.glb", &vec![1; 1_500_000]), ("b.glb", b"b")],
    );
    let mut socket = connect(server.address);
    socket.write_all(b"GET /files/a.glb HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    let mut first = [0; 1000];
    socket.read_exact(&mut first).unwrap();
    fs::OpenOptions::new()
        .write(true)
        .open(server.folder.path().join("a.glb"))
        .unwrap()
        .set_len(200_000)
        .unwrap();
    let mut rest = Vec::new();
    socket.read_to_end(&mut rest).unwrap_or_default();
    assert!(rest.len() < 1_400_000);
    assert_eq!(server.get("/files/b.glb").body, b"b");
}

#[test]
fn files_in_memory_are_served_and_drawn() {
    let model = tristrip_io::read(&grid(30), tristrip_io::Format::Obj).unwrap();
    let packed =
        tristrip_pipeline::pack::run(&model, &tristrip_pipeline::pack::Options::default(), &()).unwrap();
    let file = MemoryFile { name: "a b.glb".into(), bytes: packed.bytes.clone() };
    let server = Server::bind(Content::Files(vec![file]), &ServerOptions::default().with_port(0)).unwrap();
    let (address, stop) = (server.address(), server.stop_handle());
    assert_eq!(server.url(), format!("http://{address}/"));
    let running = std::thread::spawn(|| server.run());
    let get = |path: &str| request(address, &format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n"));
    assert!(get("/files/a%20b.glb").body == packed.bytes);
    assert_eq!(get("/files/other.glb").status, 404);
    let list: serde_json::Value = serde_json::from_slice(&get("/models.json").body).unwrap();
    assert_eq!(
        (&list["models"][0]["kind"], &list["models"][0]["triangles"]),
        (&"progressive".into(), &1800.into())
    );
    let png = get("/thumbnails/a%20b.glb.png");
    assert_eq!((png.status, png.header("content-type")), (200, "image/png"));
    assert!(png.body.starts_with(b"\x89PNG"));
    stop.stop();
    running.join().unwrap().unwrap();
    let bad = MemoryFile { name: "../a".into(), bytes: Vec::new() };
    assert!(Server::bind(Content::Files(vec![bad]), &ServerOptions::default().with_port(0)).is_err());
}

#[test]
fn a_file_in_memory_that_is_read_late_arrives_as_a_whole() {
    // More than the buffers of both sockets can hold.
    let bytes: Vec<u8> = (0..=250).cycle().take(20_000_000).collect();
    let file = MemoryFile { name: "a.glb".into(), bytes: bytes.clone() };
    let limits = Limits::default().with_idle_time(Duration::from_millis(200));
    let options = ServerOptions::default().with_port(0).with_limits(limits);
    let server = Server::bind(Content::Files(vec![file]), &options).unwrap();
    let (address, stop) = (server.address(), server.stop_handle());
    let running = std::thread::spawn(|| server.run());
    let mut socket = connect(address);
    socket
        .write_all(
            b"GET /files/a.glb HTTP/1.1\r\nHost: localhost\r\nRange: bytes=1-\r\nConnection: close\r\n\r\n",
        )
        .unwrap();
    std::thread::sleep(Duration::from_secs(1));
    let late = read(&mut socket);
    assert_eq!((late.status, late.header("content-length")), (206, "19999999"));
    assert!(late.body == bytes[1..]);
    stop.stop();
    running.join().unwrap().unwrap();
}

#[test]
fn connections_are_kept_between_requests() {
    let server = Running::with_files(ServerOptions::default(), &[("a.glb", b"a")]);
    let mut socket = connect(server.address);
    for _ in 0..3 {
        socket.write_all(b"GET /files/a.glb HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        let mut bytes = Vec::new();
        while !bytes.ends_with(b"\r\n\r\na") {
            let mut piece = [0; 512];
            let count = socket.read(&mut piece).unwrap();
            assert!(count > 0);
            bytes.extend(&piece[..count]);
        }
    }
    socket.write_all(b"GET /files/a.glb HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").unwrap();
    assert_eq!(read(&mut socket).status, 200);
    assert!(server.metric("tristrip_requests_total{route=\"files\",status=\"200\"}") >= 4);
}
