//! Files of others, damaged in every way that a few lines can think of: each is read or refused, in little
//! time, and never ends the program. `COCARRY_MUTANTS=20000` makes more of them than the suite has,
//! `COCARRY_SOAK_SECONDS=600` goes on for so long; with `COCARRY_READER=stl` of one kind only, with
//! `COCARRY_SEED=2` other ones.

use crate::hostile_meshes::{DAE, with_mesh};
use crate::recording::{encoded, example, rapier, unpacked};
use crate::spoiled_robot::TOML;
use cocarry::episode::EpisodeSettings;
use cocarry::geometry::Point;
use cocarry::human::{HumanDecision, Stance};
use cocarry::options::OptionSet;
use cocarry::robot::Robot;
use cocarry::scenario::{EpisodeLog, Plant, Scenario, Snapshot};
use cocarry::world::World;
use cocarry_maps::{Ends, from_map};
use cocarry_recording::recording::{Contents, Playback, ReadError, Reader, columns, recover, replay};
use cocarry_recording::rendering::{Width, filmstrip_svg, player};
use cocarry_studies::fit::{AnswerFile, SwitchFile};
use cocarry_studies::regression::Baseline;
use cocarry_studies::study::{Comparing, Results, Study, Summary, Sweep, SweepOutputs};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use std::sync::LazyLock;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// The longest time for a file of a few kilobytes.
const PATIENCE: Duration = Duration::from_secs(5);

/// Words that parsers trip over.
const WORDS: [&str; 16] = [
    "0",
    "-1",
    "1",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "1e39",
    "1e-39",
    "nan",
    "-inf",
    "",
    "<a>",
    "\"",
    "&#48;",
    "\n",
    "]]>",
];

/// A number from the environment.
fn asked(variable: &str) -> Option<u64> {
    let text = std::env::var(variable).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{variable}={text}: expected a number")))
}

/// A copy with one to four changes: of a byte, of a number or word, of a part that is left out, repeated, moved
/// or cut off.
fn mutant(seed: &[u8], rng: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..rng.random_range(1..5) {
        let length = bytes.len().max(1);
        let at = rng.random_range(0..length).min(bytes.len());
        let end = (at + rng.random_range(1..(length / 4).max(2))).min(bytes.len());
        match rng.random_range(0..8) {
            0 if at < bytes.len() => bytes[at] ^= 1 << rng.random_range(0..8),
            1 if at < bytes.len() => bytes[at] = rng.random_range(0..=255),
            // the word that stands here becomes another
            2..=4 => {
                let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b".-+_".contains(byte);
                let from = bytes[..at].iter().rposition(|byte| !is_word(byte)).map_or(0, |i| i + 1);
                let to = at + bytes[at..].iter().position(|byte| !is_word(byte)).unwrap_or(0);
                let word = WORDS[rng.random_range(0..WORDS.len())];
                bytes.splice(from..to.max(from), word.bytes());
            }
            5 => drop(bytes.drain(at..end)),
            6 => {
                let part = bytes[at..end].to_vec();
                let to = rng.random_range(0..=bytes.len());
                (0..rng.random_range(1..4)).for_each(|_| drop(bytes.splice(to..to, part.iter().copied())));
            }
            7 if rng.random_range(0..4) == 0 => bytes.truncate(at),
            _ => {}
        }
    }
    bytes
}

/// The time so far: that of the process, where this is all that it does and the system says, since others may
/// have the processor meanwhile.
fn clock() -> Duration {
    static BEGUN: LazyLock<Instant> = LazyLock::new(Instant::now);
    let is_alone =
        ["COCARRY_MUTANTS", "COCARRY_SOAK_SECONDS"].iter().any(|name| std::env::var_os(name).is_some());
    let of_process = || {
        let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
        let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
        let [user, system] = [fields.get(11)?, fields.get(12)?].map(|ticks| ticks.parse::<u64>());
        // of 10 ms
        Some(Duration::from_millis(10 * (user.ok()? + system.ok()?)))
    };
    is_alone.then(of_process).flatten().unwrap_or_else(|| BEGUN.elapsed())
}

