//! Recordings: written, read back, cut, damaged, recovered.

use crate::support::{cocarry, json, repository, stderr, stdout};
use cocarry::episode::{Episode, Settings, Tick};
use cocarry::experiments::paper::EXAMPLE_HUMAN;
use cocarry::geometry::Pose;
use cocarry::recording::{
    Channel, Contents, Definition, Encoder, Ending, Entry, FileRecorder, Message, Reader, Recorder, Verdict,
    columns, decode, recover, replay,
};
use cocarry::robot::Robot;
use cocarry::scenario::{Carrier, Plant, Scenario};
use cocarry::simulation::PhysicsSettings;
use cocarry::world::World;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::Value;
use std::io::Cursor;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// The human of the example in Environment 4.
fn example(plant: Plant) -> Scenario {
    let world = World::load(&repository("worlds/environment-4.toml")).expect("a world");
    let settings = Settings::default();
    Scenario { seed: 1, world: world.into(), human: EXAMPLE_HUMAN, settings, plant }
}

fn carrier() -> Carrier {
    let robot = Robot::built_in().expect("the built-in robot").texts;
    Carrier { posture: "elbow-up".to_owned(), control: Default::default(), robot }
}

fn rapier() -> Plant {
    Plant::Rapier { carrier: carrier(), physics: PhysicsSettings::default() }
}

/// A scenario's episode as a file, and as what it is told as; `on_step` sees the episode before the first step and after each.
fn encoded(scenario: Scenario, mut on_step: impl FnMut(&Episode)) -> (Vec<u8>, Vec<Message>) {
    let stage = scenario.prepare().expect("a scenario");
    let mut episode = stage.episode().expect("room");
    let mut encoder = Encoder::new(&stage);
    let mut messages = encoder.begin(&episode).to_vec();
    let file = Cursor::new(Vec::new());
    let mut recorder = Recorder::new(file, "memory", &stage, &episode).expect("memory");
    on_step(&episode);
    let outcome = loop {
        if let Some(outcome) = episode.step() {
            break outcome;
        }
        recorder.step(&episode).expect("memory");
        messages.extend_from_slice(encoder.step(&episode));
        on_step(&episode);
    };
    messages.extend_from_slice(encoder.end(&episode, Ending::Over(outcome)));
    let file = recorder.finish(&episode, Ending::Over(outcome)).expect("memory");
    (file.into_inner(), messages)
}

/// The messages in a file: topic, time and data.
fn messages(bytes: &[u8]) -> Vec<(String, u64, Vec<u8>)> {
    let mut reader = Reader::new(bytes, "test").expect("an MCAP file");
    let mut messages = Vec::new();
    while let Some(entry) = reader.next().unwrap_or_else(|e| panic!("{e}")) {
        if let Some(m) = entry.message() {
            messages.push((m.channel.topic.clone(), m.time, m.data.to_vec()));
        }
    }
    messages
}

fn decoded(message: &Message) -> Value {
    decode(&Definition::of(message.channel), &message.data).expect("decodable")
}

#[test]
fn what_is_read_is_what_was_written() {
    let (bytes, written) = encoded(example(rapier()), |_| {});
    let read = messages(&bytes);
    assert_eq!(read.len(), written.len());
    for (read, written) in read.iter().zip(&written) {
        assert_eq!((&*read.0, read.1, &read.2), (written.channel.topic(), written.time, &written.data));
    }
    assert!(written.windows(2).all(|w| w[0].time <= w[1].time), "time runs forward");
    let contents = Contents::read(&mut Reader::new(&bytes[..], "test").unwrap()).unwrap();
    assert_eq!(contents.provenance["seed"], "1");
    assert_eq!(contents.outcome.expect("an outcome")["outcome"], "arrived");
    for channel in Channel::ALL {
        assert!(contents.channels[channel.topic()].messages > 0, "{channel:?}");
    }
}

