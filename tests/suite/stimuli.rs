//! What participants of a study see: maps without figures, and a robot that leads on each option.

use crate::support::{cocarry, repository, stderr, stdout};
use cocarry::episode::{EpisodeSettings, Outcome};
use cocarry::policy::Method;
use cocarry::preference::Belief;
use cocarry::scenario::{GivenPerception, Plant, Scenario};
use cocarry::world::World;
use resvg::tiny_skia::Pixmap;
use std::collections::BTreeSet;
use std::path::Path;

/// The episode of a robot that leads on the option of that number, as a point.
fn led(world: &str, method: Method, number: u64) -> Scenario {
    let world = World::load(&repository(&format!("worlds/{world}.toml"))).expect("a world");
    let settings = EpisodeSettings { method, lead_option: Some(number), ..EpisodeSettings::default() };
    Scenario::of_seed(3, world.into(), Plant::Point, settings, &Belief::default(), GivenPerception::default())
}

#[test]
fn a_robot_leads_on_the_option_that_the_settings_prescribe() {
    for world in ["environment-1", "environment-2", "environment-3", "environment-4"] {
        let count = led(world, Method::ROBOT_LED, 1).prepare().expect("a scenario").options().options().len();
        for option in 0..count {
            let prepared = led(world, Method::ROBOT_LED, option as u64 + 1).prepare().expect("a scenario");
            let mut episode = prepared.episode().expect("an episode");
            while episode.step().is_none() {
                assert_eq!(episode.tick().executed, option, "{world}");
            }
            let summary = episode.summary();
            assert_eq!(summary.outcome, Outcome::Arrived, "{world}, option {option}");
            let set = prepared.options();
            let length = set.remaining(&set.begin(), option).length;
            assert!((summary.walked - length).abs() < 0.2, "{world}: {} m of {length}", summary.walked);
        }
    }
}

#[test]
fn the_human_may_still_take_the_lead_from_a_robot_with_a_prescribed_option() {
    let mut scenario = led("environment-4", Method::MUTUAL, 2);
    scenario.settings.coordination.eta = 2.0;
    let prepared = scenario.prepare().expect("a scenario");
    let mut episode = prepared.episode().expect("an episode");
    let mut executed = BTreeSet::new();
    while episode.step().is_none() {
        executed.insert((episode.tick().mode.name(), episode.tick().executed));
    }
    assert!(executed.contains(&("robot-led", 1)), "{executed:?}");
    assert!(executed.iter().any(|(mode, option)| *mode == "human-led" && *option != 1), "{executed:?}");
    assert!(!executed.iter().any(|(mode, option)| *mode == "robot-led" && *option != 1), "{executed:?}");
}

#[test]
fn an_option_that_the_world_does_not_have_is_refused() {
    let output = cocarry(&["run", "environment-4", "--plant", "point", "--lead-option", "5"]);
    assert_eq!(output.status.code(), Some(2));
    let error = stderr(&output);
    assert!(error.contains("settings.lead_option = 5") && error.contains("from 1 to 4"), "{error}");
}

/// Runs `cocarry stimuli` in an empty folder, which it returns.
fn stimuli(arguments: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let to = folder.path().to_str().expect("UTF-8");
    let output = cocarry(&[&["stimuli", "-o", to], arguments].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stdout(&output).contains("stimuli.csv"), "{}", stdout(&output));
    folder
}

fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).expect("a file")
}

#[test]
fn a_map_for_participants_has_no_name_and_no_figure_that_was_not_asked_for() {
    let plain = stimuli(&["environment-4", "environment-1", "--width", "640"]);
    let map = text(plain.path(), "environment-4.svg");
    for secret in ["risk", "width 0", "xi1", ">1<", "option", "probab"] {
        assert!(!map.contains(secret), "{secret}: {map}");
    }
    let picture = std::fs::read(plain.path().join("environment-1.png")).expect("a file");
    assert_eq!(Pixmap::decode_png(&picture).expect("a PNG").width(), 640);
    let named = stimuli(&["environment-4", "--show", "openings,options"]);
    let named = text(named.path(), "environment-4.svg");
    let letters: String =
        named.split('<').filter_map(|part| part.split_once('>')).map(|(_, text)| text).collect();
    for option in ["1", "2", "3", "4", "A", "B"] {
        assert!(letters.contains(option), "{option}: {letters}");
    }
    assert!(named.contains("xi") || named.contains("\u{3be}"), "{named}");
    assert!(!named.contains("risk"), "{named}");
}

#[test]
fn an_episode_for_participants_lasts_as_long_as_the_robot_walks() {
    let folder = stimuli(&["environment-1", "--episodes", "--plant", "kinematic", "--width", "320"]);
    let mut table = csv::Reader::from_path(folder.path().join("stimuli.csv")).expect("a table");
    let rows: Vec<_> = table
        .deserialize::<std::collections::BTreeMap<String, String>>()
        .map(|r| r.expect("a row"))
        .collect();
    let episodes: Vec<_> = rows.iter().filter(|row| row["file"].ends_with(".gif")).collect();
    assert!(episodes.len() > 1 && rows.len() == 2 * episodes.len() + 2, "{rows:?}");
    for row in episodes {
        let file = std::fs::File::open(folder.path().join(&row["file"])).expect("a file");
        let mut decoder = gif::DecodeOptions::new().read_info(file).expect("a GIF");
        let (mut hundredths, mut pictures) = (0.0, 0);
        while let Some(frame) = decoder.read_next_frame().expect("a GIF") {
            hundredths += f64::from(frame.delay);
            pictures += 1;
        }
        let number = |key: &str| row[key].parse::<f64>().expect("a number");
        let duration = number("steps") * number("planning_step_s");
        // the last picture stays for 2.5 s
        assert!((hundredths / 100.0 - 2.5 - duration).abs() < 0.3, "{hundredths}: {row:?}");
        assert!(f64::from(pictures) / duration > 4.0, "{pictures} pictures: {row:?}");
    }
}

#[test]
fn what_the_command_sets_itself_is_refused() {
    for (flag, value) in [("--method", "mutual"), ("--lead-option", "2")] {
        let output = cocarry(&["stimuli", "environment-1", "-o", ".", flag, value]);
        assert_eq!(output.status.code(), Some(2));
        let said = format!("error: {flag}: the robot leads on each option in turn; leave it out\n");
        assert_eq!(stderr(&output), said);
    }
}

#[test]
fn stimuli_of_two_worlds_of_one_name_are_refused_and_none_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let to = folder.path().to_str().expect("UTF-8");
    let output = cocarry(&["stimuli", "environment-1", "worlds/environment-1.toml", "-o", to]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("worlds/environment-1.toml: another world is called `environment-1`"),
        "{}",
        stderr(&output)
    );
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
}
