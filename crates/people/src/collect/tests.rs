//! Tests of the tables.

use super::*;
use crate::simulate::simulate;
use crate::site::{Sink, Site};
use crate::store::Store;
use crate::study::TEMPLATE;
use serde_json::{Map, json};

fn study(folder: &std::path::Path) -> PeopleStudy {
    let file = folder.join("study.toml");
    std::fs::write(&file, TEMPLATE).unwrap();
    PeopleStudy::read(&file).unwrap()
}

fn file<'a>(collected: &'a Collected, name: &str) -> &'a str {
    let (_, bytes) = collected.files.iter().find(|(other, _)| other == name).unwrap();
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn simulated_participants_are_collected_whole() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path());
    let mut store = Store::open(&folder.path().join("s.sqlite")).unwrap();
    let site = Site::new(&study, Sink::Server, None).unwrap();
    let truths = simulate(&study, &site.digest, &mut store, 5, 1).unwrap();
    // again, nothing changes
    assert_eq!(simulate(&study, &site.digest, &mut store, 5, 1).unwrap().len(), 5);
    let collected = collect(&study, &store.sessions().unwrap(), false);
    assert_eq!((collected.participants, collected.left_out.len()), (5, 0));
    let lines = |name| file(&collected, name).lines().count();
    // two worlds of four options
    assert_eq!([lines("answers.csv"), lines("switches.csv"), lines("participants.csv")], [41, 41, 6]);
    assert_eq!(lines("responses.csv"), 1 + 5 * (2 + 6 + 2));
    assert!(truths.iter().all(|truth| file(&collected, "answers.csv").contains(&truth.participant)));
    assert!(file(&collected, "README.md").contains("A mouse is not a beam"));
}

#[test]
fn a_forged_answer_is_left_out_and_named_and_a_formula_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path());
    let record = |data: Value| -> Map<String, Value> {
        serde_json::from_value(json!({ "kind": "done", "data": data })).unwrap()
    };
    let percentages = |world: &str, percent: Value| {
        record(
            json!({ "task": "percentages", "world": world, "practice": false, "percent": percent, "ms": 10.0, "hidden_ms": 0.0 }),
        )
    };
    let switch = |option: &str, step: u64| {
        record(
            json!({ "task": "switch", "world": "environment-1", "option": option, "practice": false, "repetition": 1, "step": step,
            "ms": 1.0, "frame": 1, "plays": 1, "stalls": 0, "longest_frame_ms": 20.0 }),
        )
    };
    let whole = json!([["1", 10], ["2", 20], ["3", 30], ["4", 40]]);
    let records = vec![
        percentages("environment-1", whole.clone()),
        percentages("environment-1", whole.clone()),
        percentages("environment-4", json!([["1", 90], ["2", 20], ["3", 0], ["4", 0]])),
        percentages("elsewhere", whole),
        switch("1", 3),
        switch("2", 1_000_000),
        switch("9", 3),
        record(json!({ "task": "scale", "name": "=cmd()", "answers": [["=1+1", 3]] })),
        record(json!({ "task": "teapot" })),
    ];
    let session = StoredSession {
        participant: "p1".to_owned(),
        place: 0,
        study: "x".to_owned(),
        begun: "t".to_owned(),
        finished: None,
        records: (0..).zip(records.into_iter().map(|record| vec![record])).collect(),
    };
    let collected = collect(&study, std::slice::from_ref(&session), false);
    assert_eq!((collected.participants, &*collected.left_out), (0, &["1 who did not finish".to_owned()][..]));
    let collected = collect(&study, &[session], true);
    let said =
        ["second answer", "sum to 110", "not a world", "step 1000000", "not an option", "not a record"];
    assert_eq!(collected.left_out.len(), said.len(), "{:?}", collected.left_out);
    for (line, said) in collected.left_out.iter().zip(said) {
        assert!(line.contains(said), "{line}: {said}");
    }
    assert_eq!(file(&collected, "answers.csv").lines().count(), 5);
    assert_eq!(file(&collected, "switches.csv").lines().nth(1), Some("p1,environment-1,1,3,1,1,1,0,1"));
    assert!(file(&collected, "responses.csv").contains("p1,'=cmd(),'=1+1,3,"));
    assert!(file(&collected, "participants.csv").lines().nth(1).unwrap().contains("left-out"));
}
