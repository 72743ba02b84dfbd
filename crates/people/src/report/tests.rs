//! Tests of what the tables have for a report.

use crate::collect::collect;
use crate::order::{Trial, orders};
use crate::store::StoredSession;
use crate::study::{PeopleStudy, TEMPLATE};
use serde_json::json;

/// The study of the template with the task `carry`, and the scale `robot` after every carry.
fn study() -> PeopleStudy {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("study.toml");
    let carry = "[carry]\nmethods = [\"mutual\", \"robot-led\"]\ntext = \"Carry.\"\n\n[end]";
    let text = TEMPLATE
        .replace("tasks = [\"percentages\", \"switch\"]", "tasks = [\"carry\"]")
        .replace("name = \"robot\"", "name = \"robot\"\nafter = \"carry\"")
        .replace("[end]", carry);
    std::fs::write(&file, text).unwrap();
    PeopleStudy::read(&file).unwrap()
}

#[test]
fn a_scale_after_carries_is_asked_after_each_and_its_answers_name_world_and_method() {
    let study = study();
    let robot = study.scales.iter().position(|scale| scale.name == "robot").unwrap();
    let pages = &orders(&study)[0];
    let carries: Vec<usize> =
        (0..pages.len()).filter(|at| matches!(pages[*at], Trial::Carry { practice: false, .. })).collect();
    // two worlds, two methods
    assert_eq!(carries.len(), 4);
    assert!(carries.iter().all(|at| pages[at + 1] == Trial::Scale { scale: robot }));
    let scales = pages.iter().filter(|page| matches!(page, Trial::Scale { .. })).count();
    assert_eq!(scales, 4 + 1, "and the other one at the end");

    let scale = |name: &str| {
        vec![
            serde_json::from_value(
                json!({ "kind": "done", "data": { "task": "scale", "name": name, "answers": [["one", 3]] } }),
            )
            .unwrap(),
        ]
    };
    let mut records: Vec<_> = carries.iter().map(|at| (*at as u32 + 1, scale("robot"))).collect();
    records.push((pages.len() as u32 - 1, scale("workload")));
    let session = |participant: &str, place: u64, finished: Option<&str>| StoredSession {
        participant: participant.to_owned(),
        place,
        study: "x".to_owned(),
        begun: "t".to_owned(),
        finished: finished.map(str::to_owned),
        records: records.clone(),
    };
    let sessions = [session("p1", 0, Some("t")), session("p2", 2, None)];
    let collected = collect(&study, &sessions, false);
    let table = |name: &str| {
        let (_, bytes) = collected.files.iter().find(|(other, _)| other == name).unwrap();
        String::from_utf8(bytes.clone()).unwrap()
    };
    let responses = table("responses.csv");
    let expected: Vec<String> = carries
        .iter()
        .map(|at| match pages[*at] {
            Trial::Carry { world, method, .. } => {
                format!("p1,robot,one,3,,{},{method}", study.worlds[world].name)
            }
            _ => unreachable!("a carry"),
        })
        .chain(["p1,workload,one,3,,,".to_owned()])
        .collect();
    assert_eq!(responses.lines().skip(1).collect::<Vec<_>>(), expected);
    // who left is known, with the page
    let participants = table("participants.csv");
    let left = participants.lines().find(|line| line.starts_with("p2,")).unwrap();
    assert!(left.ends_with(&format!(",0,{},,", pages[5].words(&study))), "{left}");
}
