//! The bibliography of what an episode used.

use crate::support::{cocarry, repository, stderr, stdout};
use std::path::Path;

/// The keys of the entries, and what is said on standard error.
fn cited(arguments: &[&str]) -> (Vec<String>, String) {
    let output = cocarry(&[&["cite"], arguments].concat());
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    let text = stdout(&output);
    let heads = text.lines().filter_map(|line| line.strip_prefix('@'));
    let keys = heads.map(|head| head.split(['{', ',']).nth(1).expect("a key").to_owned()).collect();
    (keys, stderr(&output))
}

fn recorded(file: &Path, arguments: &[&str]) -> String {
    let file = file.to_str().expect("UTF-8");
    let output = cocarry(&[&["run", "environment-1", "--overwrite", "--record", file], arguments].concat());
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    file.to_owned()
}

const ALL: [&str; 2] = ["mahmud2025mutual", "cocarry"];
const PERCEPTION: [&str; 2] = ["prelec1998probability", "stevens1957psychophysical"];
const CONTROL: [&str; 3] = ["judice1994block", "lawson1995solving", "goulart2024clarabel"];

#[test]
fn without_a_recording_paper_and_program_are_cited() {
    assert_eq!(cited(&[]).0, ALL);
    let text = stdout(&cocarry(&["cite", "--format", "text"]));
    assert!(text.contains("arxiv.org/abs/2503.08895") && text.contains(env!("CARGO_PKG_VERSION")), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

#[test]
fn an_episode_cites_what_it_used() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let point = ["--plant", "point"];
    assert_eq!(cited(&[&recorded(&file, &point)]).0, [&ALL[..], &PERCEPTION].concat());
    for rational in [["--human", "boltzmann(2)"], ["--belief-rationality", "2"]] {
        let (keys, _) = cited(&[&recorded(&file, &[point, rational].concat())]);
        assert_eq!(keys, [&ALL[..], &PERCEPTION, &["mcfadden1974conditional"]].concat());
    }
    for (human, key) in [
        ("cvar(0.3)", "rockafellar2000optimization"),
        ("cumulative-prospect(0.88,0.69)", "tversky1992advances"),
    ] {
        let (keys, _) = cited(&[&recorded(&file, &[&point[..], &["--human", human]].concat())]);
        assert_eq!(keys, [&ALL[..], &PERCEPTION, &[key]].concat());
    }
    let kinematic = recorded(&file, &["--plant", "kinematic"]);
    assert_eq!(cited(&[&kinematic]).0, [&ALL[..], &PERCEPTION, &CONTROL, &["parry"]].concat());
    let (keys, said) = cited(&["recordings/environment-1.mcap"]);
    assert_eq!(keys, [&ALL[..], &PERCEPTION, &CONTROL, &["rapier", "parry"]].concat());
    assert!(!said.contains("robot"), "{said}");
}

#[test]
fn packages_have_the_versions_of_the_lock_file() {
    let lock = std::fs::read_to_string(repository("Cargo.lock")).unwrap();
    let text = stdout(&cocarry(&["cite", "recordings/environment-1.mcap", "--format", "csl"]));
    let items: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
    for (key, package) in
        [("rapier", "rapier3d-f64"), ("parry", "parry3d-f64"), ("goulart2024clarabel", "clarabel")]
    {
        let item = items.iter().find(|item| item["id"] == key).expect(key);
        let locked = format!("name = \"{package}\"\nversion = {}\n", item["version"]);
        assert!(lock.contains(&locked), "{locked}");
    }
}

#[test]
fn a_robot_of_others_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let name = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    for file in ["carrier.toml", "carrier.urdf"] {
        std::fs::copy(repository("assets/robots").join(file), name(file)).unwrap();
    }
    let urdf = std::fs::read_to_string(name("carrier.urdf")).unwrap();
    std::fs::write(name("carrier.urdf"), urdf.replace("<robot name=\"carrier\">", "<robot name=\"mine\">"))
        .unwrap();
    let robot = name("carrier.toml");
    let file = recorded(&folder.path().join("run.mcap"), &["--plant", "kinematic", "--robot", &robot]);
    let (_, said) = cited(&[&file]);
    assert!(said.contains("carrier.toml is not a built-in robot") && said.contains("carrier.urdf"), "{said}");
    assert_eq!(cited(&[&file, "-q"]).1, "");
}

#[test]
fn what_is_no_recording_is_refused() {
    for (arguments, parts) in [
        (&["cite", "no-such.mcap"][..], &["no-such.mcap: cannot be read"][..]),
        (&["cite", "worlds/environment-1.toml"], &["worlds/environment-1.toml", "is not an MCAP file"]),
        (&["cite", "--format", "ris"], &["ris", "bibtex, csl, text"]),
    ] {
        let output = cocarry(arguments);
        assert_eq!((output.status.code(), stdout(&output).as_str()), (Some(2), ""), "{arguments:?}");
        let said = stderr(&output);
        parts.iter().for_each(|part| assert!(said.contains(part), "{said}"));
    }
}
