//! The same bits on another kind of processor; and where the arithmetic is another all the same, that it is
//! told. (The report has its test in `reports`.)

use crate::support::{cocarry, cocarry_without_fma, json, repository, stderr, stdout};
use cocarry::arithmetic::stamp;

/// A stamp that no machine has.
fn other() -> String {
    let other = stamp().replace(|c: char| c.is_ascii_digit(), "f");
    if other == stamp() { "0".repeat(8) } else { other }
}

/// The same bytes with every stamp replaced.
fn restamped(bytes: &[u8]) -> Vec<u8> {
    let (ours, other) = (stamp().as_bytes(), other().into_bytes());
    let mut bytes = bytes.to_vec();
    let places: Vec<usize> =
        bytes.windows(ours.len()).enumerate().filter(|(_, w)| *w == ours).map(|(at, _)| at).collect();
    assert!(!places.is_empty(), "there is no stamp in it");
    for at in places {
        bytes[at..at + other.len()].copy_from_slice(&other);
    }
    bytes
}

/// As [`restamped`], for rows of results, whose checksums are right again.
fn restamped_rows(bytes: &[u8]) -> Vec<u8> {
    let text = String::from_utf8(restamped(bytes)).expect("UTF-8");
    let row = |line: &str| {
        let fields: Vec<&str> = line.splitn(6, ',').collect();
        let checksum = crc32fast::hash(format!("{},,{}", fields[..4].join(","), fields[5]).as_bytes());
        format!("{},{checksum:08x},{}", fields[..4].join(","), fields[5])
    };
    let lines = text.split_inclusive('\n').enumerate();
    lines.map(|(i, line)| if i == 0 { line.to_owned() } else { row(line) }).collect::<String>().into_bytes()
}

/// Asks for something on both kinds of processor; what was printed.
fn same_on_both(arguments: &[&str]) -> String {
    let [here, there] = [cocarry(arguments), cocarry_without_fma(arguments)];
    for output in [&here, &there] {
        assert!(output.status.success(), "{arguments:?}: {}{}", stdout(output), stderr(output));
    }
    assert!(here.stdout == there.stdout, "{arguments:?}: {}\n{}", stdout(&here), stdout(&there));
    stdout(&here)
}

#[test]
fn reference_recordings_replay_on_any_processor() {
    for number in 1..=4 {
        let told = same_on_both(&["replay", &format!("recordings/environment-{number}.mcap")]);
        assert!(told.contains("identical") && !told.contains("arithmetic"), "{told}");
    }
}

#[test]
fn runs_print_the_same_figures_on_any_processor() {
    same_on_both(&["run", "worlds/free-form.toml", "--seed", "3", "--json"]);
    same_on_both(&[
        "run",
        "environment-2",
        "--plant",
        "kinematic",
        "--method",
        "human-led",
        "--seed",
        "5",
        "--json",
    ]);
}

#[test]
fn a_sweep_over_all_plants_writes_the_same_file_on_any_processor() {
    let study = r#"name = "All plants"
worlds = ["environment-1", "environment-4"]
plants = ["point", "kinematic", "rapier"]
methods = ["mutual", "human-led"]
eta = 5
preference_changes = 1
seeds = 2
"#;
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    std::fs::write(path("study.toml"), study).expect("a study");
    let read = |name: &str| std::fs::read_to_string(path(name)).expect("results");
    let arguments = |out: &str| ["sweep".to_owned(), path("study.toml"), "--output".to_owned(), path(out)];
    for (run, out) in [(cocarry as fn(&[&str]) -> _, "here.csv"), (cocarry_without_fma, "there.csv")] {
        let arguments = arguments(out);
        let output = run(&arguments.each_ref().map(String::as_str));
        assert!(output.status.success(), "{}", stderr(&output));
    }
    let (here, there) = (read("here.csv"), read("there.csv"));
    let differing = here.lines().zip(there.lines()).filter(|(a, b)| a != b).count();
    assert!(here == there, "{differing} of {} rows differ", here.lines().count() - 1);
    assert_eq!(here.matches(stamp()).count(), 24);
}

#[test]
fn the_stamp_is_in_recordings_and_the_same_on_any_processor() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let (here, there) = (path("here.mcap"), path("there.mcap"));
    for (run, file) in [(cocarry as fn(&[&str]) -> _, &here), (cocarry_without_fma, &there)] {
        assert!(run(&["run", "--plant", "point", "--record", file]).status.success());
        assert_eq!(json(&["inspect", file, "--json"])["provenance"]["arithmetic"], stamp());
    }
    assert!(std::fs::read(here).expect("a recording") == std::fs::read(there).expect("a recording"));
}

