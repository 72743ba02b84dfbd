//! Tests of the server, over its connections.

use super::*;
use crate::digest::sha256;
use crate::site::Sink;
use crate::store::MAX_CHUNK_BYTES;
use crate::study::{PeopleStudy, TEMPLATE};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

const TOKEN: &str = "0123456789abcdef";

/// A server of the template's study, and a folder with its store.
struct Running {
    folder: tempfile::TempDir,
    address: SocketAddr,
    admin: SocketAddr,
    study: String,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Running {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("study.toml");
        std::fs::write(&file, TEMPLATE).unwrap();
        let mut study = PeopleStudy::read(&file).unwrap();
        (study.participants, study.end.code) = (2, Some("DONE".to_owned()));
        let site = Site::new(&study, Sink::Server, None).unwrap();
        let store = Store::open(&study.database()).unwrap();
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let address = listener.local_addr().unwrap();
        let (digest, hosts) = (site.digest.clone(), vec![address.to_string()]);
        let admin = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let admin_address = admin.local_addr().unwrap();
        let admin = Some(Admin { listener: admin, token: TOKEN.to_owned() });
        let serving = Serving { study, site, store, hosts, admin };
        let is_over = Arc::new(AtomicBool::new(false));
        let flag = is_over.clone();
        let thread =
            std::thread::spawn(move || serve(listener, serving, || flag.load(Ordering::SeqCst)).unwrap());
        Self { folder, address, admin: admin_address, study: digest, is_over, thread: Some(thread) }
    }

    /// The answer to a request whose head lines and body are given, HOST standing for the server's.
    fn ask(&self, head: &str, body: &str) -> String {
        asked(self.address, head, body)
    }

    /// The answer of the administrator's page, to one who has this token.
    fn ask_admin(&self, path: &str, token: &str) -> String {
        let given = BASE64_STANDARD.encode(format!("admin:{token}"));
        let head = format!("GET {path} HTTP/1.1\r\nHost: HOST\r\nAuthorization: Basic {given}");
        asked(self.admin, &head, "")
    }

    fn begin(&self, key: &str) -> String {
        let body = json!({ "key": key, "platform_ids": [], "study": self.study }).to_string();
        self.ask("POST /api/session HTTP/1.1\r\nHost: HOST\r\nOrigin: http://HOST", &body)
    }

    fn put(&self, key: &str, place: &str, body: &str) -> String {
        let sha256 = sha256(body.as_bytes());
        let head = format!(
            "PUT /api/chunks/{place} HTTP/1.1\r\nHost: HOST\r\nx-session-key: {key}\r\nx-sha256: {sha256}"
        );
        self.ask(&head, body)
    }
}

fn asked(address: SocketAddr, head: &str, body: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    let head = head.replace("HOST", &address.to_string());
    let length = body.len();
    // a body that is refused may not be read to its end
    let _ = write!(stream, "{head}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{body}");
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

impl Drop for Running {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::SeqCst);
        let _ = self.thread.take().unwrap().join();
    }
}

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or(answer)
}

