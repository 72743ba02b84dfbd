//! The seeds of each reader: sound files, small, with chunks that are not packed and no checksums.

use crate::maps::{YAML, graymap};
use cocarry::episode::EpisodeSettings;
use cocarry::human::{HumanDecision, Stance};
use cocarry::scenario::{Plant, Scenario};
use cocarry::world::World;
use cocarry_recording::recording::{Ending, Recorder};
use cocarry_studies::study::{Study, Sweep, SweepOutputs};
use std::io::Cursor;
use std::path::Path;
use std::sync::atomic::AtomicBool;

const SVG: &str = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 6 4' width='600' height='400'><style>.w { fill: #333 }</style><defs><g id='d'><rect x='2' y='1' width='.5' height='.5'/></g><marker id='m'><path d='M0 0H1'/></marker></defs><g id='walls' transform='translate(0 .1)'><path class='w' d='M0 0 H6 V.2 H0 Z M1 2.6 C1.5 2.2 2 2.2 2.5 2.6 L1.8 3 Z'/><use href='#d'/></g><line x1='3' y1='0' x2='3' y2='1.5' stroke='black' stroke-width='.1' marker-end='url(#m)'/></svg>";
const PLAN: &str = "{\"type\":\"FeatureCollection\",\"features\":[{\"type\":\"Feature\",\"properties\":{\"name\":\"a\",\"height_m\":1.5},\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[[[2,1],[3,1],[3,2],[2,2],[2,1]]]}}]}";
const STL: &str = "solid a\nfacet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 .3 0\nvertex .3 0 0\nendloop\nendfacet\nfacet normal 0 -1 0\nouter loop\nvertex 0 0 0\nvertex .3 0 0\nvertex 0 0 .3\nendloop\nendfacet\nendsolid a\n";
const OBJ: &str = "mtllib a.mtl\no a\nv 0 0 0\nv .3 0 0 1\nv 0 .3 0\nv 0 0 .3\nvt 0 0\nvn 0 0 1\ng a\nusemtl b\nf 1/1/1 3/1/1 2/1/1\nf 1/1/1 2/1/1 4/1/1\ng b\nf -4/1/1 -1/1/1 -2/1/1\nf 2/1/1 3/1/1 4/1/1 1/1/1\n";
const STUDY: &str = "worlds = [\"environment-1\", \"environment-4\"]\nplants = \"point\"\nmethods = [\"mutual\", \"without-model\"]\neta = [5, 10.5]\nhumans = [\"all\", \"same\"]\nseeds = 2\nmax_steps = 2\n\n[[human]]\nname = \"all\"\nalpha = \"uniform(0.55,0.95)\"\ngamma = \"uniform(0.5,1.1)\"\n\n[[human]]\nname = \"same\"\nalpha = 0.747\ngamma = 0.765\n\n[[belief]]\nname = \"sharp\"\nalpha = \"normal(0.75,0.05,0.55,0.95)\"\ngamma = \"uniform(0.5,1.1)\"\n";

/// A scenario of a point.
fn scenario() -> Scenario {
    let world = World::find(Path::new("environment-4"), "environment-4").expect("a world");
    let settings = EpisodeSettings { tick_limit: Some(3), ..EpisodeSettings::default() };
    Scenario { seed: 1, world: world.into(), settings, plant: Plant::Point, ..Scenario::defaults() }
}

/// A log of the page: a human who leads to a place, then follows.
fn log() -> String {
    let leads = HumanDecision { stance: Stance::TakeOver, hand: Some([2.5, 1.0].into()), ..HumanDecision::following(1) };
    let decisions = serde_json::json!({ "human": [leads, HumanDecision::following(0)] });
    let log = serde_json::json!({
        "version": 1, "scenario": scenario().text().expect("a scenario"), "steps": 2, "decisions": decisions,
    });
    log.to_string()
}

