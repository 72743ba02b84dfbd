//! `cocarry demo` as a user runs it, and `cocarry replay` of a log from its page.

use crate::support::{cocarry, json, stderr, stdout};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// A folder with a page.
fn page() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("index.html"), "<!doctype html><title>page</title>").unwrap();
    std::fs::write(folder.path().join("cocarry.wasm"), b"\0asm").unwrap();
    folder
}

/// The running program, and the port that it prints. Without a folder it serves the page within.
fn serving(program: &mut Command, folder: Option<&Path>) -> (Child, u16) {
    let page = folder.into_iter().flat_map(|folder| ["--page".as_ref(), folder.as_os_str()]);
    let mut child = program
        .args(["demo", "--no-browser", "--port", "0"])
        .args(page)
        .stdout(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let port =
        line.trim().strip_prefix("the page is at http://127.0.0.1:").and_then(|rest| rest.strip_suffix('/'));
    let port = port.and_then(|port| port.parse().ok()).unwrap_or_else(|| panic!("{line:?}"));
    (child, port)
}

fn get(port: u16, path: &str) -> Vec<u8> {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    answer
}

#[cfg(unix)]
#[test]
fn demo_serves_a_page_until_ctrl_c() {
    let folder = page();
    let program = &mut Command::new(env!("CARGO_BIN_EXE_cocarry"));
    let (mut child, port) = serving(program, Some(folder.path()));
    let get = |path: &str| String::from_utf8_lossy(&get(port, path)).into_owned();
    let answer = get("/");
    assert!(answer.starts_with("HTTP/1.1 200") && answer.ends_with("<title>page</title>"), "{answer}");
    assert!(get("/cocarry.wasm").contains("Content-Type: application/wasm\r\n"));
    assert!(get("/../../etc/passwd").starts_with("HTTP/1.1 404"));
    // a second one at the same port is told
    let taken = cocarry(&[
        "demo",
        "--no-browser",
        "--port",
        &port.to_string(),
        "--page",
        folder.path().to_str().unwrap(),
    ]);
    assert_eq!(taken.status.code(), Some(2));
    let said = stderr(&taken);
    assert!(said.contains(&format!("--port {port}")) && said.lines().count() <= 3, "{said}");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[test]
fn demo_without_a_page_says_how_to_get_one() {
    let folder = tempfile::tempdir().unwrap();
    let output = cocarry(&["demo", "--no-browser", "--page", folder.path().to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("has no index.html"), "{}", stderr(&output));
    #[cfg(not(feature = "page"))]
    {
        let output = Command::new(env!("CARGO_BIN_EXE_cocarry"))
            .args(["demo", "--no-browser"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains("crates/web/build"), "{}", stderr(&output));
    }
}

/// A program that was built with the page has every file of it within.
#[cfg(feature = "page")]
#[test]
fn demo_serves_the_page_within() {
    let elsewhere = tempfile::tempdir().unwrap();
    let (mut child, port) =
        serving(Command::new(env!("CARGO_BIN_EXE_cocarry")).current_dir(elsewhere.path()), None);
    let built = crate::support::repository("viewer/dist/page");
    let mut count = 0;
    for file in std::fs::read_dir(built).unwrap() {
        let file = file.unwrap();
        let answer = get(port, &format!("/{}", file.file_name().to_str().unwrap()));
        let end = answer.windows(4).position(|end| end == b"\r\n\r\n").unwrap() + 4;
        assert!(answer.starts_with(b"HTTP/1.1 200"), "{file:?}");
        assert!(answer[end..] == std::fs::read(file.path()).unwrap(), "{file:?}");
        count += 1;
    }
    assert!(count >= 4, "{count} files");
    child.kill().unwrap();
    child.wait().unwrap();
}

/// A log of the first 30 steps of the default episode on the planning level, with one decision of the human.
fn log(digests: serde_json::Value) -> serde_json::Value {
    use cocarry::human::HumanDecision;
    use cocarry::scenario::{Plant, Scenario};
    let world =
        cocarry::world::World::load(&crate::support::repository("worlds/environment-4.toml")).unwrap();
    let scenario = Scenario::new(world.into(), Plant::Point).text().unwrap();
    let human: Vec<HumanDecision> = (0..30).map(|_| HumanDecision::following(1)).collect();
    serde_json::json!({
        "version": 1, "scenario": scenario, "decisions": { "human": human, "has_changes": true }, "digests": digests, "steps": 30,
        "outcome": null,
    })
}

#[test]
fn replay_of_a_log_compares_digests_and_records() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let write = |log: &serde_json::Value| std::fs::write(file("carry.json"), log.to_string()).unwrap();
    write(&log(serde_json::json!([[10, "0000000000000000"]])));
    let output = cocarry(&["replay", &file("carry.json")]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let said = stdout(&output);
    let (_, digest) = said.split_once("run again ").unwrap_or_else(|| panic!("{said}"));
    write(&log(serde_json::json!([[10, digest[..16]]])));
    let output = cocarry(&["replay", &file("carry.json"), "--record", &file("carry.mcap")]);
    assert_eq!(output.status.code(), Some(0), "{}{}", stdout(&output), stderr(&output));
    assert!(stdout(&output).contains("identical: 1 digest, up to 6.0 s"), "{}", stdout(&output));
    // the recording has the decisions, and replays by itself
    let output = cocarry(&["replay", &file("carry.mcap")]);
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
    assert_eq!(json(&["inspect", &file("carry.mcap"), "--json"])["outcome"]["outcome"], "interrupted");
    // whoever opens its page can take over again, after the decisions so far
    let output = cocarry(&["render", &file("carry.mcap"), "-o", &file("carry.html")]);
    assert!(output.status.success(), "{}", stderr(&output));
    let page = std::fs::read_to_string(file("carry.html")).unwrap();
    let (_, log) = page.split_once("\"take_over\":").unwrap();
    assert!(log.contains("\"has_changes\":true") && log.contains("\"steps\":30,"), "{}", &log[..400]);
}

#[test]
fn replay_refuses_what_is_no_log() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("carry.json");
    let good = log(serde_json::json!([]));
    let with = |key: &str, value: serde_json::Value| {
        let mut log = good.clone();
        log[key] = value;
        log.to_string()
    };
    for (text, words) in [
        ("{".to_owned(), "not a log of an episode"),
        (with("version", 2.into()), "version = 2; it must be 1"),
        (with("steps", u64::MAX.into()), "steps = 18446744073709552000; it must be at most 1000000"),
        (with("scenario", "seed = 1".into()), "scenario: not valid"),
        (with("more", 1.into()), "unknown field `more`"),
        (with("digests", serde_json::json!([[1, "a".repeat(1000)]])), "has 1000 bytes, at most 64 expected"),
        (with("outcome", "a".repeat(1000).into()), "has 1000 bytes, at most 64 expected"),
    ] {
        std::fs::write(&path, text).unwrap();
        let output = cocarry(&["replay", path.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2), "{words}");
        assert!(stderr(&output).contains(words), "{words}: {}", stderr(&output));
    }
}
