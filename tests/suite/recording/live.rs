//! Episodes served while they run: what a viewer that is not ours gets, over Foxglove's protocol.

use super::{messages, path};
use crate::support::{cocarry, stderr};
use cocarry_recording::recording::{Channel, Definition, LiveServer, Message};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Topic, time and data.
type Said = (String, u64, Vec<u8>);

/// One who watches: a WebSocket (RFC 6455) by hand, so that it has nothing in common with the server.
struct Viewer {
    socket: TcpStream,
    channels: Vec<Value>,
    server: Value,
}

impl Viewer {
    /// Connects; does not subscribe to anything.
    fn connect(address: &str) -> Self {
        let mut socket = TcpStream::connect(address).unwrap();
        socket.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let request = format!(
            "GET / HTTP/1.1\r\nHost: {address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\
             Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
        );
        socket.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        while !answer.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            socket.read_exact(&mut byte).unwrap();
            answer.extend(byte);
        }
        let answer = String::from_utf8(answer).unwrap();
        // the key's answer in the RFC's example
        for part in ["HTTP/1.1 101", "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=", "foxglove.sdk.v1\r\n"] {
            assert!(answer.contains(part), "{answer}");
        }
        let mut viewer = Self { socket, channels: Vec::new(), server: Value::Null };
        viewer.server = viewer.told("serverInfo");
        viewer.channels = viewer.told("advertise")["channels"].as_array().unwrap().clone();
        viewer
    }

    /// The next frame: its opcode and what is in it.
    fn frame(&mut self) -> (u8, Vec<u8>) {
        let mut head = [0; 2];
        self.socket.read_exact(&mut head).unwrap();
        let mut length = [0; 8];
        let size = match head[1] {
            127 => 8,
            126 => 2,
            _ => 0,
        };
        self.socket.read_exact(&mut length[8 - size..]).unwrap();
        let length = if size == 0 { head[1].into() } else { u64::from_be_bytes(length) };
        let mut data = vec![0; length as usize];
        self.socket.read_exact(&mut data).unwrap();
        (head[0] & 15, data)
    }

    fn told(&mut self, what: &str) -> Value {
        loop {
            let (1, text) = self.frame() else { continue };
            let told: Value = serde_json::from_slice(&text).unwrap();
            assert_ne!(told["op"], "status", "{told}");
            if told["op"] == what {
                return told;
            }
        }
    }

    /// To all channels, by number.
    fn subscribe(&mut self) {
        let all = self.channels.iter().enumerate();
        let all: Vec<_> = all.map(|(i, c)| json!({ "id": i, "channelId": c["id"] })).collect();
        let words = json!({ "op": "subscribe", "subscriptions": all }).to_string();
        // final, text, with the mask 0
        let head = [&[0x81, 0x80 | 126][..], &(words.len() as u16).to_be_bytes(), &[0; 4]].concat();
        self.socket.write_all(&[&head, words.as_bytes()].concat()).unwrap();
    }

    /// What is said next; the time alone has no topic.
    fn next(&mut self) -> Said {
        loop {
            let (2, data) = self.frame() else { continue };
            let number = |at: usize| u64::from_le_bytes(data[at..at + 8].try_into().unwrap());
            match data[0] {
                1 => {
                    let id = u32::from_le_bytes(data[1..5].try_into().unwrap());
                    let topic = self.channels[id as usize]["topic"].as_str().unwrap();
                    return (topic.to_owned(), number(5), data[13..].to_vec());
                }
                2 => return (String::new(), number(1), Vec::new()),
                other => panic!("{other}"),
            }
        }
    }
}