/// Reads mutants of these files, and counts which are read and which are refused.
fn try_all(in_suite: usize, seeds: &[(&str, Vec<u8>)], mut reads: impl FnMut(&str, &[u8]) -> bool) {
    let wanted = std::env::var("COCARRY_READER").ok();
    let is_wanted = |seed: &&(&str, Vec<u8>)| wanted.as_ref().is_none_or(|wanted| wanted == seed.0);
    let seeds: Vec<_> = seeds.iter().filter(is_wanted).collect();
    if seeds.is_empty() {
        return;
    }
    let until = asked("COCARRY_SOAK_SECONDS").map(|seconds| clock() + Duration::from_secs(seconds));
    let mut rng = ChaCha8Rng::seed_from_u64(asked("COCARRY_SEED").unwrap_or(20_260_801));
    let (mut read, mut longest) = (0, Duration::ZERO);
    let asked = asked("COCARRY_MUTANTS").map_or(in_suite, |count| count as usize);
    let mut count = if until.is_some() { usize::MAX } else { asked };
    for i in 0.. {
        if i == count || i >= seeds.len() && until.is_some_and(|until| clock() > until) {
            count = i;
            break;
        }
        let (extension, seed) = seeds[i % seeds.len()];
        let bytes = if i < seeds.len() { seed.clone() } else { mutant(seed, &mut rng) };
        let begun = clock();
        let is_read = reads(extension, &bytes);
        let taken = clock().saturating_sub(begun);
        longest = longest.max(taken);
        assert!(taken < PATIENCE, "mutant {i} (.{extension}) takes {taken:?}");
        assert!(is_read || i >= seeds.len(), "seed {i} (.{extension}) is refused");
        read += usize::from(is_read);
    }
    if until.is_some() || count > in_suite {
        eprintln!("{}: {read} of {count} are read, in {longest:?} at most", seeds[0].0);
    }
    // seeds are read, and some mutants are not
    assert!(read >= seeds.len() && read < count, "{read} of {count} are read");
}

/// A tetrahedron as a binary STL.
pub fn binary_stl(claimed: u32) -> Vec<u8> {
    let corners = [[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.3]];
    let mut bytes = vec![b' '; 80];
    bytes.extend(claimed.to_le_bytes());
    for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        let numbers = [0.0; 3].into_iter().chain(face.into_iter().flat_map(|corner: usize| corners[corner]));
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
        bytes.extend([0, 0]);
    }
    bytes
}

const STL: &str = "solid a\nfacet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 .3 0\nvertex .3 0 0\nendloop\nendfacet\nfacet normal 0 -1 0\nouter loop\nvertex 0 0 0\nvertex .3 0 0\nvertex 0 0 .3\nendloop\nendfacet\nendsolid a\n";
const OBJ: &str = "mtllib a.mtl\no a\nv 0 0 0\nv .3 0 0 1\nv 0 .3 0\nv 0 0 .3\nvt 0 0\nvn 0 0 1\ng a\nusemtl b\nf 1/1/1 3/1/1 2/1/1\nf 1/1/1 2/1/1 4/1/1\ng b\nf -4/1/1 -1/1/1 -2/1/1\nf 2/1/1 3/1/1 4/1/1 1/1/1\n";

#[test]
fn meshes_that_are_damaged_are_read_or_refused() {
    let polygons = DAE.replace("<triangles count=\"4\">", "<polylist count=\"4\">");
    let polygons =
        polygons.replace("</triangles>", "</polylist>").replace("<p>", "<vcount>3 3 3 3</vcount><p>");
    let seeds = [
        ("stl", binary_stl(4)),
        ("stl", STL.as_bytes().to_vec()),
        ("obj", OBJ.as_bytes().to_vec()),
        ("dae", DAE.as_bytes().to_vec()),
        ("dae", polygons.into_bytes()),
    ];
    let folder = tempfile::tempdir().unwrap();
    try_all(500, &seeds, |extension, bytes| {
        let robot = with_mesh(folder.path(), &format!("mesh.{extension}"), bytes);
        let robot = robot.unwrap_or_else(|faults| panic!("{faults:?}"));
        !robot.warnings.iter().any(|warning| warning.to_string().contains("has no shape"))
    });
}

