//! Recordings: written, read back, cut, damaged, recovered, run again.

mod crashes;
mod faults;
#[cfg(feature = "live")]
mod live;
mod replays;
mod written;

use crate::support::repository;
use cocarry::episode::{Episode, EpisodeSettings};
use cocarry::robot::Robot;
use cocarry::scenario::{Plant, RobotSetup, Scenario};
use cocarry::simulation::PhysicsSettings;
use cocarry::world::World;
use cocarry_recording::recording::{Definition, Encoder, Ending, Entry, Message, Reader, Recorder, decode};
use cocarry_studies::paper::EXAMPLE_HUMAN;
use serde_json::Value;
use std::io::Cursor;
use std::path::Path;

/// The human of the example in Environment 4.
pub fn example(plant: Plant) -> Scenario {
    let world = World::load(&repository("worlds/environment-4.toml")).expect("a world");
    let settings = EpisodeSettings::default();
    Scenario {
        seed: 1,
        world: world.into(),
        human: EXAMPLE_HUMAN,
        human_model: Default::default(),
        changes: Vec::new(),
        settings,
        plant,
    }
}

pub fn carrier() -> RobotSetup {
    let robot = Robot::built_in().expect("the built-in robot").into();
    RobotSetup { posture: "elbow-up".to_owned(), control: Default::default(), robot }
}

pub fn rapier() -> Plant {
    Plant::Rapier { setup: carrier(), physics: PhysicsSettings::default() }
}

/// A scenario's episode as a file, and as what it is told as; `on_step` sees the episode before the first
/// step and after each.
pub fn encoded(scenario: Scenario, mut on_step: impl FnMut(&Episode)) -> (Vec<u8>, Vec<Message>) {
    let prepared = scenario.prepare().expect("a scenario");
    let mut episode = prepared.episode().expect("room");
    let mut encoder = Encoder::new(&prepared);
    let mut messages = encoder.begin(&episode).to_vec();
    let file = Cursor::new(Vec::new());
    let mut recorder = Recorder::new(file, "memory", &prepared, &episode).expect("memory");
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
pub fn messages(bytes: &[u8]) -> Vec<(String, u64, Vec<u8>)> {
    let mut reader = Reader::new(bytes, "test").expect("an MCAP file");
    let mut messages = Vec::new();
    while let Some(entry) = reader.next().unwrap_or_else(|e| panic!("{e}")) {
        if let Some(m) = entry.message() {
            messages.push((m.channel.topic.clone(), m.time, m.data.to_vec()));
        }
    }
    messages
}

pub fn decoded(message: &Message) -> Value {
    decode(&Definition::of(message.channel), &message.data).expect("decodable")
}

pub fn path(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().expect("UTF-8").to_owned()
}

/// A short recording, of the point.
pub fn short() -> Vec<u8> {
    short_on(Plant::Point)
}

pub fn short_on(plant: Plant) -> Vec<u8> {
    let scenario = example(plant);
    let settings = EpisodeSettings { tick_limit: Some(12), ..scenario.settings };
    encoded(Scenario { settings, ..scenario }, |_| {}).0
}

pub fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

pub const MAGIC: &[u8] = b"\x89MCAP0\r\n";

pub fn chunk(size: u64, checksum: u32, compression: &str, packed: &[u8]) -> Vec<u8> {
    let name = [&(compression.len() as u32).to_le_bytes(), compression.as_bytes()].concat();
    let head = [&[0; 16][..], &size.to_le_bytes(), &checksum.to_le_bytes(), &name].concat();
    [MAGIC, &record(6, &[&head, &(packed.len() as u64).to_le_bytes()[..], packed].concat())].concat()
}

/// The same file with its chunks not packed and without checksums, so that what is wrong in them is not found
/// out at once.
pub fn unpacked(whole: &[u8]) -> Vec<u8> {
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

/// Where the chunks with messages begin.
pub fn chunks(whole: &[u8]) -> Vec<usize> {
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