/// Runs the program with these arguments and `--live`; where it serves.
fn serving(arguments: &[&str]) -> (Child, BufReader<impl Read>, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_cocarry"))
        .args([&["run", "environment-4", "--live=127.0.0.1:0"], arguments].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    said.read_line(&mut line).unwrap();
    let (_, address) = line.trim_end().split_once("ws://").unwrap_or_else(|| panic!("{line}"));
    (child, said, address.to_owned())
}

#[test]
fn viewers_get_what_a_recording_holds_and_who_comes_late_sees_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(folder.path(), "r.mcap");
    let terms =
        ["--plant", "kinematic", "--max-steps", "20", "--live-rate", "4", "--live-wait", "--record", &file];
    let (mut child, _said, address) = serving(&terms);
    let mut early = Viewer::connect(&address);
    assert_eq!(early.server["name"], "cocarry");
    assert_eq!(early.server["capabilities"], json!(["time"]));
    for channel in &early.channels {
        let expected = Definition::of(Channel::of_topic(channel["topic"].as_str().unwrap()).unwrap());
        let schema = expected.schema.unwrap();
        assert_eq!(channel["encoding"], expected.encoding);
        assert_eq!(channel["schemaName"], schema.name);
        assert_eq!(channel["schemaEncoding"], schema.encoding);
        if schema.encoding == "jsonschema" {
            assert_eq!(channel["schema"], String::from_utf8(schema.data).unwrap());
        }
    }
    early.subscribe();
    let mut seen: Vec<Said> = Vec::new();
    while seen.last().is_none_or(|(topic, ..)| topic != "/outcome") {
        seen.push(early.next());
    }
    let bytes = std::fs::read(&file).unwrap();
    let unwatched = path(folder.path(), "unwatched.mcap");
    let terms = ["--plant", "kinematic", "--max-steps", "20", "--record", &unwatched];
    cocarry(&[&["run", "environment-4"][..], &terms].concat());
    assert!(bytes == std::fs::read(&unwatched).unwrap(), "watching changes nothing");
    let mut recorded = messages(&bytes);
    assert!(recorded.len() > 150);
    let mut told: Vec<_> = seen.iter().filter(|(topic, ..)| !topic.is_empty()).cloned().collect();
    // what was there before anybody subscribed comes in the order of the subscriptions
    recorded.sort_by(|a, b| a.0.cmp(&b.0));
    told.sort_by(|a, b| a.0.cmp(&b.0));
    assert!(told == recorded, "{} messages for {}", told.len(), recorded.len());
    let clock: Vec<u64> =
        seen.iter().filter(|(topic, ..)| topic.is_empty()).map(|(_, time, _)| *time).collect();
    assert!(clock.len() >= 20 && clock.is_sorted(), "{clock:?}");

    let mut late = Viewer::connect(&address);
    late.subscribe();
    let mut last = std::collections::BTreeMap::new();
    let mut clock = None;
    while clock.is_none() || last.len() < late.channels.len() {
        let (topic, time, data) = late.next();
        match &*topic {
            "" => clock = Some(time),
            _ => assert_eq!(last.insert(topic, (time, data)), None, "once"),
        }
    }
    assert_eq!(clock, Some(4_000_000_000));
    for (topic, said) in last {
        let (_, time, data) = recorded.iter().rfind(|m| m.0 == topic).unwrap();
        assert!(said == (*time, data.clone()), "{topic}");
    }
    assert!(child.try_wait().unwrap().is_none(), "served on while there are viewers");
    drop(early);
    drop(late);
    assert_eq!(child.wait().unwrap().code(), Some(3), "out of time, as without viewers");
}

#[test]
fn a_run_that_nobody_watches_goes_on_at_its_pace_and_ends() {
    let begun = Instant::now();
    let (mut child, _said, _) = serving(&["--plant", "point", "--max-steps", "20", "--live-rate", "8"]);
    assert_eq!(child.wait().unwrap().code(), Some(3));
    assert!(begun.elapsed() >= Duration::from_millis(500), "4 s at 8 times real time: {:?}", begun.elapsed());
}

#[test]
#[cfg(unix)]
fn ctrl_c_ends_the_wait_for_a_viewer_who_does_not_come() {
    let (mut child, mut said, _) = serving(&["--plant", "point", "--live-wait"]);
    let mut line = String::new();
    said.read_line(&mut line).unwrap();
    assert!(line.contains("waiting"), "{line}");
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    line.clear();
    said.read_line(&mut line).unwrap();
    assert_eq!(line, "interrupted after 0 steps\n");
}

