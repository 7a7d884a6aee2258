//! `tristrip serve`, `view`: the server as a process, from its first line to its exit code.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use predicates::str::contains;
use serde_json::Value;

use super::{keys, model, tristrip};

/// A process of the command that runs until it gets a signal.
struct Server {
    child: Child,
    report: Value,
}

impl Server {
    /// Starts the command with `--json`, and waits for its report.
    fn start(arguments: &[&str]) -> Self {
        Self::start_with_browser(arguments, None)
    }

    /// Does the same, with a program as the user's browser.
    fn start_with_browser(arguments: &[&str], browser: Option<&Path>) -> Self {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("tristrip"));
        browser.iter().for_each(|browser| {
            command.env("BROWSER", browser);
        });
        command.args(arguments).arg("--json").stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut lines = String::new();
        let mut stdout = BufReader::new(child.stdout.as_mut().unwrap());
        // The report ends with the first line that is a bracket alone.
        while !matches!(lines.lines().last(), Some("}" | "]")) {
            assert!(stdout.read_line(&mut lines).unwrap() > 0, "no report: {lines}");
        }
        Self { child, report: serde_json::from_str(&lines).unwrap() }
    }

    fn address(&self) -> &str {
        let url = self.report["url"].as_str().or(self.report[0]["url"].as_str()).unwrap();
        url.strip_prefix("http://").unwrap().split('/').next().unwrap()
    }

    /// Sends a request.
    fn request(&self, path: &str) -> TcpStream {
        let mut socket = TcpStream::connect(self.address()).unwrap();
        write!(socket, "GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").unwrap();
        socket
    }

    /// Returns the status and the body of a response.
    fn get(&self, path: &str) -> (String, Vec<u8>) {
        let mut socket = self.request(path);
        let mut answer = Vec::new();
        socket.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|window| window == b"\r\n\r\n").unwrap() + 4;
        let body = answer.split_off(end);
        (String::from_utf8(answer[9..12].to_vec()).unwrap(), body)
    }

    /// Sends a signal.
    #[cfg(unix)]
    fn signal(&self, signal: &str) {
        let killed =
            Command::new("kill").args([&format!("-{signal}"), &self.child.id().to_string()]).status();
        assert!(killed.unwrap().success());
    }

    /// Ends the process by a signal, and returns its exit code and standard error.
    #[cfg(unix)]
    fn end(mut self, signal: &str) -> (Option<i32>, String) {
        self.signal(signal);
        let mut text = String::new();
        self.child.stderr.take().unwrap().read_to_string(&mut text).unwrap();
        (self.child.wait().unwrap().code(), text)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.child.kill().unwrap_or_default();
        self.child.wait().map(|_| ()).unwrap_or_default();
    }
}

/// Returns a folder with a model, and the flags of a server that keeps its cache there.
fn folder() -> (tempfile::TempDir, [String; 5]) {
    let dir = tempfile::tempdir().unwrap();
    fs::copy(model("fish_control.ply"), dir.path().join("fish.ply")).unwrap();
    let path = dir.path().to_str().unwrap().to_owned();
    let cache = format!("{path}/.cache");
    (dir, ["serve".into(), path, "--port=0".into(), "--cache".into(), cache])
}