/// Frames, joints and figures say what the episode says.
#[test]
fn frames_and_figures_are_those_of_the_episode() {
    let mut seen: Vec<(u64, Vec<Pose>, [Pose; 3], f64)> = Vec::new();
    let mut ticks: Vec<Tick> = Vec::new();
    let (_, written) = encoded(example(rapier()), |episode| {
        let o = episode.observation().expect("physics");
        let bodies = [o.object, o.hand, o.torso];
        let links = episode.link_poses().expect("a robot");
        seen.push(((o.time * 1e9).round() as u64, links, bodies, o.hand_grip.mean.force.z));
        if seen.len() > 1 {
            ticks.push(episode.tick().clone());
        }
    });
    let robot = Robot::built_in().unwrap();
    let of = |channel: Channel| written.iter().filter(move |m| m.channel == channel);
    assert_eq!(of(Channel::Transforms).count(), seen.len());
    for (message, (time, links, bodies, _)) in of(Channel::Transforms).zip(&seen) {
        assert!(message.time.abs_diff(*time) < 1000);
        let value = decoded(message);
        let at = |frame: &str| {
            let all = value["transforms"].as_array().unwrap();
            let t = all.iter().find(|t| t["child_frame_id"] == frame).unwrap_or_else(|| panic!("{frame}"));
            assert_eq!(t["parent_frame_id"], "world");
            ["x", "y", "z"].map(|axis| t["translation"][axis].as_f64().unwrap())
        };
        for (link, pose) in robot.links.iter().zip(links) {
            let p = pose.translation;
            assert_eq!(at(&format!("robot/{}", link.name)), [p.x, p.y, p.z]);
        }
        for (frame, pose) in ["object", "human/hand", "human/torso"].iter().zip(bodies) {
            let p = pose.translation;
            assert_eq!(at(frame), [p.x, p.y, p.z]);
        }
    }
    for (message, (_, _, _, force)) in of(Channel::Interaction).zip(&seen[1..]) {
        assert_eq!(decoded(message)["hand"]["force_n"]["z"].as_f64(), Some(*force));
    }
    for (message, tick) in of(Channel::Coordination).zip(&ticks) {
        let value = decoded(message);
        assert_eq!(value["stubbornness"].as_f64(), Some(tick.stubbornness));
        assert_eq!(value["x_m"].as_f64(), Some(tick.position.x));
    }
    for (message, tick) in of(Channel::Options).zip(&ticks) {
        let value = decoded(message);
        for (o, option) in tick.options.iter().enumerate() {
            let recorded = &value["options"][o];
            assert_eq!(recorded["probability"].as_f64(), Some(option.probability));
            let expected = Some(option.expected).filter(|e| e.is_finite());
            assert_eq!(recorded["expected_m"].as_f64(), expected, "what is no number is null");
        }
    }
    let said: Vec<String> =
        of(Channel::Log).map(|m| decoded(m)["message"].as_str().unwrap().to_owned()).collect();
    for words in ["leads on option 3", "the human takes the lead", "arrived on option 3"] {
        assert!(said.iter().any(|s| s.contains(words)), "{words:?} is missing from {said:?}");
    }
}

/// Every JSON message has just the fields of its schema, of the types that it says.
#[test]
fn json_messages_are_as_their_schemas_say() {
    fn check(schema: &Value, value: &Value, path: &str) {
        let nullable = schema["nullable"] == true;
        assert!(schema["description"].is_string() || path.is_empty() || path.ends_with("[]"), "{path}");
        match schema["type"].as_str().unwrap_or_else(|| panic!("{path}: one plain type")) {
            _ if value.is_null() => assert!(nullable, "{path} is null"),
            "number" => assert!(value.is_number(), "{path}: {value}"),
            "integer" => assert!(value.is_u64(), "{path}: {value}"),
            "string" => assert!(value.is_string(), "{path}: {value}"),
            "boolean" => assert!(value.is_boolean(), "{path}: {value}"),
            "array" => {
                for item in value.as_array().unwrap() {
                    check(&schema["items"], item, &format!("{path}[]"));
                }
            }
            "object" => {
                let (fields, known) = (value.as_object().unwrap(), schema["properties"].as_object().unwrap());
                assert!(fields.keys().eq(known.keys()), "{path}: {:?}", fields.keys());
                fields.iter().for_each(|(key, value)| check(&known[key], value, &format!("{path}.{key}")));
            }
            other => panic!("{path}: {other}"),
        }
    }
    let mut checked = 0;
    for plant in [Plant::Point, Plant::Kinematic { carrier: carrier() }, rapier()] {
        for message in encoded(example(plant), |_| {}).1.iter().filter(|m| m.channel.encoding() == "json") {
            let schema: Value = serde_json::from_slice(&message.channel.schema().data).unwrap();
            check(&schema, &decoded(message), "");
            checked += 1;
        }
    }
    assert!(checked > 1000);
}

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().expect("UTF-8").to_owned()
}