/// One who subscribes and then never reads loses the oldest messages, and costs neither time nor memory
/// without end.
#[test]
fn a_viewer_who_stalls_does_not_hold_up_anything() {
    let mut server = LiveServer::start("127.0.0.1:0".parse().unwrap(), &[], &Channel::ALL).unwrap();
    let mut viewer = Viewer::connect(&server.address().to_string());
    viewer.subscribe();
    while !server.is_watched() {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(server.viewers(), 1);
    let begun = Instant::now();
    for time in 0..100_000 {
        let data = vec![0; 1000];
        server.send(&[Message { channel: Channel::Cost, time, data }]);
    }
    server.stop();
    assert!(begun.elapsed() < crate::support::time_for(10), "{:?}", begun.elapsed());
}

/// The first line of the answer to a request to open a WebSocket, with these more headers.
fn answer(address: &str, headers: &str) -> String {
    let mut socket = TcpStream::connect(address).unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let request = format!(
        "GET / HTTP/1.1\r\nHost: {address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n{headers}\r\n"
    );
    socket.write_all(request.as_bytes()).unwrap();
    let mut line = String::new();
    BufReader::new(socket).read_line(&mut line).unwrap();
    line
}

#[test]
fn web_pages_watch_only_from_allowed_origins() {
    let arguments = ["--plant", "point", "--live-wait", "--live-origin", "https://viewer.example.org"];
    let (mut child, _said, address) = serving(&arguments);
    for good in [
        "",
        "Origin: https://viewer.example.org\r\n",
        "origin: http://localhost:8080\r\n",
        "Origin: https://app.foxglove.dev\r\n",
        "Origin: file://\r\n",
    ] {
        assert!(answer(&address, good).contains(" 101 "), "{good:?}: {}", answer(&address, good));
    }
    for bad in [
        "Origin: https://example.org\r\n",
        "Origin: null\r\n",
        "ORIGIN:https://viewer.example.org.evil.example\r\n",
        "Origin: http://localhost.evil.example\r\n",
        "Origin: http://localhost\r\nOrigin: https://evil.example\r\n",
    ] {
        assert!(answer(&address, bad).contains(" 403 "), "{bad:?}: {}", answer(&address, bad));
    }
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Descriptors that the process has open.
#[cfg(target_os = "linux")]
fn descriptors(child: &Child) -> usize {
    std::fs::read_dir(format!("/proc/{}/fd", child.id())).unwrap().count()
}

#[test]
#[cfg(target_os = "linux")]
fn a_viewer_who_leaves_leaves_nothing_behind() {
    let (mut child, _said, address) = serving(&["--plant", "point", "--live-wait"]);
    drop(Viewer::connect(&address));
    let settled = |most: usize| {
        let begun = Instant::now();
        while descriptors(&child) > most && begun.elapsed() < Duration::from_secs(10) {
            std::thread::sleep(Duration::from_millis(20));
        }
        descriptors(&child)
    };
    std::thread::sleep(Duration::from_millis(500));
    let before = descriptors(&child);
    for _ in 0..150 {
        drop(Viewer::connect(&address));
    }
    assert!(settled(before + 8) <= before + 8, "{before} descriptors became {}", descriptors(&child));
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn connections_that_send_nothing_keep_nobody_out() {
    let (mut child, _said, address) = serving(&["--plant", "point", "--live-wait"]);
    let silent: Vec<TcpStream> = (0..200).map(|_| TcpStream::connect(&address).unwrap()).collect();
    let begun = Instant::now();
    let viewer = Viewer::connect(&address);
    assert!(begun.elapsed() < Duration::from_secs(2), "{:?}", begun.elapsed());
    drop((silent, viewer));
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_port_that_is_taken_ends_with_4() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let live = format!("--live={}", taken.local_addr().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let output = cocarry(&["run", "--plant", "point", &live, "--record", &path(folder.path(), "r.mcap")]);
    assert_eq!(output.status.code(), Some(4));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "refused before anything is written");
    assert!(stderr(&output).contains("another program listens there"), "{}", stderr(&output));
    // an address for documentation, which no computer has
    let output = cocarry(&["run", "--plant", "point", "--live=192.0.2.1:8765"]);
    assert_eq!(output.status.code(), Some(4));
    assert!(stderr(&output).contains("192.0.2.1:8765: cannot be listened at"), "{}", stderr(&output));
}