/// A replay still compares every message, and says why it may differ.
#[test]
fn a_replay_tells_of_another_arithmetic() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("r.mcap");
    let name = file.to_str().expect("UTF-8");
    let replayed = |bytes: &[u8]| {
        std::fs::write(&file, bytes).expect("a recording");
        let output = cocarry(&["replay", name]);
        assert!(output.stderr.is_empty(), "{}", stderr(&output));
        (output.status.code(), stdout(&output))
    };
    let (_, ours) = (folder.path(), stamp());
    let told = [other(), ours.to_owned(), "the last bits".to_owned()];
    let short = crate::recording::unpacked(&crate::recording::short());
    let (code, said) = replayed(&short);
    assert!(code == Some(0) && !said.contains(ours), "{said}");
    let elsewhere = restamped(&short);
    let (code, said) = replayed(&elsewhere);
    assert!(code == Some(0) && told.iter().all(|part| said.contains(part)), "{said}");
    let mut changed = elsewhere.clone();
    let threshold = b"\"stubbornness_threshold\":1.0";
    let at = changed.windows(threshold.len()).position(|w| w == threshold).expect("a message");
    changed[at + threshold.len() - 3] = b'2';
    let (code, said) = replayed(&changed);
    assert!(code == Some(1) && said.contains("threshold"), "{said}");
    assert!(told.iter().all(|part| said.contains(part)), "{said}");
    // as earlier versions wrote them
    let mut silent = short.clone();
    let at = silent.windows(10).position(|w| w == b"arithmetic").expect("a stamp");
    silent[at] = b'A';
    let (code, said) = replayed(&silent);
    assert!(code == Some(0) && said.contains("does not name its arithmetic"), "{said}");
}

/// A snapshot of another arithmetic resumes with a warning, though not with the same bits.
#[test]
fn a_resumed_run_tells_of_another_arithmetic() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("s.snapshot");
    let name = file.to_str().expect("UTF-8");
    assert!(cocarry(&["run", "--plant", "point", "--save-at", "10", name]).status.success());
    let here = cocarry(&["run", "--resume", name]);
    assert!(here.status.success() && here.stderr.is_empty(), "{}", stderr(&here));
    let bytes = std::fs::read(&file).expect("a snapshot");
    let mut bytes = restamped(&bytes[..bytes.len() - 4]);
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    std::fs::write(&file, bytes).expect("a snapshot");
    let there = cocarry(&["run", "--resume", name]);
    assert!(there.status.success() && there.stdout == here.stdout);
    for part in ["warning: ", "s.snapshot", &other(), stamp()] {
        assert!(stderr(&there).contains(part), "{}", stderr(&there));
    }
}

#[test]
fn rows_of_another_arithmetic_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let study = repository("docs/studies/h2.toml");
    let study = study.to_str().expect("UTF-8");
    let sweep = |arguments: &[&str]| cocarry(&[&["sweep"], arguments].concat());
    for (shard, out) in [("1/2", "a.csv"), ("2/2", "b.csv")] {
        let output = sweep(&[study, "--seeds", "2", "--shard", shard, "--output", &path(out)]);
        assert!(output.status.success(), "{}", stderr(&output));
    }
    let refused = |arguments: &[&str], names: &[&str]| {
        let output = sweep(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
        for part in [names, &[&*other(), stamp(), "the last bits"]].concat() {
            assert!(stderr(&output).contains(part), "{part:?} is missing from: {}", stderr(&output));
        }
    };
    let read = |name: &str| std::fs::read(path(name)).expect("results");
    let (a, b) = (read("a.csv"), restamped_rows(&read("b.csv")));
    std::fs::write(path("b.csv"), &b).expect("results");
    refused(&["--merge", &path("all.csv"), &path("a.csv"), &path("b.csv")], &["b.csv", "a.csv"]);
    assert!(!folder.path().join("all.csv").exists());
    // two shards that agree are merged anywhere
    std::fs::write(path("a.csv"), restamped_rows(&a)).expect("results");
    let merged = sweep(&["--merge", &path("all.csv"), &path("a.csv"), &path("b.csv")]);
    assert!(merged.status.success(), "{}", stderr(&merged));
    // one file of two machines
    let rows = b.split_inclusive(|byte| *byte == b'\n').skip(1).collect::<Vec<_>>().concat();
    std::fs::write(path("mixed.csv"), [a.clone(), rows].concat()).expect("results");
    refused(&["--summary", &path("mixed.csv")], &["mixed.csv: line 38"]);
    // a sweep that was begun elsewhere
    std::fs::write(path("c.csv.partial"), restamped_rows(&a)).expect("results");
    let arguments = [study, "--seeds", "2", "--shard", "1/2", "--output", &path("c.csv")];
    refused(&arguments, &["c.csv.partial: line 2", "--overwrite"]);
    let anew = sweep(&[&arguments[..], &["--overwrite"]].concat());
    assert!(anew.status.success() && read("c.csv") == a, "{}", stderr(&anew));
}
