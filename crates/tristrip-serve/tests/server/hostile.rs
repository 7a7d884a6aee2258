//! Hostile clients: more than 200 bad paths, host names of other sites, links, and endless request
//! heads.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;

use tristrip_serve::ServerOptions;

use super::Running;
use super::client::{connect, parse, read, request};

/// Text that no response may contain.
const SECRET: &str = "the secret outside the folder";

/// Returns more than 200 paths that lead outside the directory, or to no file, on some system.
fn paths() -> BTreeSet<String> {
    let ups = [
        "..",
        "%2e%2e",
        ".%2e",
        "%2E.",
        "..%00",
        "%2e%2e%2f..",
        "..%5c..",
        "..\\..",
        "%c0%ae%c0%ae",
        "%252e%252e",
        "%u002e%u002e",
        "....",
        "...",
        "..;",
        ".. ",
        "%e0%80%ae%e0%80%ae",
        "%ff%fe",
        "%f8%80%80%80%ae",
    ];
    let separators = ["/", "%2f", "%5c", "\\", "//", "/./"];
    let targets = ["secret", "etc/passwd", "secret%00.glb"];
    let mut paths = BTreeSet::new();
    for up in ups {
        for separator in separators {
            for target in targets {
                for depth in [1, 4] {
                    paths.insert(format!("/files/{}{target}", format!("{up}{separator}").repeat(depth)));
                }
            }
            paths.insert(format!("/packed/{up}{separator}secret.glb"));
            paths.insert(format!("/thumbnails/a/{up}{separator}{up}{separator}secret.png"));
        }
    }
    let others = [
        "/files//etc/passwd",
        "/files/%2fetc%2fpasswd",
        "/files/C:/secret",
        "/files/C%3a%5csecret",
        "/files/a.glb::$DATA",
        "/files/a.glb.",
        "/files/a.glb%20",
        "/files/CON",
        "/files/nul.glb",
        "/files/COM1",
        "/files/lpt1.txt",
        "/files/aux",
        "/files/%00",
        "/files/a.glb%00",
        "/files/%0d%0aSet-Cookie:a",
        "/files/a%0ab",
        "/files/.hidden",
        "/files/.git/config",
        "/files/dir/.env",
        "/files/",
        "/files/.",
        "/files/..",
        "/files",
        "/files/%",
        "/files/%zz",
        "/files/%2",
        "/files/link",
        "/files/absolute",
        "/files/folder/secret",
        "/files/pipe",
        "/files/dir",
        "/files/dir/",
        "/files/a.glb/",
        "/files/a.glb/b",
        "/files/?a.glb",
        "/packed/a.glb",
        "/packed/../secret.glb.glb",
        "/packed/link.glb",
        "/packed/none.ply.glb",
        "/packed/.hidden.ply.glb",
        "/packed/dir.glb",
        "/packed/.glb",
        "/thumbnails/link.png",
        "/thumbnails/absolute.ply.png",
        "/thumbnails/.png",
        "/thumbnails/dir.png",
        "/viewer/../../Cargo.toml",
        "/src/..%2f..%2fCargo.toml",
        "/src/%2e%2e/package.json",
        "/node_modules/x",
        "/package.json",
        "/test/decoder.test.js",
        "/..",
        "/%2e%2e/",
        "//etc/passwd",
        "/\\etc",
        "/etc/passwd",
        "/proc/self/environ",
        "/files/~root",
        "/files/$HOME",
        "/files/a|b",
        "/files/a*",
        "/models.json/..",
        "/index.html/x",
        "/metrics/..",
        "/files/\u{202e}",
        "/FILES/a.glb",
        "/files\\a.glb",
        "/files;/a.glb",
    ];
    paths.extend(others.map(str::to_owned));
    paths.insert(format!("/files/{}", "a".repeat(5000)));
    paths.insert(format!("/files/{}", "a/".repeat(500)));
    paths.insert(format!("/files/{}", "%61".repeat(4000)));
    paths
}

fn folder_with_traps() -> (Running, tempfile::TempDir) {
    let files: &[(&str, &[u8])] = &[
        ("a.glb", b"a"),
        ("dir/a.glb", b"a"),
        (".hidden", SECRET.as_bytes()),
        (".git/config", SECRET.as_bytes()),
        ("dir/.env", SECRET.as_bytes()),
    ];
    let server = Running::with_files(super::packs(), files);
    let outside = tempfile::tempdir().unwrap();
    fs::write(outside.path().join("secret"), SECRET).unwrap();
    fs::write(outside.path().join("secret.ply"), SECRET).unwrap();
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        let (root, outside) = (server.folder.path(), outside.path());
        symlink(outside.join("secret"), root.join("absolute")).unwrap();
        symlink(outside.join("secret.ply"), root.join("absolute.ply")).unwrap();
        let name = outside.file_name().unwrap().to_str().unwrap();
        symlink(format!("../{name}/secret"), root.join("link")).unwrap();
        symlink(outside, root.join("folder")).unwrap();
        rustix::fs::mkfifoat(rustix::fs::CWD, root.join("pipe"), rustix::fs::Mode::RUSR).unwrap();
    }
    (server, outside)
}