#[test]
fn a_folder_is_served_and_packed() {
    let (dir, flags) = folder();
    let mut flags: Vec<&str> = flags.iter().map(String::as_str).collect();
    flags.push("--pack-on-demand");
    let server = Server::start(&flags);
    assert_eq!(keys(&server.report), ["file", "url", "address", "port", "pack_on_demand", "notes", "error"]);
    let packed = dir.path().join("packed.glb");
    tristrip().args(["pack", "-q"]).arg(model("fish_control.ply")).arg("-o").arg(&packed).assert().success();
    assert!(server.get("/packed/fish.ply.glb") == ("200".into(), fs::read(&packed).unwrap()));
    let list: Value = serde_json::from_slice(&server.get("/models.json").1).unwrap();
    assert_eq!(list["models"][0]["kind"], "packed");
    let described =
        fs::read_to_string(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/reports.md")).unwrap();
    let of_model = keys(&list["models"][0]).into_iter().map(|key| format!("models[].{key}"));
    let of_objects = [keys(&server.report), keys(&list)].concat().into_iter().map(str::to_owned);
    for key in of_objects.chain(of_model) {
        assert!(described.contains(&format!("\n| `{key}` |")), "docs/reports.md does not describe `{key}`");
    }
    #[cfg(unix)]
    {
        let (code, log) = server.end("TERM");
        assert_eq!(code, Some(0));
        assert!(
            log.starts_with("http://127.0.0.1:") && log.contains("path=\"/models.json\" status=200"),
            "{log}"
        );
    }
}

#[cfg(unix)]
#[test]
fn the_log_is_json_or_quiet() {
    let (_dir, flags) = folder();
    let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
    let server = Server::start(&[&flags[..], &["--log", "json"]].concat());
    assert_eq!(server.get("/packed/fish.ply.glb").0, "404");
    let (code, log) = server.end("INT");
    let line: Value = log.lines().find_map(|line| serde_json::from_str(line).ok()).unwrap();
    assert_eq!(
        (code, &line["status"], &line["path"]),
        (Some(0), &404.into(), &"/packed/fish.ply.glb".into())
    );
    let server = Server::start(&[&flags[..], &["--quiet"]].concat());
    assert_eq!(server.get("/files/fish.ply").0, "200");
    assert_eq!(server.end("INT"), (Some(0), String::new()));
}

#[cfg(unix)]
#[test]
fn lines_of_the_log_control_no_terminal() {
    let (_dir, flags) = folder();
    let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
    for format in ["text", "json"] {
        let server = Server::start(&[&flags[..], &["--log", format]].concat());
        // A control sequence introducer in 8 bits, and letters from right to left.
        assert_eq!(server.get("/files/\u{9b}31m\u{202e}ylp.ply").0, "400");
        assert_eq!(server.get("/files/\u{202e}ylp.ply").0, "404");
        // Raw control characters are no request.
        assert_eq!(server.get("/files/\u{1b}[31m.ply").0, "400");
        let (code, log) = server.end("INT");
        assert_eq!(code, Some(0));
        assert!(
            log.contains("/files/%C2%9B31m%E2%80%AEylp.ply") && log.contains("/files/%E2%80%AEylp.ply"),
            "{log:?}"
        );
        let is_harmless = |c: char| c == '\n' || !c.is_control() && c != '\u{202e}';
        assert!(log.chars().all(is_harmless), "{log:?}");
    }
}

#[cfg(unix)]
#[test]
fn the_first_signal_waits_for_responses_and_the_second_does_not() {
    let (dir, flags) = folder();
    let bytes: Vec<u8> = (0..=250).cycle().take(200_000).collect();
    fs::write(dir.path().join("large.glb"), &bytes).unwrap();
    let start = |rate: &str| {
        let mut flags: Vec<&str> = flags.iter().map(String::as_str).collect();
        flags.extend(["--grace-time", "10m", "--bandwidth", rate]);
        let server = Server::start(&flags);
        let mut socket = server.request("/files/large.glb");
        socket.read_exact(&mut [0; 20]).unwrap();
        server.signal("INT");
        (server, socket)
    };
    // Two seconds.
    let (server, mut socket) = start("800k");
    let mut rest = Vec::new();
    socket.read_to_end(&mut rest).unwrap();
    assert!(rest.ends_with(&bytes));
    assert_eq!(ended(server), Some(0));
    // Half an hour.
    let (mut server, _socket) = start("1k");
    std::thread::sleep(Duration::from_millis(500));
    assert!(server.child.try_wait().unwrap().is_none(), "it waits for the response");
    assert!(TcpStream::connect(server.address()).is_err(), "it accepts nothing more");
    server.signal("INT");
    assert_eq!(ended(server), Some(0));
}

/// Waits for the end of a process, and returns its exit code; none if it still runs after a minute.
#[cfg(unix)]
fn ended(mut server: Server) -> Option<i32> {
    let start = Instant::now();
    while start.elapsed() < Duration::from_mins(1) {
        if let Some(status) = server.child.try_wait().unwrap() {
            return status.code();
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    None
}

#[cfg(unix)]
#[test]
fn a_browser_in_the_terminal_is_answered_while_it_runs() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    // A name of a browser that is waited for. It runs until its folder is removed.
    let (browser, opened) = (dir.path().join("lynx"), dir.path().join("opened"));
    let script = format!(
        "#!/bin/sh\necho \"$1\" > {0}.new\nmv {0}.new {0}\nwhile [ -e {0} ]; do sleep 0.1; done\n",
        opened.display()
    );
    fs::write(&browser, script).unwrap();
    fs::set_permissions(&browser, fs::Permissions::from_mode(0o755)).unwrap();
    let fish = model("fish_control.ply");
    let server = Server::start_with_browser(&["view", fish.to_str().unwrap()], Some(&browser));
    let start = Instant::now();
    while !opened.exists() {
        assert!(start.elapsed() < Duration::from_mins(1), "no browser was opened");
        std::thread::sleep(Duration::from_millis(10));
    }
    let url = fs::read_to_string(&opened).unwrap();
    assert_eq!(Some(url.trim_end()), server.report["url"].as_str());
    assert_eq!(server.get("/").0, "200");
    assert_eq!(server.get("/files/fish_control.ply.glb").0, "200");
    server.signal("INT");
    assert_eq!(ended(server), Some(0), "the browser still runs");
}

#[test]
fn models_are_viewed_from_memory() {
    let fish = model("fish_control.ply");
    let server = Server::start(&["view", "--no-open", fish.to_str().unwrap()]);
    assert_eq!(keys(&server.report), ["file", "proven", "url", "bytes", "notes", "error"]);
    let url = server.report["url"].as_str().unwrap();
    assert!(url.ends_with("/#model=files/fish_control.ply.glb"), "{url}");
    let (status, bytes) = server.get("/files/fish_control.ply.glb");
    assert_eq!((status.as_str(), bytes.len() as u64), ("200", server.report["bytes"].as_u64().unwrap()));
    drop(server);
    // A progressive GLB is served as it is, and two files of one name have two URLs.
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.glb");
    fs::write(&path, &bytes).unwrap();
    let path = path.to_str().unwrap();
    let server = Server::start(&["view", "--no-open", path, path]);
    assert!(server.get("/files/a.glb") == ("200".into(), bytes.clone()));
    assert!(server.get("/files/2-a.glb") == ("200".into(), bytes.clone()));
    assert_eq!(server.get("/").0, "200");
    drop(server);
    // So is a truncated one.
    let start = bytes.len() - 100;
    fs::write(path, &bytes[..start]).unwrap();
    let server = Server::start(&["view", "--no-open", path]);
    assert!(server.report["notes"][0].as_str().unwrap().starts_with("the file is truncated: it contains "));
    assert!(server.get("/files/a.glb") == ("200".into(), bytes[..start].to_vec()));
}

#[test]
fn bad_folders_ports_and_flags_are_refused() {
    let (dir, flags) = folder();
    let serve = |more: &[&str]| tristrip().args(&flags).args(more).assert();
    let none = dir.path().join("none");
    tristrip().arg("serve").arg(&none).assert().code(1).stderr(contains("no such file or directory"));
    tristrip().args(["view", "--no-open"]).arg(&none).assert().code(1);
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let [_, path, _, cache, folder] = &flags;
    let command = tristrip().args(["serve", path, cache, folder, "--port", &port]).assert();
    command.code(1).stderr(contains(format!("127.0.0.1:{port}: ")));
    serve(&["--tls-certificate", "a.pem"]).code(2);
    serve(&["--tls-certificate", "none.pem", "--tls-key", "none.pem"]).code(1).stderr(contains("none.pem"));
    serve(&["--cors", "example.org"]).code(1).stderr(contains("cors: found example.org"));
    serve(&["--bandwidth", "5"]).code(2);
    serve(&["--header-bytes", "1"])
        .code(2)
        .stderr(contains("--header-bytes: found 1 byte, expected 8K to 16M"));
    serve(&["--wait-time", "0s"]).code(2).stderr(contains("--wait-time: found 0 seconds, expected more"));
    serve(&["--stall-time", "0s"]).code(2).stderr(contains("--stall-time"));
    serve(&["--packings", "0"]).code(2);
    tristrip().arg("serve").assert().code(2);
}
