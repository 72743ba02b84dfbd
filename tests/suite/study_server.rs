//! `cocarry study serve` as a process of its own: slow, hostile and full of bytes.
#![cfg(all(feature = "people", unix))]

use crate::support::{COLLECTED, cocarry, new_study, stderr, stdout};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use sha2::{Digest, Sha256};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

fn sha256(text: &str) -> String {
    Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A server, which is killed at the end.
struct Server {
    child: Child,
    host: String,
    admin: String,
    token: String,
    study: String,
}

impl Server {
    fn new(file: &Path) -> Self {
        Self::of(
            Command::new(env!("CARGO_BIN_EXE_cocarry")).args(["study", "serve", "--port", "0"]).arg(file),
        )
    }

    fn of(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
        let mut after = |start: &str| {
            let line = lines.next().unwrap_or_default();
            line.strip_prefix(start).unwrap_or_else(|| panic!("{line:?}")).trim_end_matches('/').to_owned()
        };
        let host = after("the study is at http://");
        let (token, admin) = after("for you alone: http://admin:")
            .split_once('@')
            .map(|(t, a)| (t.to_owned(), a.to_owned()))
            .unwrap();
        let content = ask(&host, "GET /study.json", "", "");
        let study = content.split("\"digest\":\"").nth(1).unwrap()[..64].to_owned();
        Self { child, host, admin, token, study }
    }

    fn begin(&self, key: &str) -> String {
        let body = format!(r#"{{"key":"{}","platform_ids":[],"study":"{}"}}"#, sha256(key), self.study);
        ask(&self.host, "POST /api/session", "", &body)
    }

    fn put(&self, key: &str, number: usize, body: &str) -> String {
        let headers = format!("x-session-key: {}\r\nx-sha256: {}\r\n", sha256(key), sha256(body));
        ask(&self.host, &format!("PUT /api/chunks/0/{number}"), &headers, body)
    }

    fn chunks(&self, key: &str) -> String {
        ask(&self.host, "GET /api/session", &format!("x-session-key: {}\r\n", sha256(key)), "")
    }

    /// The largest memory so far, kB, where the system tells it.
    fn peak(&self) -> Option<u64> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        line.trim().trim_end_matches(" kB").parse().ok()
    }

    /// Ends it, and returns what it printed of requests that it refused.
    fn ended(mut self) -> String {
        assert!(
            Command::new("kill").args(["-INT", &self.child.id().to_string()]).status().unwrap().success()
        );
        let mut said = String::new();
        self.child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        assert_eq!(self.child.wait().unwrap().code(), Some(0), "{said}");
        said
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn head(host: &str, request: &str, headers: &str, length: usize) -> String {
    format!("{request} HTTP/1.1\r\nHost: {host}\r\nContent-Length: {length}\r\n{headers}\r\n")
}

/// The answer to a request.
fn ask(host: &str, request: &str, headers: &str, body: &str) -> String {
    let mut stream = TcpStream::connect(host).unwrap();
    let head = head(host, request, &format!("{headers}Connection: close\r\n"), body.len());
    // who is refused early may not be read to the end
    let _ = stream.write_all((head + body).as_bytes());
    rest(&mut stream)
}

/// What comes until the connection is closed.
fn rest(stream: &mut TcpStream) -> String {
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or(answer)
}

/// The database of a study is sound, and says how many began and finished.
fn checked(file: &Path) -> String {
    let output = cocarry(&["study", "check", file.to_str().unwrap()]);
    assert!(output.status.success(), "{}", stderr(&output));
    stdout(&output).lines().last().unwrap().split_once(": ").unwrap().1.to_owned()
}

#[test]
fn people_two_hundred_slow_clients_keep_nobody_out() {
    let (_folder, file) = new_study();
    let server = Server::new(&file);
    server.begin("a");
    // half of them never end their head, half never their body
    let start = |n: usize| {
        let mut stream = TcpStream::connect(&server.host).unwrap();
        let head = head(
            &server.host,
            "PUT /api/chunks/0/0",
            &format!("x-session-key: {}\r\n", sha256("a")),
            100_000,
        );
        stream.write_all(&head.as_bytes()[..if n.is_multiple_of(2) { 20 } else { head.len() }]).unwrap();
        stream
    };
    let slow: Vec<TcpStream> = (0..200).map(start).collect();
    let answers = std::thread::scope(|scope| {
        let drip = |mut stream: TcpStream| {
            scope.spawn(move || {
                stream.set_read_timeout(Some(Duration::from_secs(1))).unwrap();
                let mut answer = Vec::new();
                // a byte a second, until the server closes
                loop {
                    let mut part = [0; 512];
                    match stream.read(&mut part) {
                        Ok(0) => break,
                        Ok(count) => answer.extend_from_slice(&part[..count]),
                        Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {
                            let _ = stream.write_all(b" ");
                        }
                        Err(_) => break,
                    }
                }
                String::from_utf8_lossy(&answer).into_owned()
            })
        };
        let dripping: Vec<_> = slow.into_iter().map(drip).collect();
        for number in 0..100 {
            assert!(server.put("a", number, &format!("[{{\"n\":{number}}}]")).ends_with("{\"known\":false}"));
        }
        dripping.into_iter().map(|thread| thread.join().unwrap()).collect::<Vec<_>>()
    });
    let told = answers.iter().filter(|answer| answer.contains("the body took more than 20 s")).count();
    assert_eq!(told, 100, "{answers:?}");
    let said = server.ended();
    assert!(said.contains("refused: 408 slow: PUT \"/api/chunks/0/0\""), "{said}");
    // 30 lines, and how many more there were
    assert!(said.lines().count() <= 31 && said.contains("refused: 70 more"), "{said}");
    assert_eq!(checked(&file), "sound; 1 began, 0 finished");
}

#[test]
fn people_hostile_requests_are_refused_told_and_change_nothing() {
    let (_folder, file) = new_study();
    let server = Server::new(&file);
    server.begin("a");
    assert_eq!(status(&server.put("a", 0, "[]")), "200");
    let key = format!("x-session-key: {}\r\n", sha256("a"));
    for (request, headers, body, expected) in [
        ("POST /api/session", "Origin: http://evil.example\r\n", "{}", "403"),
        ("POST /api/session", "Origin: null\r\n", "{}", "403"),
        (
            "POST /api/session",
            "",
            &format!(
                r#"{{"key":"{}","platform_ids":[["<script>","x"]],"study":"{}"}}"#,
                sha256("b"),
                server.study
            ),
            "400",
        ),
        (
            "POST /api/session",
            "",
            &format!(
                r#"{{"key":"{}","platform_ids":[["PID","=cmd()"]],"study":"{}"}}"#,
                sha256("b"),
                server.study
            ),
            "400",
        ),
        ("GET /api/session", &format!("x-session-key: {}\r\n", sha256("guessed")), "", "403"),
        ("PUT /api/chunks/0/1", &format!("{key}x-sha256: {}\r\n", sha256("other")), "[]", "422"),
        ("PUT /api/chunks/0/0", &format!("{key}x-sha256: {}\r\n", sha256("[{}]")), "[{}]", "409"),
        (
            "PUT /api/chunks/0/1",
            &format!("x-session-key: {}\r\nx-sha256: {}\r\n", sha256("b"), sha256("[]")),
            "[]",
            "403",
        ),
        ("POST /api/finish", &key, &format!(r#"{{"digest":"{}"}}"#, sha256("forged")), "409"),
        ("GET /../study.toml", "", "", "404"),
        ("GET /%2e%2e/study.toml", "", "", "404"),
        ("GET /..%2fstudy.toml", "", "", "404"),
        ("GET /%252e%252e%252fstudy.toml", "", "", "404"),
        ("GET /..\\study.toml", "", "", "404"),
        ("GET /%c0%ae%c0%ae/study.toml", "", "", "404"),
        ("GET /maps/..%00/study.toml", "", "", "404"),
        ("GET //etc/passwd", "", "", "404"),
    ] {
        let answer = ask(&server.host, request, headers, body);
        // what is not a path is refused as that
        assert!(
            status(&answer) == expected || request.contains('\\') && status(&answer) == "400",
            "{request}: {answer}"
        );
    }
    let said = server.ended();
    for told in [
        "403 origin: POST \"/api/session\"",
        "403 unknown",
        "422 damaged",
        "409 other-chunk",
        "404 file: GET \"/..%2fstudy.toml\"",
    ] {
        assert!(said.contains(&format!("refused: {told}")), "{told}: {said}");
    }
    assert_eq!(checked(&file), "sound; 1 began, 0 finished");
}

#[test]
fn people_a_gigabyte_is_refused_before_it_is_held() {
    let (_folder, file) = new_study();
    let server = Server::new(&file);
    server.begin("a");
    let before = server.peak();
    let part = vec![b' '; 64 << 10];
    let send = |n: usize| {
        let mut stream = TcpStream::connect(&server.host).unwrap();
        stream.set_write_timeout(Some(Duration::from_secs(20))).unwrap();
        let is_chunked = n.is_multiple_of(2);
        let length = if is_chunked { "Transfer-Encoding: chunked" } else { "Content-Length: 1073741824" };
        let head = format!("PUT /api/chunks/0/0 HTTP/1.1\r\nHost: {}\r\n{length}\r\n\r\n", server.host);
        let mut sent = 0;
        let mut is_open = stream.write_all(head.as_bytes()).is_ok();
        while is_open && sent < 1 << 30 {
            let line = if is_chunked { format!("{:x}\r\n", part.len()) } else { String::new() };
            let end: &[u8] = if is_chunked { b"\r\n" } else { b"" };
            is_open = [line.as_bytes(), &part, end].into_iter().all(|bytes| stream.write_all(bytes).is_ok());
            sent += part.len();
        }
        sent
    };
    std::thread::scope(|scope| {
        let sent: Vec<_> = (0..40).map(|n| scope.spawn(move || send(n))).collect();
        for thread in sent {
            let sent = thread.join().unwrap();
            assert!(sent < 32 << 20, "{sent} bytes were taken");
        }
    });
    assert_eq!(status(&server.put("a", 0, "[]")), "200");
    if let (Some(before), Some(after)) = (before, server.peak()) {
        // 40 of at most 1 MiB at once, each grown by doubling
        assert!(after < before + (128 << 10), "{before} kB before, {after} kB after");
    }
    assert!(server.ended().contains("refused: 413 too-much: PUT"));
}

/// Puts chunks until the server cannot store one, makes room, and puts that one again.
fn fill(server: &Server, make_room: impl FnOnce()) {
    server.begin("a");
    let body = |number: usize| format!("[{{\"n\":{number},\"text\":\"{}\"}}]", "x".repeat(20_000));
    let full = (0..1000).find(|&number| {
        let answer = server.put("a", number, &body(number));
        match status(&answer) {
            "200" => false,
            // which the page tries again
            _ => {
                assert!(
                    answer.starts_with("HTTP/1.1 500") && answer.contains("cannot store anything just now"),
                    "{answer}"
                );
                true
            }
        }
    });
    let full = full.expect("it is full");
    assert!(full > 0);
    // what is stored is there, and the page as well
    assert_eq!(status(&ask(&server.host, "GET /", "", "")), "200");
    assert_eq!(server.chunks("a").matches("[0,").count(), full);
    make_room();
    for number in 0..full + 3 {
        let known = number < full;
        assert!(
            server.put("a", number, &body(number)).ends_with(&format!("{{\"known\":{known}}}")),
            "{number}"
        );
    }
    assert_eq!(server.chunks("a").matches("[0,").count(), full + 3);
}

#[test]
fn people_where_files_may_not_grow_nothing_acknowledged_is_lost() {
    let (_folder, file) = new_study();
    // a process that writes past the limit would be killed, if it did not ignore the signal
    let script = "trap '' XFSZ; exec \"$0\" study serve --port 0 \"$1\"";
    let server = Server::of(
        Command::new("prlimit")
            .args(["--fsize=1000000:unlimited", "sh", "-c", script, env!("CARGO_BIN_EXE_cocarry")])
            .arg(&file),
    );
    fill(&server, || {
        let process = server.child.id().to_string();
        let done = Command::new("prlimit").args(["--pid", &process, "--fsize=unlimited:unlimited"]).status();
        assert!(done.unwrap().success());
    });
    let said = server.ended();
    assert!(said.contains("study.sqlite: cannot be read or written"), "{said}");
    assert_eq!(checked(&file), "sound; 1 began, 0 finished");
}

#[test]
fn people_a_full_disk_loses_nothing_acknowledged() {
    let (folder, file) = new_study();
    let unshare = ["--user", "--map-root-user", "--mount"];
    if !Command::new("unshare").args(unshare).arg("true").status().is_ok_and(|status| status.success()) {
        println!("skipped: a disk of 1 MB; this system lets nobody mount one");
        return;
    }
    let disk = folder.path().join("disk");
    std::fs::create_dir(&disk).unwrap();
    let script = "mount -t tmpfs -o size=1m none \"$2\" && cp \"$1\" \"$2\" && exec \"$0\" study serve --port 0 \"$2/study.toml\"";
    let server = Server::of(
        Command::new("unshare")
            .args(unshare)
            .args(["sh", "-c", script, env!("CARGO_BIN_EXE_cocarry")])
            .args([&file, &disk]),
    );
    // the disk as the server sees it
    let seen = PathBuf::from(format!("/proc/{}/root{}", server.child.id(), disk.display()));
    // as other files would: they go
    let ballast = seen.join("ballast");
    std::fs::write(&ballast, vec![0; 300_000]).unwrap();
    fill(&server, || std::fs::remove_file(&ballast).unwrap());
    // it ends with the server
    for name in ["study.sqlite", "study.sqlite-wal"] {
        std::fs::copy(seen.join(name), folder.path().join(name)).unwrap();
    }
    let said = server.ended();
    assert!(said.contains("disk is full"), "{said}");
    assert_eq!(checked(&file), "sound; 1 began, 0 finished");
}

#[test]
fn people_the_administrator_gets_the_tables_that_collect_writes() {
    let (folder, file) = new_study();
    let server = Server::new(&file);
    server.begin("a");
    let answer = r#"[{"kind":"done","data":{"task":"scale","name":"=cmd()","answers":[["<script>",3]]}}]"#;
    server.put("a", 0, answer);
    let whole = sha256(&format!("0 0 {}\n", sha256(answer)));
    let finish = format!("{{\"digest\":\"{whole}\"}}");
    assert_eq!(
        status(&ask(
            &server.host,
            "POST /api/finish",
            &format!("x-session-key: {}\r\n", sha256("a")),
            &finish
        )),
        "200"
    );
    server.begin("b");
    let get = |path: &str, token: &str| {
        let given = BASE64_STANDARD.encode(format!("admin:{token}"));
        let answer =
            ask(&server.admin, &format!("GET {path}"), &format!("Authorization: Basic {given}\r\n"), "");
        answer.split_once("\r\n\r\n").unwrap().1.to_owned()
    };
    let page = get("/", &server.token);
    assert!(page.contains("<dd>2 of 20</dd>") && !page.contains("<script"), "{page}");
    for (with_unfinished, link) in [(false, "/tables/"), (true, "/tables/with-unfinished/")] {
        let to = folder.path().join(format!("answers-{with_unfinished}"));
        let mut words = vec!["study", "collect", file.to_str().unwrap(), "-o", to.to_str().unwrap()];
        words.extend(with_unfinished.then_some("--with-unfinished"));
        assert!(cocarry(&words).status.success());
        for name in COLLECTED {
            let written = std::fs::read_to_string(to.join(name)).unwrap();
            assert!(page.contains(&format!("href=\"{link}{name}\"")), "{link}{name}");
            assert_eq!(get(&format!("{link}{name}"), &server.token), written, "{name}");
        }
    }
    assert!(get("/", "guessed").contains("the token that"));
    let said = server.ended();
    assert!(said.contains("refused: 401 token: GET \"/\""), "{said}");
}

#[test]
fn people_the_page_for_the_ethics_board_is_of_the_study_file_alone() {
    let (folder, file) = new_study();
    let written = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, written.replace("Replace this text", "Replace <script>this</script> text"))
        .unwrap();
    let ethics = |words: &[&str]| cocarry(&[&["study", "ethics", file.to_str().unwrap()], words].concat());
    assert!(ethics(&[]).status.success());
    let page = std::fs::read_to_string(folder.path().join("study.ethics.html")).unwrap();
    for said in [
        "In this study you look at maps, and at a robot that carries a long object together with a person.",
        "Replace &lt;script&gt;this&lt;/script&gt; text with the one that your ethics board has approved.",
        "The robot led me well.",
        "PROLIFIC_PID, STUDY_ID, SESSION_ID",
        "network addresses",
        "cocarry study forget study.toml NUMBER",
        "longer-and-riskier-over-20",
        "at most 32 MiB",
        "a mouse is not a beam in the hands",
        "data:image/svg+xml;base64,",
    ] {
        assert!(page.contains(said), "{said}");
    }
    assert!(!page.contains("<script") && !page.contains(folder.path().to_str().unwrap()));
    // not replaced unasked; elsewhere it is the same, and answers do not change it
    assert_eq!(ethics(&[]).status.code(), Some(2));
    assert!(cocarry(&["study", "simulate", file.to_str().unwrap(), "--participants", "1"]).status.success());
    let other = folder.path().join("other.html");
    assert!(ethics(&["-o", other.to_str().unwrap()]).status.success());
    assert_eq!(std::fs::read_to_string(&other).unwrap(), page);
    let output = ethics(&["-o", "ethics.pdf"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("ethics.pdf: the page is HTML"), "{}", stderr(&output));
}