#[test]
fn urdfs_that_are_damaged_are_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let assets = crate::support::repository("assets/robots");
    std::fs::copy(assets.join(TOML), folder.path().join(TOML)).unwrap();
    let urdf = std::fs::read(assets.join("carrier.urdf")).unwrap();
    try_all(200, &[("urdf", urdf)], |_, bytes| {
        std::fs::write(folder.path().join("carrier.urdf"), bytes).unwrap();
        Robot::check(&folder.path().join(TOML)).is_ok()
    });
}

const SVG: &str = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 6 4' width='600' height='400'><style>.w { fill: #333 }</style><defs><g id='d'><rect x='2' y='1' width='.5' height='.5'/></g></defs><g id='walls' transform='translate(0 .1)'><path class='w' d='M0 0 H6 V.2 H0 Z M1 2.6 C1.5 2.2 2 2.2 2.5 2.6 L1.8 3 Z'/><use href='#d'/></g><line x1='3' y1='0' x2='3' y2='1.5' stroke='black' stroke-width='.1'/></svg>";
const PLAN: &str = "{\"type\":\"FeatureCollection\",\"features\":[{\"type\":\"Feature\",\"properties\":{\"name\":\"a\",\"height_m\":1.5},\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[[[2,1],[3,1],[3,2],[2,2],[2,1]]]}}]}";
const YAML: &str = "image: grid.pgm\nresolution: 0.1\norigin: [0.0, 0.0, 0.0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\n";

/// A map of 6 m by 4 m with an obstacle, as a graymap.
fn graymap() -> Vec<u8> {
    let mut bytes = b"P5\n60 40\n255\n".to_vec();
    let is_obstacle = |x: usize, y: usize| (20..25).contains(&x) && (10..15).contains(&y);
    bytes.extend((0..60 * 40).map(|i| if is_obstacle(i % 60, i / 60) { 0 } else { 254 }));
    bytes
}

#[test]
fn maps_that_are_damaged_are_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let ends = Ends {
        start: Point::new(0.8, 0.8),
        target: Point::new(5.0, 3.0),
        robot_width: None,
        tolerance: None,
    };
    let png = {
        let grey = resvg::tiny_skia::Pixmap::new(60, 40).map(|mut pixels| {
            pixels.fill(resvg::tiny_skia::Color::WHITE);
            pixels.encode_png().unwrap()
        });
        grey.unwrap()
    };
    let seeds = [
        ("svg", SVG.as_bytes().to_vec()),
        ("geojson", PLAN.as_bytes().to_vec()),
        ("yaml", YAML.as_bytes().to_vec()),
        ("pgm", graymap()),
        ("png", png),
    ];
    let read = |file: &Path| from_map(file, &ends).is_ok();
    try_all(400, &seeds, |extension, bytes| match extension {
        "pgm" | "png" => {
            std::fs::write(path(&format!("grid.{extension}")), bytes).unwrap();
            std::fs::write(path("grid.yaml"), YAML.replace("grid.pgm", &format!("grid.{extension}")))
                .unwrap();
            read(&path("grid.yaml"))
        }
        _ => {
            std::fs::write(path("grid.pgm"), graymap()).unwrap();
            std::fs::write(path(&format!("map.{extension}")), bytes).unwrap();
            read(&path(&format!("map.{extension}")))
        }
    });
}