#[test]
fn two_runs_give_the_same_bytes_and_recovering_a_whole_recording_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b, c] = ["a.mcap", "b.mcap", "c.mcap"].map(|name| path(folder.path(), name));
    for file in [&a, &b] {
        json(&["run", "environment-1", "--plant", "rapier", "--seed", "7", "--record", file, "--json"]);
    }
    let bytes = std::fs::read(&a).unwrap();
    assert!(bytes == std::fs::read(&b).unwrap());
    assert!(bytes.len() < 3 << 20);
    let output = cocarry(&["recover", &a, "-o", &c]);
    assert!(stdout(&output).contains("nothing is lost"), "{}", stderr(&output));
    assert!(bytes == std::fs::read(&c).unwrap());
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 3, "{left:?}");
    let text = String::from_utf8_lossy(&bytes);
    assert!(!text.contains(folder.path().to_str().unwrap()), "no path of this machine");
}

#[test]
fn inspect_tells_what_is_in_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let [file, table, picture, ticks] =
        ["r.mcap", "t.csv", "p.svg", "t.jsonl"].map(|n| path(folder.path(), n));
    let run = json(&["run", "--record", &file, "--seed", "3", "--json", "--ticks", &ticks]);
    let told = json(&["inspect", &file, "--json"]);
    assert_eq!(told["outcome"]["outcome"], run["outcome"]);
    assert_eq!(told["outcome"]["steps"], run["steps"]);
    assert_eq!(told["outcome"]["control_cost"], run["control"]["cost"]);
    assert_eq!(told["provenance"]["seed"], "3");
    assert_eq!(told["attachments"][0]["name"], "scenario.toml");
    let steps = run["steps"].as_u64().unwrap();
    let tf = told["channels"].as_array().unwrap().iter().find(|c| c["topic"] == "/tf").unwrap();
    assert_eq!(tf["messages"], steps + 1);
    let text = stdout(&cocarry(&["inspect", &file]));
    assert!(text.contains("foxglove.SceneUpdate") && text.contains("arrived"), "{text}");

    let output = cocarry(&["inspect", &file, "--csv", "/options", "--output", &table]);
    assert!(output.status.success(), "{}", stderr(&output));
    let mut reader = csv::Reader::from_path(&table).unwrap();
    let headings = reader.headers().unwrap().clone();
    let column = headings.iter().position(|h| h == "options[3].probability").expect("a column");
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len() as u64, steps);
    let ticks = std::fs::read_to_string(&ticks).unwrap();
    for (row, line) in rows.iter().zip(ticks.lines()) {
        let tick: Value = serde_json::from_str(line).unwrap();
        assert_eq!(row[column].parse::<f64>().unwrap(), tick["options"][2]["probability"].as_f64().unwrap());
    }
    let joints = stdout(&cocarry(&["inspect", &file, "--csv", "/joints"]));
    assert!(joints.lines().next().unwrap().contains("joints[elbow_flex_joint].position"));
    let output = cocarry(&["inspect", &file, "--csv", "/nothing"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("no channel `/nothing`") && stderr(&output).contains("`/options`"));

    let drawn = path(folder.path(), "run.svg");
    json(&["run", "--seed", "3", "--json", "--svg", &drawn]);
    assert!(cocarry(&["inspect", &file, "--svg", &picture]).status.success());
    assert_eq!(std::fs::read_to_string(picture).unwrap(), std::fs::read_to_string(drawn).unwrap());
}

