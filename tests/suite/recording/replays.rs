//! A recording is run again, and what differs is named.

use super::{carrier, chunks, encoded, example, path, rapier, short, unpacked};
use crate::support::{cocarry, json, stderr, stdout};
use cocarry::episode::{EpisodeSettings, PreferenceChange};
use cocarry::policy::Method;
use cocarry::preference::Perception;
use cocarry::scenario::{Plant, Scenario};
use cocarry_recording::recording::{Reader, Verdict, recover, replay};

/// The same file with one of its messages rewritten.
fn rewritten(whole: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let mut bytes = unpacked(whole);
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).expect(from);
    bytes[at..at + from.len()].copy_from_slice(to.as_bytes());
    bytes
}

fn replayed(bytes: &[u8]) -> cocarry_recording::recording::Replay {
    replay(Reader::new(bytes, "m").unwrap(), Reader::new(bytes, "m").unwrap())
        .unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_recording_replays_to_the_last_message_on_every_plant() {
    for plant in [Plant::Point, Plant::Kinematic { setup: carrier() }, rapier()] {
        let (bytes, written) = encoded(example(plant), |_| {});
        let again = replayed(&bytes);
        assert_eq!(again.verdict, Verdict::Identical);
        assert_eq!(again.same, written.len() as u64);
    }
}

/// Changes of mind are in the scenario that a recording is made of, and told in its log: those that stand,
/// when they happen.
#[test]
fn a_human_who_changes_their_mind_replays_and_is_told() {
    let change = |step, alpha| PreferenceChange { step, perception: Perception { alpha, gamma: 1.1 } };
    for plant in [Plant::Point, Plant::Kinematic { setup: carrier() }, rapier()] {
        let scenario = example(plant);
        let settings =
            EpisodeSettings { method: Method::HUMAN_LED, tick_limit: Some(60), ..scenario.settings };
        let changes = vec![change(30, 0.5), change(10, 0.6), change(10, 0.95), change(60, 0.5)];
        let (bytes, written) = encoded(Scenario { settings, changes, ..scenario }, |_| {});
        let again = replayed(&bytes);
        assert_eq!((again.verdict, again.same), (Verdict::Identical, written.len() as u64));
        let folder = tempfile::tempdir().unwrap();
        let file = path(folder.path(), "r.mcap");
        std::fs::write(&file, &bytes).unwrap();
        let table = cocarry(&["inspect", &file, "--csv", "/log"]);
        assert!(table.status.success(), "{}", stderr(&table));
        let table = stdout(&table);
        let told: Vec<&str> = table.lines().filter(|line| line.contains("preferences change")).collect();
        assert_eq!(told.len(), 2, "{table}");
        assert!(told[0].starts_with("2,") && told[0].contains("alpha 0.9500, gamma 1.1000"), "{told:?}");
        assert!(told[1].starts_with("6,") && told[1].contains("alpha 0.5000, gamma 1.1000"), "{told:?}");
        assert!(told.iter().all(|line| line.contains("they prefer option")), "{told:?}");
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
    let told = json(&["replay", &file, "--json"]);
    assert!(told["verdict"] == "identical" && told["same_messages"].as_u64().unwrap() > 100, "{told}");
    let changed = rewritten(&std::fs::read(&file).unwrap(), "_threshold\":1.0", "_threshold\":2.0");
    std::fs::write(&other, changed).unwrap();
    let output = cocarry(&["replay", &other]);
    assert_eq!(output.status.code(), Some(1));
    let said = stdout(&output);
    for part in ["in tick 0, at 0.0 s", "/coordination", "threshold", "recorded: 2.0", "run again: 1.0"] {
        assert!(said.contains(part), "{said}");
    }
    let output = cocarry(&["replay", &other, "--json"]);
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((output.status.code(), &told["verdict"]), (Some(1), &"different".into()));
    assert_eq!(
        (&told["difference"]["topic"], &told["difference"]["step"]),
        (&"/coordination".into(), &0.into())
    );
    let output = cocarry(&["replay", "Cargo.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("Cargo.toml: is not an MCAP file"));
}