/// What `inspect`, `recover`, `render` and `replay` do with a recording.
fn use_recording(bytes: &[u8], is_short: bool, folder: &Path) -> bool {
    let reader = || Reader::new(bytes, "m");
    let refused = |error: ReadError| {
        let said = error.to_string();
        assert!(said.starts_with("m: ") && said.len() < 10_000, "{said}");
    };
    let contents = reader().and_then(|mut reader| Contents::read(&mut reader));
    for topic in ["/options", "/tf", "/log"] {
        let _ = reader().and_then(|mut reader| columns(&mut reader, topic)).map_err(refused);
    }
    if let Ok(mut reader) = reader() {
        // more channels than a file can have are refused
        let _ = recover(&mut reader, &folder.join("out.mcap"), true);
    }
    if let Ok(playback) = reader().and_then(|mut reader| Playback::read(&mut reader)).map_err(refused) {
        let page = player(&playback, "m", None, "x").expect("a page");
        assert!(!page.contains("NaN") || !page.contains(":NaN"));
        if let Err(error) = filmstrip_svg(&playback, 3, Width::Inches(7.0)) {
            // a number of a step is missing
            assert!(error.to_string().contains("cannot be drawn: NaN"), "{error}");
        }
    }
    if is_short {
        let _ = reader().and_then(|first| replay(first, reader()?)).map_err(refused);
    }
    contents.is_ok()
}

#[test]
fn recordings_that_are_damaged_are_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let reference = |i: usize| {
        let file = crate::support::repository(&format!("recordings/environment-{i}.mcap"));
        std::fs::read(file).unwrap()
    };
    // what is run again is short: the reference recordings take a second each
    let short = |plant: Plant, limit: u64| {
        let scenario = example(plant);
        let settings = EpisodeSettings { tick_limit: Some(limit), ..scenario.settings };
        encoded(Scenario { settings, ..scenario }, |_| {}).0
    };
    let shorts = [
        short(Plant::Point, 12),
        short(Plant::Kinematic { setup: crate::recording::carrier() }, 3),
        short(rapier(), 2),
    ];
    let mut seeds: Vec<(&str, Vec<u8>)> = Vec::new();
    for (i, whole) in shorts.iter().enumerate() {
        seeds.push(("short", whole.clone()));
        seeds.push(("short", unpacked(whole)));
        seeds.push(("reference", if i == 1 { unpacked(&reference(i + 1)) } else { reference(i + 1) }));
    }
    seeds.push(("reference", unpacked(&reference(4))));
    try_all(100, &seeds, |kind, bytes| use_recording(bytes, kind == "short", folder.path()));
}

/// A study whose results are damaged.
const STUDY: &str = "worlds = [\"environment-1\"]\nplants = \"point\"\nmethods = [\"mutual\", \"without-model\"]\neta = [5, 10.5]\nhumans = \"a\"\nseeds = { first = 2, last = 3 }\nmax_steps = 2\n\n[[human]]\nname = \"a\"\nalpha = \"uniform(0.55,0.95)\"\ngamma = 0.8\n\n[[belief]]\nname = \"sharp\"\nalpha = \"normal(0.75,0.05,0.55,0.95)\"\ngamma = \"uniform(0.5,1.1)\"\n";

fn results(folder: &Path) -> Vec<u8> {
    let study = Study::parse("s", STUDY, Path::new(""), None).unwrap();
    let rows = folder.join("made.csv");
    let outputs = SweepOutputs { rows: &rows, ticks: None, overwrite: true };
    Sweep::open(&study, None, outputs).unwrap().run(&|| {}, &AtomicBool::new(false)).unwrap();
    std::fs::read(rows).unwrap()
}

/// A log of the page: two decisions of a human who leads to a place.
fn log(scenario: &Scenario) -> Vec<u8> {
    let human = HumanDecision {
        stance: Stance::TakeOver,
        hand: Some(Point::new(2.5, 1.0)),
        ..HumanDecision::following(1)
    };
    let log = serde_json::json!({
        "version": 1, "scenario": scenario.text().unwrap(), "arithmetic": cocarry::arithmetic::stamp(), "steps": 3,
        "decisions": { "human": [human, HumanDecision::following(0)] }, "digests": [[3, "0123456789abcdef"]], "outcome": "tick-limit",
    });
    log.to_string().into_bytes()
}

