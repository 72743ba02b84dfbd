//! Load on a server of a study: sessions that all put a chunk a second.
//!
//! ```text
//! cargo run -p cocarry-people --example load -- PROGRAM [SESSIONS [SECONDS]]
//! ```
//!
//! PROGRAM is a `cocarry` with the feature `people`. It prints how long the answers to chunks took, how many
//! requests were refused, the largest memory of the server (Linux), and, after the server was killed, how
//! many acknowledged chunks its database lost. The exit code is 1 if one was lost or refused.

use rusqlite::Connection;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::collections::HashSet;
use std::error::Error;
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::{Arc, Barrier};
use std::time::{Duration, Instant};

type Failure = Box<dyn Error + Send + Sync>;

/// Keys of a second of typing, as the page records it: the length of a usual chunk.
const RECORDS: u32 = 24;
/// Whoever waits longer than the page for an answer asks again.
const PATIENCE: Duration = Duration::from_secs(20);

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// A connection that is opened anew where it ended.
struct Client {
    host: String,
    stream: Option<BufReader<TcpStream>>,
}

impl Client {
    /// Status and body of the answer to a request.
    fn ask(&mut self, method: &str, path: &str, headers: &str, body: &str) -> Result<(u16, String), Failure> {
        let stream = match &mut self.stream {
            Some(stream) => stream,
            none => {
                let stream = TcpStream::connect(&self.host)?;
                stream.set_nodelay(true)?;
                stream.set_read_timeout(Some(PATIENCE))?;
                none.insert(BufReader::new(stream))
            }
        };
        let asked = format!(
            "{method} {path} HTTP/1.1\r\nHost: {}\r\nContent-Length: {}\r\n{headers}\r\n{body}",
            self.host,
            body.len()
        );
        let answered =
            stream.get_mut().write_all(asked.as_bytes()).map_err(Failure::from).and_then(|()| answer(stream));
        if answered.is_err() {
            self.stream = None;
        }
        answered
    }
}

fn answer(stream: &mut BufReader<TcpStream>) -> Result<(u16, String), Failure> {
    let (mut status, mut length, mut line) = (0, 0, String::new());
    loop {
        line.clear();
        if stream.read_line(&mut line)? == 0 {
            return Err("the connection ended".into());
        }
        let line = line.trim_end().to_ascii_lowercase();
        if line.is_empty() {
            break;
        }
        if let Some(rest) = line.strip_prefix("http/1.1 ") {
            status = rest.get(..3).unwrap_or_default().parse()?;
        } else if let Some(rest) = line.strip_prefix("content-length:") {
            length = rest.trim().parse()?;
        }
    }
    let mut body = vec![0; length];
    stream.read_exact(&mut body)?;
    Ok((status, String::from_utf8(body)?))
}

/// What became of a session.
#[derive(Default)]
struct Outcome {
    /// Times from a chunk to its answer, ms.
    times: Vec<f64>,
    /// Answers that were no acknowledgement, and connections that broke.
    refused: usize,
    /// The digests of the chunks that were acknowledged.
    acknowledged: Vec<String>,
    is_finished: bool,
}

/// A session from its beginning to its code. `wait` is until the first chunk.
fn session(host: String, study: &str, number: usize, seconds: u32, start: &Barrier) -> Outcome {
    let mut outcome = Outcome::default();
    let mut client = Client { host, stream: None };
    let key = sha256(format!("load {number}").as_bytes());
    let begin = json!({ "key": key, "platform_ids": [], "study": study }).to_string();
    start.wait();
    let mut refused = 0;
    // as the page does: again until it is answered
    let mut until = |method: &str, path: &str, headers: &str, body: &str| loop {
        match client.ask(method, path, headers, body) {
            Ok((200, _)) => return true,
            Ok((status, said)) => {
                eprintln!("{method} {path}: {status} {said}");
                if status < 500 && ![408, 422, 429].contains(&status) {
                    return false;
                }
            }
            Err(error) => eprintln!("{method} {path}: {error}"),
        }
        refused += 1;
        std::thread::sleep(Duration::from_millis(500));
    };
    if !until("POST", "/api/session", "", &begin) {
        outcome.refused += 1;
        return outcome;
    }
    // at another part of the second each
    std::thread::sleep(Duration::from_millis(number as u64 * 7919 % 1000));
    let (mut whole, first) = (String::new(), Instant::now());
    for second in 0..seconds {
        let records = (0..RECORDS)
            .map(|n| json!({ "kind": "input", "at_ms": 1000 * second + n, "data": { "session": number } }));
        let body = Value::from_iter(records).to_string();
        let digest = sha256(body.as_bytes());
        let headers = format!("x-session-key: {key}\r\nx-sha256: {digest}\r\n");
        let asked = Instant::now();
        if until("PUT", &format!("/api/chunks/0/{second}"), &headers, &body) {
            outcome.times.push(asked.elapsed().as_secs_f64() * 1000.0);
            let _ = writeln!(whole, "0 {second} {digest}");
            outcome.acknowledged.push(digest);
        }
        let next = Duration::from_secs(u64::from(second) + 1);
        std::thread::sleep(next.saturating_sub(first.elapsed()));
    }
    let finish = json!({ "digest": sha256(whole.as_bytes()) }).to_string();
    outcome.is_finished = until("POST", "/api/finish", &format!("x-session-key: {key}\r\n"), &finish);
    outcome.refused += refused;
    outcome
}

