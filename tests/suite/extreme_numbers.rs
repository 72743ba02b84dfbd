//! Every number of a world, a robot file, a URDF and a study, in turn replaced by ones that break programs: the
//! file is refused in words, or what is made of it has numbers.

use crate::recording::{carrier, example};
use crate::spoiled_robot::{TOML, URDF, original};
use crate::support::repository;
use cocarry::episode::{EpisodeSettings, prospects};
use cocarry::options::OptionSet;
use cocarry::robot::Robot;
use cocarry::scenario::{Plant, Scenario};
use cocarry::world::World;
use cocarry_studies::study::Study;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

/// Numbers as TOML writes them, and what looks like one.
const EXTREMES: [&str; 20] = [
    "nan",
    "-nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e999999999",
    "5e-324",
    "1e-300",
    "-0.0",
    "0",
    "-1",
    "9223372036854775807",
    "99999999999999999999",
    "0x7fffffffffffffff",
    "1_0",
    "1979-05-27T07:32:00Z",
    "9999-12-31",
    "true",
    "[]",
];

/// The places of the numbers of a text, behind these characters.
fn numbers(text: &str, behind: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let (mut at, mut before) = (0, ' ');
    while let Some(c) = text[at..].chars().next() {
        let is_begin =
            c.is_ascii_digit() || c == '-' && text[at + 1..].starts_with(|c: char| c.is_ascii_digit());
        if is_begin && behind.contains(before) {
            let is_part = |c: char| c.is_ascii_digit() || ".-+eE".contains(c);
            let end = text[at..].find(|c| !is_part(c)).map_or(text.len(), |length| at + length);
            found.push(at..end);
            (at, before) = (end, '0');
        } else {
            (at, before) = (at + c.len_utf8(), c);
        }
    }
    found
}

/// Calls `read` with the text with each of its numbers replaced, by all extremes or some. Counts what is read.
fn each_number(text: &str, behind: &str, some: usize, mut read: impl FnMut(&str) -> Result<(), String>) {
    let mut rng = ChaCha8Rng::seed_from_u64(38);
    let places = numbers(text, behind);
    assert!(places.len() > 5, "{}", places.len());
    let (mut good, mut refused) = (0, 0);
    for place in places {
        for extreme in EXTREMES.sample(&mut rng, some) {
            let extreme = if rng.random_bool(0.01) { "1e6" } else { extreme };
            let changed = format!("{}{extreme}{}", &text[..place.start], &text[place.end..]);
            let begun = Instant::now();
            match read(&changed) {
                Ok(()) => good += 1,
                Err(said) => {
                    refused += 1;
                    assert!(!said.is_empty() && said.len() < 10_000 && !said.contains("panicked"), "{said}");
                }
            }
            let line = text[..place.start].lines().last().unwrap_or_default();
            assert!(begun.elapsed() < crate::support::time_for(5), "{line}{extreme}: {:?}", begun.elapsed());
        }
    }
    assert!(good > 0 && refused > 0, "{good} are read, {refused} are refused");
}

/// An episode in a scenario goes three steps, and every coordinate is a number.
fn walks(scenario: Scenario) -> Result<(), String> {
    let settings = EpisodeSettings { tick_limit: Some(3), ..scenario.settings };
    let prepared = Scenario { settings, ..scenario }.prepare().map_err(|error| error.to_string())?;
    let mut episode = prepared.episode().map_err(|error| error.to_string())?;
    while episode.step().is_none() {
        let tick = episode.tick();
        let is_number = tick.position.iter().all(|x| x.is_finite());
        assert!(is_number, "{:?}", tick.position);
    }
    Ok(())
}

#[test]
fn property_every_number_of_a_world_is_checked() {
    for name in ["environment-4", "free-form"] {
        let text = std::fs::read_to_string(repository(&format!("worlds/{name}.toml"))).unwrap();
        each_number(&text, " [,=", 4, |text| {
            let world = World::parse("w.toml", text).map_err(|error| error.to_string())?;
            let set = OptionSet::new(&world, 10.0).map_err(|error| error.to_string())?;
            assert!(prospects(&set, &set.begin()).iter().all(|option| option.length.is_finite()));
            walks(Scenario { world: world.into(), ..example(Plant::Point) })
        });
    }
}

fn words(errors: &[cocarry::Error]) -> String {
    errors.iter().map(|error| format!("{error}\n")).take(20).collect()
}

/// A robot of these files walks.
fn robot(folder: &Path) -> Result<(), String> {
    let robot = Robot::check(&folder.join(TOML)).map_err(|errors| words(&errors))?;
    let setup = cocarry::scenario::RobotSetup { robot: robot.into(), ..carrier() };
    walks(example(Plant::Kinematic { setup }))
}

#[test]
fn property_every_number_of_a_robot_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(URDF), original(URDF)).unwrap();
    each_number(&original(TOML), " [,=", 6, |text| {
        std::fs::write(folder.path().join(TOML), text).unwrap();
        robot(folder.path())
    });
    std::fs::write(folder.path().join(TOML), original(TOML)).unwrap();
    each_number(&original(URDF), " \"", 1, |text| {
        std::fs::write(folder.path().join(URDF), text).unwrap();
        robot(folder.path())
    });
}

#[test]
fn property_every_number_of_a_study_is_checked() {
    let study = "worlds = \"environment-1\"\nplants = [\"point\", \"rapier\"]\nseeds = { first = 2, last = 5 }\nmax_steps = 5\neta = [5, 10.5]\nrisk_weight_m = 10\nplanning_step_s = 0.2\nsway_m = 0.02\ninitial_stubbornness = 0.1\n\n[[human]]\nname = \"a\"\nalpha = 0.7\ngamma = 0.8\n";
    Study::parse("s.toml", study, Path::new(""), None).expect("a study");
    each_number(study, " [,=", 20, |text| {
        let study = Study::parse("s.toml", text, Path::new(""), None).map_err(|error| error.to_string())?;
        assert!(study.episodes() > 0);
        Ok(())
    });
}