#[test]
fn texts_that_are_damaged_are_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let of = |name: &str| std::fs::read(crate::support::repository(name)).unwrap();
    std::fs::write(path("carrier.urdf"), of("assets/robots/carrier.urdf")).unwrap();
    let settings = EpisodeSettings { tick_limit: Some(3), ..EpisodeSettings::default() };
    let scenario = Scenario { settings, ..example(Plant::Point) };
    let seeds = [
        ("world", of("worlds/environment-4.toml")),
        ("world", of("worlds/free-form.toml")),
        ("robot", of("assets/robots/carrier.toml")),
        ("scenario", scenario.text().unwrap().into_bytes()),
        ("study", STUDY.as_bytes().to_vec()),
        ("baseline", of("tests/fixtures/regress/costs.toml")),
        ("answers", of("docs/data/simulated-answers.csv")),
        ("switches", of("docs/data/simulated-switches.csv")),
        ("rows", results(folder.path())),
        ("log", log(&scenario)),
        ("snapshot", {
            let prepared = scenario.clone().prepare().unwrap();
            let mut episode = prepared.episode().unwrap();
            episode.step();
            prepared.snapshot(&episode).bytes().unwrap()
        }),
    ];
    try_all(300, &seeds, |kind, bytes| {
        std::fs::write(path(kind), bytes).unwrap();
        let text = std::str::from_utf8(bytes).map_err(drop);
        let done = match kind {
            "world" => World::load(&path(kind)).map_err(drop).and_then(|world| {
                // options of many obstacles take their time
                if world.obstacles.len() < 30 {
                    OptionSet::new(&world, 10.0).map(drop).map_err(drop)
                } else {
                    Ok(())
                }
            }),
            "robot" => {
                std::fs::write(path(TOML), bytes).unwrap();
                Robot::check(&path(TOML)).map(drop).map_err(drop)
            }
            "scenario" => text.and_then(|text| {
                let scenario = Scenario::parse(text).map_err(drop)?;
                let again = Scenario::parse(&scenario.text().unwrap()).unwrap();
                assert!(again == scenario);
                scenario.prepare().map_err(drop)?.episode().map(drop).map_err(drop)
            }),
            "study" => {
                text.and_then(|text| Study::parse("s", text, folder.path(), None).map(drop).map_err(drop))
            }
            "baseline" => Baseline::load(&path(kind)).map(drop).map_err(drop),
            "answers" => AnswerFile::read(&path(kind)).map(drop).map_err(drop),
            "switches" => SwitchFile::read(&path(kind)).map(drop).map_err(drop),
            "rows" => {
                Summary::load(&[Results::File(&path(kind))], &Comparing::default()).map(drop).map_err(drop)
            }
            "log" => serde_json::from_slice::<EpisodeLog>(bytes).map_err(drop).and_then(|log| {
                let prepared = log.checked("log").and_then(|scenario| scenario.prepare()).map_err(drop)?;
                let mut episode = prepared.episode_of(log.decisions.partners(&prepared)).map_err(drop)?;
                let _ = (0..log.steps.min(5)).find(|_| episode.step().is_some());
                Ok(())
            }),
            _ => {
                // a right checksum, so that what is changed is looked at
                let mut bytes = bytes[..bytes.len().saturating_sub(4)].to_vec();
                bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
                Snapshot::parse("s", &bytes).map_err(drop).and_then(|Snapshot { scenario, state, .. }| {
                    let prepared = scenario.prepare().map_err(drop)?;
                    let mut episode = prepared.resume(state).map_err(drop)?;
                    let _ = (0..5).find(|_| episode.step().is_some());
                    Ok(())
                })
            }
        };
        done.is_ok()
    });
}