/// A server of a new study for so many participants, and its host.
fn serve(program: &str, folder: &Path, sessions: usize) -> Result<(Child, String), Failure> {
    if !Command::new(program).args(["study", "new"]).arg(folder).stdout(Stdio::null()).status()?.success() {
        return Err("the study is not made".into());
    }
    let file = folder.join("study.toml");
    let text = std::fs::read_to_string(&file)?;
    std::fs::write(&file, text.replace("participants = 20 ", &format!("participants = {sessions} ")))?;
    let mut server = Command::new(program)
        .args(["study", "serve", "--port", "0"])
        .arg(&file)
        .stdout(Stdio::piped())
        .spawn()?;
    let mut line = String::new();
    BufReader::new(server.stdout.take().ok_or("no output")?).read_line(&mut line)?;
    let host = line.trim().strip_prefix("the study is at http://").and_then(|rest| rest.strip_suffix('/'));
    Ok((server, host.ok_or("no address")?.to_owned()))
}

/// The largest memory of a process, kB.
fn peak(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().trim_end_matches(" kB").parse().ok()
}

/// The part of sorted times below which a share of them is.
fn quantile(times: &[f64], share: f64) -> f64 {
    let at = (share * times.len() as f64).ceil() as usize;
    times.get(at.clamp(1, times.len().max(1)) - 1).copied().unwrap_or(f64::NAN)
}

fn main() -> Result<ExitCode, Failure> {
    let mut arguments = std::env::args().skip(1);
    let program = arguments.next().ok_or("give the program")?;
    let sessions: usize = arguments.next().map_or(Ok(500), |text| text.parse())?;
    let seconds: u32 = arguments.next().map_or(Ok(60), |text| text.parse())?;
    let folder = tempfile::tempdir()?;
    let (mut server, host) = serve(&program, folder.path(), sessions)?;
    let content = Client { host: host.clone(), stream: None }.ask("GET", "/study.json", "", "")?.1;
    let study = serde_json::from_str::<Value>(&content)?["digest"].as_str().ok_or("no digest")?.to_owned();
    let start = Arc::new(Barrier::new(sessions));
    let threads: Vec<_> = (0..sessions)
        .map(|number| {
            let (host, study, start) = (host.clone(), study.clone(), Arc::clone(&start));
            std::thread::Builder::new()
                .stack_size(256 << 10)
                .spawn(move || session(host, &study, number, seconds, &start))
        })
        .collect::<Result<_, _>>()?;
    let outcomes: Vec<Outcome> =
        threads.into_iter().map(|thread| thread.join().unwrap_or_default()).collect();
    let memory = peak(server.id());
    server.kill()?;
    server.wait()?;
    let base = Connection::open(folder.path().join("study.sqlite"))?;
    let integrity: String = base.query_row("PRAGMA integrity_check", [], |row| row.get(0))?;
    let mut statement = base.prepare("SELECT sha256 FROM chunks")?;
    let stored: HashSet<String> = statement.query_map([], |row| row.get(0))?.collect::<Result<_, _>>()?;
    let mut times: Vec<f64> = outcomes.iter().flat_map(|outcome| outcome.times.iter().copied()).collect();
    times.sort_by(f64::total_cmp);
    let refused: usize = outcomes.iter().map(|outcome| outcome.refused).sum();
    let finished = outcomes.iter().filter(|outcome| outcome.is_finished).count();
    let lost = outcomes
        .iter()
        .flat_map(|outcome| &outcome.acknowledged)
        .filter(|digest| !stored.contains(*digest))
        .count();
    println!(
        "{sessions} sessions, a chunk of about 1.5 kB a second for {seconds} s: {} acknowledged, {finished} finished",
        times.len()
    );
    let [p50, p99, most] = [0.5, 0.99, 1.0].map(|share| quantile(&times, share));
    println!("answer to a chunk: p50 {p50:.1} ms, p99 {p99:.1} ms, longest {most:.1} ms");
    println!("refused {refused}, lost {lost}; integrity_check: {integrity}");
    println!("largest memory of the server: {} kB", memory.map_or("unknown".to_owned(), |kb| kb.to_string()));
    let is_good = refused == 0 && lost == 0 && finished == sessions && integrity == "ok";
    Ok(if is_good { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
