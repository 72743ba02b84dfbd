//! Tests of study files.

use super::*;
use cocarry::Error;
use cocarry::error::words;

fn read(text: &str) -> Result<PeopleStudy, Error> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("study.toml");
    std::fs::write(&file, text).unwrap();
    PeopleStudy::read(&file)
}

#[test]
fn the_template_is_a_study() {
    let study = read(TEMPLATE).unwrap();
    assert_eq!(study.tasks, [Task::Percentages, Task::Switch]);
    assert_eq!((study.worlds.len(), study.practice_world()), (3, Some(2)));
    assert_eq!(study.worlds[0].options, ["1", "2", "3", "4"]);
    assert_eq!(study.questions.len() + study.scales.len(), 4);
}

#[test]
fn an_error_has_its_place_its_value_and_what_would_be_right() {
    for (right, wrong, said) in [
        ("participants = 20 ", "participants = 0 ", ["participants = 0", "from 1 to 100000"]),
        ("tasks = [\"percentages\", \"switch\"]", "tasks = []", ["tasks = []", "\"percentages\""]),
        ("\"environment-4\"", "\"environment-9\"", ["worlds = \"environment-9\"", "environment-4"]),
        ("\"environment-4\"", "\"environment-1\"", ["worlds = \"environment-1\"", "no other world"]),
        ("right = 2 ", "right = 4 ", ["right = 4", "from 1 to 3"]),
        ("attempts = 3", "attempts = 0", ["attempts = 0", "from 1 to 10"]),
        ("points = 7", "points = 1", ["points = 1", "from 2 to 11"]),
        (
            "eta_groups = [5.0, 10.5",
            "eta_groups = [5.0, 4.0",
            ["eta_groups = [5.0, 4.0", "larger than the one before"],
        ),
        ("# trials = 2", "trials = 0", ["trials = 0", "from 1 to 10"]),
        ("kind = \"likert\"", "kind = \"fluency\"", ["kind", "has its own statements"]),
        ("# code = \"C0FFEE\"", "code = \"<b>\"", ["end.code", "letters, digits"]),
        ("title = ", "titel = ", ["titel", "title"]),
        ("version = \"1\"", "version = \"\"", ["version", "1 to 200 characters"]),
    ] {
        assert!(TEMPLATE.contains(right), "{right}");
        let error = read(&TEMPLATE.replacen(right, wrong, 1)).unwrap_err();
        let text = words(&error);
        assert!(text.contains("study.toml") && said.iter().all(|part| text.contains(part)), "{text}");
    }
}

#[test]
fn an_option_that_is_longer_and_riskier_than_another_is_dominated() {
    let mut world = read(TEMPLATE).unwrap().worlds.swap_remove(0);
    world.prospects =
        [(10.0, 0.5), (12.0, 0.6), (12.0, 0.5), (14.0, 0.2)].map(|(l, r)| Prospect::new(l, r)).to_vec();
    let dominated: Vec<_> = (0..4).map(|option| world.is_dominated(option)).collect();
    assert_eq!(dominated, [false, true, false, false]);
}