fn recording() -> Vec<u8> {
    let prepared = scenario().prepare().expect("a scenario");
    let mut episode = prepared.episode().expect("room");
    let file = Cursor::new(Vec::new());
    let mut recorder = Recorder::new(file, "memory", &prepared, &episode).expect("memory");
    let outcome = loop {
        if let Some(outcome) = episode.step() {
            break outcome;
        }
        recorder.step(&episode).expect("memory");
    };
    unpacked(&recorder.finish(&episode, Ending::Over(outcome)).expect("memory").into_inner())
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

/// The same file with its chunks not packed and without checksums.
fn unpacked(whole: &[u8]) -> Vec<u8> {
    let mut bytes = whole[..8].to_vec();
    let mut rest = &whole[8..whole.len() - 8];
    while !rest.is_empty() {
        let length = u64::from_le_bytes(rest[1..9].try_into().expect("8 bytes")) as usize;
        let (opcode, body) = (rest[0], &rest[9..9 + length]);
        rest = &rest[9 + length..];
        match opcode {
            6 => {
                let records = zstd::bulk::decompress(&body[44..], 1 << 20).expect("a chunk");
                let size = (records.len() as u64).to_le_bytes();
                bytes.extend(record(6, &[&[0; 16][..], &size, &[0; 4], &[0; 4], &size, &records].concat()));
            }
            15 => bytes.extend(record(15, &[0; 4])),
            2 => bytes.extend(record(2, &[&body[..16], &[0; 4]].concat())),
            9 => bytes.extend(record(9, &[&body[..body.len() - 4], &[0; 4]].concat())),
            _ => bytes.extend(record(opcode, body)),
        }
    }
    bytes.extend(&whole[..8]);
    bytes
}

/// What is in a snapshot, behind its header and before its checksum.
fn snapshot(plant: Plant) -> Vec<u8> {
    let prepared = Scenario { plant, ..scenario() }.prepare().expect("a scenario");
    let mut episode = prepared.episode().expect("room");
    episode.step();
    let bytes = prepared.snapshot(&episode).bytes().expect("a snapshot");
    bytes[16 + 4 + 1 + usize::from(bytes[20]) + 8..bytes.len() - 4].to_vec()
}

/// Results of a study.
fn results(folder: &Path, name: &str) -> Vec<u8> {
    let study = Study::parse("s", STUDY, Path::new(""), None).expect("a study");
    let rows = folder.join(name);
    let outputs = SweepOutputs { rows: &rows, ticks: None, overwrite: true };
    let sweep = Sweep::open(&study, None, outputs).expect("a sweep");
    sweep.run(&|| {}, &AtomicBool::new(false)).expect("rows");
    std::fs::read(rows).expect("rows")
}

/// A tetrahedron as a binary STL.
fn binary_stl() -> Vec<u8> {
    let corners = [[0.0_f32, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.3]];
    let mut bytes = vec![b' '; 80];
    bytes.extend(4_u32.to_le_bytes());
    for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        let numbers = [0.0; 3].into_iter().chain(face.into_iter().flat_map(|corner: usize| corners[corner]));
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
        bytes.extend([0, 0]);
    }
    bytes
}

/// Writes the seeds of a reader that are made; those that are files of the repository are given by `soak`.
pub fn write(reader: &str, folder: &Path) {
    let seeds: Vec<Vec<u8>> = match reader {
        "columns" => vec![results(folder, "made.parquet")],
        "rows" => vec![results(folder, "made.csv")],
        "drawing" => vec![SVG.into()],
        "plan" => vec![PLAN.into()],
        "grid" => vec![YAML.into()],
        "image" => vec![graymap(), b"P2\n3 1\n255 0 205 254\n".to_vec()],
        "log" => vec![log().into()],
        "obj" => vec![OBJ.into()],
        "stl" => vec![STL.into(), binary_stl()],
        "study" => vec![STUDY.into()],
        "recording" | "playback" | "replay" => vec![recording()],
        "scenario" => vec![scenario().text().expect("a scenario").into()],
        "snapshot" => vec![snapshot(Plant::Point)],
        _ => Vec::new(),
    };
    for (i, seed) in seeds.iter().enumerate() {
        std::fs::write(folder.join(format!("made-{i}")), seed).expect("a place for seeds");
    }
}
