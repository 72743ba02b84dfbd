//! Same inputs and seed, same bytes: in two processes, for any number of threads, from a clone.

use crate::support::{cocarry, json, load, repository};
use cocarry::episode::{Episode, EpisodeSettings};
use cocarry_studies::paper::EXAMPLE_HUMAN;

#[test]
fn two_processes_print_the_same_bytes() {
    let arguments = ["run", "worlds/free-form.toml", "--seed", "3", "--json"];
    let [first, second] = [cocarry(&arguments), cocarry(&arguments)];
    assert!(first.status.success());
    assert_eq!(first.stdout, second.stdout);
}

#[test]
fn the_number_of_threads_makes_no_difference() {
    let with_bodies = ["cycles", "--plant", "rapier", "--worlds", "3"];
    for claim in [&["h2"][..], &["cycles", "--worlds", "40"], &with_bodies] {
        let run = |threads| {
            let arguments = [&["reproduce"], claim, &["--json", "--threads", threads]].concat();
            json(&arguments)
        };
        assert_eq!(run("1"), run("3"));
    }
}

#[test]
fn another_seed_is_another_human() {
    let human = |seed| json(&["run", "--seed", seed, "--json"])["human"].clone();
    assert_eq!(human("1"), human("1"));
    assert_ne!(human("1"), human("2"));
}

#[test]
fn a_clone_goes_on_identically() {
    let (_, set) = load(&repository("worlds/environment-2.toml"));
    let settings = EpisodeSettings::default();
    let mut one = Episode::new(&set, &settings, EXAMPLE_HUMAN);
    for _ in 0..30 {
        assert_eq!(one.step(), None);
    }
    let mut other = one.clone();
    loop {
        let ended = one.step();
        assert_eq!(ended, other.step());
        // NaN marks what was not evaluated: compare as text
        assert_eq!(format!("{:?}", one.tick()), format!("{:?}", other.tick()));
        if ended.is_some() {
            break;
        }
    }
}