#[test]
fn a_recording_that_is_there_is_replaced_only_if_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(folder.path(), "r.mcap");
    for name in ["r.mcap", "r.mcap.partial"] {
        std::fs::write(folder.path().join(name), "mine").unwrap();
        let output = cocarry(&["run", "--plant", "point", "--record", &file]);
        assert_eq!(output.status.code(), Some(4));
        assert!(stderr(&output).contains(&format!("{name}: ")) && stderr(&output).contains("--overwrite"));
        assert_eq!(std::fs::read(folder.path().join(name)).unwrap(), b"mine");
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            1,
            "refused before anything is written"
        );
        assert!(cocarry(&["run", "--plant", "point", "--record", &file, "--overwrite"]).status.success());
        assert!(messages(&std::fs::read(&file).unwrap()).len() > 100);
        std::fs::remove_file(&file).unwrap();
    }
    let output = cocarry(&["run", "--overwrite"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn a_folder_that_cannot_be_written_to_ends_with_4() {
    let folder = tempfile::tempdir().unwrap();
    let gone = path(folder.path(), "no/such/folder/r.mcap");
    // below a file nobody can write, whoever they are
    std::fs::write(folder.path().join("file"), "").unwrap();
    let below = path(folder.path(), "file/r.mcap");
    for file in [&*gone, &*below, "/proc/r.mcap"] {
        let output = cocarry(&["run", "--plant", "point", "--record", file]);
        assert_eq!(output.status.code(), Some(4), "{file}");
        assert!(stderr(&output).starts_with(&format!("error: {file}.partial: cannot be written")));
    }
    let whole = path(folder.path(), "r.mcap");
    assert!(cocarry(&["run", "--plant", "point", "--record", &whole]).status.success());
    let output = cocarry(&["recover", &whole, "-o", &gone]);
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
}

/// A world so long that a run in it takes many seconds.
fn long_world(folder: &Path) -> String {
    let text = "name = \"long\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [5000, 0]\n";
    let file = folder.join("long.toml");
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

/// Runs the program on under `sh`, which sets limits that a full disk would set.
#[test]
fn a_full_disk_ends_with_4_and_leaves_what_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(folder.path(), "r.mcap");
    let program = env!("CARGO_BIN_EXE_cocarry");
    // blocks of 512 bytes
    for blocks in [1, 300, 500] {
        let command = format!(
            "trap '' XFSZ; ulimit -f {blocks}; exec '{program}' run environment-4 --plant rapier --record '{file}'"
        );
        let output = Command::new("sh").args(["-c", &command]).output().unwrap();
        assert_eq!(output.status.code(), Some(4), "{blocks}: {}", stderr(&output));
        assert!(stderr(&output).contains("r.mcap.partial: cannot be written on"), "{}", stderr(&output));
        assert!(!Path::new(&file).exists());
        let partial = format!("{file}.partial");
        let saved = path(folder.path(), "saved.mcap");
        let output = cocarry(&["recover", &partial, "-o", &saved, "--overwrite"]);
        assert!(output.status.success(), "{blocks}: {}", stderr(&output));
        if blocks > 1 {
            assert!(messages(&std::fs::read(&saved).unwrap()).len() > 50, "{blocks}");
        }
        std::fs::remove_file(partial).unwrap();
    }
}

/// A run in the long world, once it has recorded something.
fn under_way(folder: &Path, name: &str) -> (std::process::Child, String) {
    let file = path(folder, name);
    let world = long_world(folder);
    let mut child = Command::new(env!("CARGO_BIN_EXE_cocarry"))
        .args(["run", &world, "--plant", "rapier", "--sway", "0", "--record", &file])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let partial = format!("{file}.partial");
    for _ in 0..3000 {
        if std::fs::metadata(&partial).is_ok_and(|m| m.len() > 20_000) {
            return (child, file);
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    panic!("nothing was recorded: {}", child.wait().unwrap());
}

#[test]
fn a_killed_run_leaves_all_but_the_last_second() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut runs: Vec<Vec<(String, u64, Vec<u8>)>> = Vec::new();
    for i in 0..4 {
        let (mut child, file) = under_way(folder.path(), &format!("{i}.mcap"));
        std::thread::sleep(Duration::from_millis(rng.random_range(0..400)));
        child.kill().unwrap();
        child.wait().unwrap();
        let saved = path(folder.path(), "saved.mcap");
        let output = cocarry(&["recover", &format!("{file}.partial"), "-o", &saved, "--overwrite"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let saved = messages(&std::fs::read(&saved).unwrap());
        // what is saved ends with a whole second
        let last = saved.last().expect("messages").1;
        assert!(last >= 1_000_000_000 && last.is_multiple_of(1_000_000_000), "{last}");
        runs.push(saved);
    }
    runs.sort_by_key(Vec::len);
    let longest = runs.pop().unwrap();
    for run in runs {
        assert!(longest[..run.len()] == run[..], "what is saved is how the run began");
    }
}

/// Whenever it stops, at most a second is not in the system's hands.
#[test]
fn what_a_crash_leaves_is_at_most_a_second_behind() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = example(rapier());
    let settings = Settings { tick_limit: Some(17), ..scenario.settings };
    let stage = Scenario { settings, ..scenario }.prepare().unwrap();
    let mut episode = stage.episode().unwrap();
    let file = folder.path().join("r.mcap");
    let mut recorder = FileRecorder::create(&file, false, &stage, &episode).unwrap();
    let mut written = Vec::new();
    while episode.step().is_none() {
        recorder.step(&episode).unwrap();
        let left = std::fs::read(folder.path().join("r.mcap.partial")).unwrap();
        let to = folder.path().join("saved.mcap");
        recover(&mut Reader::new(&left[..], "m").unwrap(), &to, true).unwrap();
        let saved = messages(&std::fs::read(&to).unwrap());
        let (last, now) = (saved.last().unwrap().1, 200_000_000 * (episode.tick().step + 1));
        assert!(last + 1_000_000_000 > now && last <= now, "{last} of {now}");
        assert!(saved[..written.len()] == written[..]);
        written = saved;
    }
    assert!(written.len() > 100);
}

#[test]
#[cfg(unix)]
fn an_interrupted_run_finishes_its_recording() {
    let folder = tempfile::tempdir().unwrap();
    let (child, file) = under_way(folder.path(), "r.mcap");
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(stderr(&output).contains("interrupted after"));
    let told = json(&["inspect", &file, "--json"]);
    assert_eq!(told["outcome"]["outcome"], "interrupted");
    assert!(!Path::new(&format!("{file}.partial")).exists());
}

#[test]
#[cfg(unix)]
fn a_folder_that_vanishes_ends_with_4() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("gone")).unwrap();
    let (child, file) = under_way(&folder.path().join("gone"), "r.mcap");
    std::fs::remove_dir_all(folder.path().join("gone")).unwrap();
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(4));
    let said = stderr(&output);
    assert!(
        said.contains(&format!("{file}.partial: is complete, but cannot be renamed to {file}")),
        "{said}"
    );
}

/// A short recording, of the point.
fn short() -> Vec<u8> {
    short_on(Plant::Point)
}

fn short_on(plant: Plant) -> Vec<u8> {
    let scenario = example(plant);
    let settings = Settings { tick_limit: Some(12), ..scenario.settings };
    encoded(Scenario { settings, ..scenario }, |_| {}).0
}

/// The error that reading gives.
fn fault(bytes: &[u8]) -> String {
    match Reader::new(bytes, "bad.mcap").and_then(|mut reader| Contents::read(&mut reader)) {
        Ok(_) => panic!("it was read"),
        Err(error) => error.to_string(),
    }
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

fn chunk(size: u64, checksum: u32, compression: &str, packed: &[u8]) -> Vec<u8> {
    let name = [&(compression.len() as u32).to_le_bytes(), compression.as_bytes()].concat();
    let head = [&[0; 16][..], &size.to_le_bytes(), &checksum.to_le_bytes(), &name].concat();
    [MAGIC, &record(6, &[&head, &(packed.len() as u64).to_le_bytes()[..], packed].concat())].concat()
}

#[test]
fn bad_files_are_told_with_their_place() {
    let whole = short();
    assert_eq!(fault(b""), "bad.mcap: is no MCAP file: it must begin with the bytes 89 4d 43 41 50 30 0d 0a");
    assert!(fault(b"not an MCAP file").contains("is no MCAP file"));
    assert!(fault(&whole[..5]).contains("is cut at byte 5"));
    assert!(fault(&whole[..whole.len() - 3]).contains("in the last bytes"));
    assert!(fault(&[&whole[..], b"x"].concat()).contains("nothing else"));
    let mut long = whole.clone();
    long[9..17].copy_from_slice(&u64::MAX.to_le_bytes());
    let said = fault(&long);
    assert!(said.contains("the header at byte 8 would be 18446744073709551615 bytes long"), "{said}");
    let mut flipped = whole.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 4;
    let said = fault(&flipped);
    assert!(said.contains("at byte") && said.starts_with("bad.mcap: "), "{said}");
    // a bomb, honest and not, and other hostile chunks
    let zeros = zstd::bulk::compress(&vec![0; 30 << 20], 3).unwrap();
    let honest = chunk(1 << 40, 0, "zstd", &zeros);
    assert!(fault(&honest).contains("the contents of a chunk at byte 8 would be 1099511627776 bytes long"));
    assert!(fault(&chunk(1000, 0, "zstd", &zeros)).contains("a chunk at byte 8: it cannot be unpacked"));
    assert!(
        fault(&chunk(10, 0, "zstd", &zstd::bulk::compress(&[0; 9], 3).unwrap())).contains("should be 10")
    );
    assert!(fault(&chunk(4, 7, "", b"abcd")).contains("checksum"));
    assert!(
        fault(&chunk(4, 0, "lz4", b"abcd")).contains("its compression is `lz4`; only zstd and none are read")
    );
    assert!(fault(&chunk(4, 0, "", b"abcd")).contains("a record is longer than what is left of it"));
    let lost = record(5, &[[7, 0].as_slice(), &[0; 20]].concat());
    assert!(
        fault(&chunk(lost.len() as u64, 0, "", &lost)).contains("is on channel 7, which was not defined")
    );
    let mut greedy = MAGIC.to_vec();
    for id in 1..=40u16 {
        let text =
            [&id.to_le_bytes()[..], &[0; 8], &(1u32 << 19).to_le_bytes(), &vec![b' '; 1 << 19]].concat();
        greedy.extend(record(3, &text));
    }
    assert!(fault(&greedy).contains("all schemas up to that"), "{}", fault(&greedy));
}

/// Any file is either read or refused with words; what is recovered is a recording.
fn survives(bytes: &[u8], folder: &Path) {
    let refused = |error: &cocarry::recording::ReadError| {
        let said = error.to_string();
        assert!(said.starts_with("m: ") && said.len() < 10_000, "{said}");
    };
    let mut reader = match Reader::new(bytes, "m") {
        Ok(reader) => reader,
        Err(error) => return refused(&error),
    };
    if let Err(error) = Contents::read(&mut reader) {
        refused(&error);
    }
    for topic in ["/options", "/log"] {
        let columns = Reader::new(bytes, "m").and_then(|mut r| columns(&mut r, topic));
        if let Err(error) = columns {
            refused(&error);
        }
    }
    if let Ok(again) = Reader::new(bytes, "m").and_then(|first| replay(first, Reader::new(bytes, "m")?)) {
        assert!(again.same < 1000);
    }
    let to = folder.join("out.mcap");
    let saved = recover(&mut Reader::new(bytes, "m").unwrap(), &to, true).unwrap();
    let read = messages(&std::fs::read(&to).unwrap());
    assert_eq!(read.len() as u64, saved.messages);
}

/// A file with something wrong in it.
fn mutant(whole: &[u8], rng: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..rng.random_range(1..4) {
        let at = rng.random_range(0..bytes.len().max(1)).min(bytes.len().saturating_sub(1));
        if bytes.len() < 16 {
            return bytes;
        }
        match rng.random_range(0..7) {
            0 => bytes[at] ^= 1 << rng.random_range(0..8),
            1 => bytes[at] = rng.random(),
            2 => bytes.truncate(at),
            3 => {
                let until = (at + rng.random_range(1..64)).min(bytes.len());
                bytes.drain(at..until);
            }
            4 => {
                let until = (at + rng.random_range(1..64)).min(bytes.len());
                let copy = bytes[at..until].to_vec();
                let to = rng.random_range(0..bytes.len());
                bytes.splice(to..to, copy);
            }
            5 => {
                let number = [0, 1, u64::MAX, 1 << 31, 1 << 40, 255][rng.random_range(0..6)];
                let end = (at + 8).min(bytes.len());
                bytes[at..end].copy_from_slice(&number.to_le_bytes()[..end - at]);
            }
            _ => {
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&rng.random::<u32>().to_le_bytes()[..end - at]);
            }
        }
    }
    bytes
}

/// The same file with its chunks not packed and without checksums, so that what is wrong in them is not found out at once.
fn unpacked(whole: &[u8]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    let mut rest = &whole[8..whole.len() - 8];
    while !rest.is_empty() {
        let length = u64::from_le_bytes(rest[1..9].try_into().unwrap()) as usize;
        let (opcode, body) = (rest[0], &rest[9..9 + length]);
        rest = &rest[9 + length..];
        match opcode {
            6 => {
                let packed = &body[16 + 8 + 4 + 4 + 4 + 8..];
                let records = zstd::bulk::decompress(packed, 1 << 20).unwrap();
                bytes.extend(&chunk(records.len() as u64, 0, "", &records)[8..]);
            }
            15 => bytes.extend(record(15, &[0; 4])),
            2 => bytes.extend(record(2, &[&body[..16], &[0; 4]].concat())),
            9 => bytes.extend(record(9, &[&body[..body.len() - 4], &[0; 4]].concat())),
            _ => bytes.extend(record(opcode, body)),
        }
    }
    bytes.extend(MAGIC);
    bytes
}

fn fuzz(seed: u64, mutants: usize, plant: Plant) {
    let folder = tempfile::tempdir().unwrap();
    let whole = short_on(plant);
    let plain = unpacked(&whole);
    assert_eq!(messages(&whole), messages(&plain));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for i in 0..mutants {
        let bytes = mutant(if i % 3 == 0 { &whole } else { &plain }, &mut rng);
        survives(&bytes, folder.path());
    }
}

#[test]
fn property_no_file_makes_reading_or_recovering_panic() {
    fuzz(1, 400, Plant::Point);
    fuzz(2, 40, rapier());
}

/// For long: `COCARRY_FUZZ_SECONDS=600 cargo test --test suite fuzz_for_long -- --ignored`.
#[test]
#[ignore = "runs as long as it is told to"]
fn fuzz_for_long() {
    let seconds = std::env::var("COCARRY_FUZZ_SECONDS").ok().and_then(|s| s.parse().ok()).unwrap_or(10);
    let begun = std::time::Instant::now();
    let mut seed = 1000;
    while begun.elapsed() < Duration::from_secs(seconds) {
        fuzz(seed, 1000, if seed % 2 == 0 { Plant::Point } else { rapier() });
        seed += 1;
    }
    println!("{} mutants", (seed - 1000) * 1000);
}

/// Where the chunks with messages begin.
fn chunks(whole: &[u8]) -> Vec<usize> {
    let mut reader = Reader::new(whole, "m").unwrap();
    let mut chunks = Vec::new();
    while let Some(entry) = reader.next().unwrap() {
        if let Entry::Message(m) = entry {
            chunks.push(m.chunk as usize);
        }
    }
    chunks.dedup();
    chunks
}

#[test]
fn damage_in_the_middle_loses_that_second_only() {
    let whole = short();
    let folder = tempfile::tempdir().unwrap();
    let chunks = chunks(&whole);
    let [first, second, third] = [0, 1, 2].map(|i| chunks[i]);
    assert!(first < second && second < third);
    let mut damaged = whole.clone();
    damaged[(second + third) / 2] ^= 1;
    let to = folder.path().join("saved.mcap");
    let saved = recover(&mut Reader::new(&damaged[..], "m").unwrap(), &to, false).unwrap();
    let bytes = std::fs::read(&to).unwrap();
    let (all, read) = (messages(&whole), messages(&bytes));
    assert!(read.len() < all.len() && read.iter().all(|m| all.contains(m)));
    assert_eq!(read.last(), all.last());
    assert!(saved.lost[0].to_string().contains(&format!("a chunk at byte {second}")), "{:?}", saved.lost);
    let contents = Contents::read(&mut Reader::new(&bytes[..], "m").unwrap()).unwrap();
    assert!(contents.recovered.expect("said")["001"].contains("a chunk at byte"));
}

/// The same file with one of its messages rewritten.
fn rewritten(whole: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let mut bytes = unpacked(whole);
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).expect(from);
    bytes[at..at + from.len()].copy_from_slice(to.as_bytes());
    bytes
}