#[test]
fn a_session_goes_from_its_beginning_to_its_code() {
    let server = Running::new();
    let key = sha256(b"a key");
    let begun = server.begin(&key);
    assert!(begun.starts_with("HTTP/1.1 200") && begun.contains(r#""place":0"#), "{begun}");
    assert_eq!(server.begin(&key).lines().last(), begun.lines().last());
    let body = r#"[{"kind":"done"}]"#;
    assert!(server.put(&key, "0/0", body).ends_with(r#"{"known":false}"#));
    assert!(server.put(&key, "0/0", body).ends_with(r#"{"known":true}"#));
    let other = server.put(&key, "0/0", "[]");
    assert!(status(&other) == "409" && other.contains("other-chunk"), "{other}");
    let finish = |digest: &str| {
        let head = format!("POST /api/finish HTTP/1.1\r\nHost: HOST\r\nx-session-key: {key}");
        server.ask(&head, &json!({ "digest": digest }).to_string())
    };
    assert!(finish(&sha256(b"")).contains("not-whole"));
    let whole = sha256(format!("0 0 {}\n", sha256(body.as_bytes())).as_bytes());
    assert!(finish(&whole).ends_with(r#"{"code":"DONE"}"#));
    assert!(server.put(&key, "1/0", "[]").contains("finished"));
    let listed = server.ask(&format!("GET /api/session HTTP/1.1\r\nHost: HOST\r\nx-session-key: {key}"), "");
    assert!(listed.contains(&format!(r#"[0,0,"{}"]"#, sha256(body.as_bytes()))), "{listed}");
    // the second participant is the last one
    assert_eq!(status(&server.begin(&sha256(b"b"))), "200");
    assert!(server.begin(&sha256(b"c")).contains("full"));
}

#[test]
fn nothing_that_is_secret_and_nothing_else_has_an_address() {
    let server = Running::new();
    let get = |path: &str| server.ask(&format!("GET {path} HTTP/1.1\r\nHost: HOST"), "");
    let page = get("/");
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("study.js"), "{page}");
    assert!(page.contains("frame-ancestors 'none'") && page.contains("nosniff"), "{page}");
    assert!(get("/study.js").contains("text/javascript") && get("/maps/1.svg").contains("<svg"));
    let study = get("/study.json");
    assert!(study.contains(&server.study) && !study.contains("DONE") && !study.contains("risk"));
    for path in [
        "/study.sqlite",
        "/study.toml",
        "/../study.toml",
        "/%2e%2e/study.toml",
        "//",
        "/maps",
        "/maps/9.svg",
        "/api",
    ] {
        assert_eq!(status(&get(path)), "404", "{path}");
    }
    assert!(server.folder.path().join("study.sqlite").is_file());
}

#[test]
fn hostile_requests_are_refused_and_change_nothing() {
    let server = Running::new();
    let key = sha256(b"a key");
    server.begin(&key);
    let body = json!({ "key": sha256(b"x"), "platform_ids": [], "study": server.study }).to_string();
    for (head, expected) in [
        ("POST /api/session HTTP/1.1\r\nHost: HOST\r\nOrigin: http://evil.example", "403"),
        ("POST /api/session HTTP/1.1\r\nHost: HOST\r\nOrigin: null", "403"),
        ("POST /api/session HTTP/1.1\r\nHost: evil.example", "403"),
        ("POST /api/session HTTP/1.0", "403"),
        ("POST /study.json HTTP/1.1\r\nHost: HOST", "405"),
        ("DELETE /api/session HTTP/1.1\r\nHost: HOST", "405"),
    ] {
        let answer = server.ask(head, &body);
        assert_eq!(status(&answer), expected, "{head}: {answer}");
    }
    assert_eq!(status(&server.ask("POST /api/session HTTP/1.1\r\nHost: HOST", "{")), "400");
    assert!(server.begin("<script>").contains("hexadecimal"));
    assert_eq!(status(&server.put(&sha256(b"guessed"), "0/0", "[]")), "403");
    assert_eq!(status(&server.put("", "0/0", "[]")), "403");
    for place in ["-1/0", "0/x", "99999999999/0", "0/0/0"] {
        assert!(["400", "405"].contains(&status(&server.put(&key, place, "[]"))), "{place}");
    }
    let long = server.put(&key, "0/0", &format!("[{}]", " ".repeat(MAX_CHUNK_BYTES)));
    // who is still sending may not hear the answer
    assert!(["413", ""].contains(&status(&long)), "{long}");
    assert_eq!(server.put(&key, "0/0", "[]").lines().last(), Some(r#"{"known":false}"#));
}

#[test]
fn many_beginnings_at_once_are_bounded() {
    let server = Running::new();
    let key = sha256(b"a key");
    let refused =
        (0..=MAX_BEGINS).map(|_| server.begin(&key)).filter(|answer| status(answer) == "429").count();
    assert_eq!(refused, 1);
}

#[test]
fn the_administrators_page_is_for_the_token_alone() {
    let server = Running::new();
    server.begin(&sha256(b"a key"));
    let page = server.ask_admin("/", TOKEN);
    assert!(status(&page) == "200" && page.contains("<dd>1 of 2</dd>"), "{page}");
    assert!(page.contains("content-security-policy: default-src 'none'; style-src 'self'"), "{page}");
    let table = server.ask_admin("/tables/with-unfinished/participants.csv", TOKEN);
    assert!(
        table.contains("text/csv") && table.contains("attachment") && table.contains("participant,number,")
    );
    for path in ["/tables/study.sqlite", "/tables/..%2fstudy.toml", "/study.toml", "/tables/", "/api/session"]
    {
        assert_eq!(status(&server.ask_admin(path, TOKEN)), "404", "{path}");
    }
    let get = |head: &str| asked(server.admin, &format!("GET / HTTP/1.1\r\n{head}"), "");
    // it is not asked for the token by another name, by a page of others, or in its address
    let given = BASE64_STANDARD.encode(format!("admin:{TOKEN}"));
    let with_token = format!("Host: HOST\r\nAuthorization: Basic {given}");
    assert_eq!(status(&get(&with_token)), "200");
    for foreign in ["Origin: http://evil.example", "Sec-Fetch-Site: cross-site", "Sec-Fetch-Site: same-site"]
    {
        assert_eq!(status(&get(&format!("{with_token}\r\n{foreign}"))), "403", "{foreign}");
    }
    assert_eq!(status(&get(&with_token.replace("HOST", "evil.example"))), "403");
    assert_eq!(
        status(&asked(server.admin, &format!("GET /?token={TOKEN} HTTP/1.1\r\nHost: HOST"), "")),
        "401"
    );
    // the participants' port has none of it
    assert_eq!(
        status(&server.ask(&format!("GET /tables/participants.csv HTTP/1.1\r\n{with_token}"), "")),
        "404"
    );
    assert_eq!(status(&server.ask(&format!("POST / HTTP/1.1\r\n{with_token}"), "")), "405");
}

#[test]
fn guesses_of_the_token_are_bounded() {
    let server = Running::new();
    let guess = |token: &str| status(&server.ask_admin("/", token)).to_owned();
    // who has no token is asked for it, and guesses nothing
    for _ in 0..20 {
        assert_eq!(status(&asked(server.admin, "GET / HTTP/1.1\r\nHost: HOST", "")), "401");
    }
    for wrong in ["", "0123456789abcde", "0123456789abcdeg", "0123456789ABCDEF", "0123456789abcdef0"] {
        assert_eq!([guess(wrong), guess(wrong)], ["401", "401"], "{wrong}");
    }
    assert_eq!(guess("another"), "429");
    // nor is a right one told from a wrong one
    assert_eq!(guess(TOKEN), "429");
    // participants do not notice
    assert_eq!(status(&server.begin(&sha256(b"a key"))), "200");
}