#[test]
fn no_path_leads_out_of_the_folder() {
    let (server, _outside) = folder_with_traps();
    let paths = paths();
    assert!(paths.len() >= 200, "{}", paths.len());
    for path in &paths {
        let response = server.get(path);
        assert!((400..500).contains(&response.status), "{path}: {}", response.status);
        assert!(!response.text().contains(SECRET), "{path}");
    }
    assert_eq!(server.get("/files/a.glb").status, 200);
    assert!(!server.get("/models.json").text().contains("absolute"));
}

#[cfg(unix)]
#[test]
fn a_link_that_changes_all_the_time_never_leads_out() {
    use std::sync::atomic::{AtomicBool, Ordering};
    let (server, outside) = folder_with_traps();
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let (link, new) = (server.folder.path().join("changing"), server.folder.path().join("new"));
            let targets = [outside.path().join("secret"), "a.glb".into()];
            for target in targets.iter().cycle() {
                std::os::unix::fs::symlink(target, &new).unwrap();
                fs::rename(&new, &link).unwrap();
                if stop.load(Ordering::Relaxed) {
                    break;
                }
            }
        });
        for _ in 0..200 {
            let response = server.get("/files/changing");
            assert!([200, 404].contains(&response.status));
            assert!(!response.text().contains(SECRET));
        }
        stop.store(true, Ordering::Relaxed);
    });
}

#[test]
fn names_of_other_sites_are_refused() {
    let server = Running::with_files(
        ServerOptions::default().with_hosts(vec!["models.example".into()]),
        &[("a.glb", b"a")],
    );
    let status = |host: &str| {
        request(server.address, &format!("GET /files/a.glb HTTP/1.1\r\nHost: {host}\r\n")).status
    };
    for host in ["localhost", "localhost:8080", "127.0.0.1", "[::1]:80", "models.example"] {
        assert_eq!(status(host), 200, "{host}");
    }
    for host in ["evil.example", "localhost.evil.example", "10.0.0.1", "", "models.example.evil"] {
        assert_eq!(status(host), 403, "{host}");
    }
    assert_eq!(request(server.address, "GET /files/a.glb HTTP/1.1\r\n").status, 403);
    assert_eq!(
        request(server.address, "GET http://evil.example/files/a.glb HTTP/1.1\r\nHost: localhost\r\n").status,
        403
    );
    assert_eq!(
        request(server.address, "GET http://localhost/files/a.glb HTTP/1.1\r\nHost: localhost\r\n").status,
        200
    );
}

#[test]
fn bytes_that_are_no_request_get_no_answer_or_an_error() {
    let server = Running::new(ServerOptions::default());
    let long = format!("GET / HTTP/1.1\r\nHost: localhost\r\nA: {}\r\n\r\n", "a".repeat(100_000));
    let many = format!("GET / HTTP/1.1\r\nHost: localhost\r\n{}\r\n", "A: a\r\n".repeat(2000));
    let target = format!("GET /{} HTTP/1.1\r\nHost: localhost\r\n\r\n", "a".repeat(70_000));
    let requests: [&[u8]; 12] = [
        b"\0\0\0\0\0\0\0\0\r\n\r\n",
        b"GET\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: -1\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: a b\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost : localhost\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03 a hello of TLS\r\n\r\n",
        b"PRI * HTTP/2.0\r\n\r\nXX\r\n\r\n",
        long.as_bytes(),
        many.as_bytes(),
        target.as_bytes(),
    ];
    for bytes in requests {
        let mut socket = connect(server.address);
        // The server may close the connection before it has read everything.
        socket.write_all(bytes).unwrap_or_default();
        socket.shutdown(std::net::Shutdown::Write).unwrap_or_default();
        let mut answer = Vec::new();
        std::io::Read::read_to_end(&mut socket, &mut answer).unwrap_or_default();
        let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(40)]).into_owned();
        if let Some(response) = parse(&answer) {
            assert!((400..600).contains(&response.status), "{shown}: {}", response.status);
        }
    }
    assert_eq!(server.get("/healthz").status, 200);
}

#[test]
fn bodies_of_requests_are_not_waited_for() {
    let server = Running::with_files(ServerOptions::default(), &[("a.glb", b"a")]);
    let mut socket = connect(server.address);
    socket
        .write_all(b"GET /files/a.glb HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000000\r\n\r\n")
        .unwrap();
    assert_eq!(read(&mut socket).body, b"a");
}