fn replayed(bytes: &[u8]) -> cocarry::recording::Replay {
    replay(Reader::new(bytes, "m").unwrap(), Reader::new(bytes, "m").unwrap())
        .unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_recording_replays_to_the_last_message_on_every_plant() {
    for plant in [Plant::Point, Plant::Kinematic { carrier: carrier() }, rapier()] {
        let (bytes, written) = encoded(example(plant), |_| {});
        let again = replayed(&bytes);
        assert_eq!(again.verdict, Verdict::Identical);
        assert_eq!(again.same, written.len() as u64);
    }
}

#[test]
fn a_replay_names_what_differs_with_both_values() {
    let whole = short();
    assert_eq!(replayed(&unpacked(&whole)).verdict, Verdict::Identical);
    let changed = rewritten(&whole, "\"executed_index\":2,\"heading", "\"executed_index\":1,\"heading");
    let Verdict::Different(d) = replayed(&changed).verdict else { panic!("no difference") };
    assert_eq!(
        (&*d.topic, &*d.field, &*d.recorded, &*d.expected),
        ("/coordination", "executed_index", "1", "2")
    );
    assert_eq!(d.time, 0);
    let said = rewritten(&whole, "the robot leads on option", "the human leads on option");
    let Verdict::Different(d) = replayed(&said).verdict else { panic!("no difference") };
    assert_eq!((&*d.topic, &*d.field), ("/log", "message"));
    assert!(d.recorded.contains("human leads") && d.expected.contains("robot leads"));
    // another world gives another run
    let moved = rewritten(&whole, "seed = 1", "seed = 2");
    assert_eq!(replayed(&moved).verdict, Verdict::Identical, "a point has no gait");
    let patient = rewritten(&whole, "eta = 10.5", "eta = 90.5");
    let Verdict::Different(d) = replayed(&patient).verdict else { panic!("no difference") };
    assert_eq!((&*d.topic, &*d.field, d.time), ("/coordination", "stubbornness", 200_000_000));
    // recovered from a cut one
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().join("saved.mcap");
    recover(&mut Reader::new(&whole[..chunks(&whole)[2] + 20], "m").unwrap(), &to, false).unwrap();
    let cut = replayed(&std::fs::read(&to).unwrap());
    assert_eq!(cut.verdict, Verdict::IdenticalUntilCut);
    assert!(cut.same > 3);
}

#[test]
fn the_program_replays() {
    let folder = tempfile::tempdir().unwrap();
    let [file, other] = ["r.mcap", "o.mcap"].map(|n| path(folder.path(), n));
    json(&["run", "--plant", "rapier", "--record", &file, "--json", "--seed", "4"]);
    let output = cocarry(&["replay", &file]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).contains("identical"));
    let changed = rewritten(&std::fs::read(&file).unwrap(), "\"threshold\":1.0", "\"threshold\":2.0");
    std::fs::write(&other, changed).unwrap();
    let output = cocarry(&["replay", &other]);
    assert_eq!(output.status.code(), Some(1));
    let said = stdout(&output);
    for part in ["in tick 0, at 0.0 s", "/coordination", "threshold", "recorded: 2.0", "run again: 1.0"] {
        assert!(said.contains(part), "{said}");
    }
    let output = cocarry(&["replay", "Cargo.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("Cargo.toml: is no MCAP file"));
}

/// Everything that the layout shows is recorded, under that name.
#[test]
fn the_layout_for_foxglove_asks_for_what_is_recorded() {
    let text = std::fs::read_to_string(repository("assets/foxglove/cocarry.json")).unwrap();
    let layout: Value = serde_json::from_str(&text).unwrap();
    let panels = layout["configById"].as_object().unwrap();
    let mut plotted = 0;
    for path in panels.values().flat_map(|p| p["paths"].as_array().into_iter().flatten()) {
        let (topic, fields) = path["value"].as_str().unwrap().split_once('.').expect("a topic and a field");
        let channel = Channel::of_topic(topic).unwrap_or_else(|| panic!("{topic}"));
        let mut schema: Value = serde_json::from_slice(&channel.schema().data).unwrap();
        for key in fields.split('.') {
            let name = key.split('[').next().unwrap();
            schema = schema["properties"][name].clone();
            if key.ends_with(']') {
                schema = schema["items"].clone();
            }
        }
        assert_eq!(schema["type"], "number", "{topic}.{fields}");
        plotted += 1;
    }
    assert!(plotted > 10);
    assert_eq!(panels["RosOut!log"]["topicToRender"], Channel::Log.topic());
    for topic in panels["3D!scene"]["topics"].as_object().unwrap().keys() {
        let channel = Channel::of_topic(topic).unwrap_or_else(|| panic!("{topic}"));
        assert_eq!(channel.schema().name, "foxglove.SceneUpdate");
    }
    let text = layout["layout"].to_string();
    assert!(panels.keys().all(|panel| text.contains(&format!("\"{panel}\""))), "every panel has a place");
}
