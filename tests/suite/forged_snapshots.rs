//! Snapshots with changed numbers and a right checksum: refused, or resumed to some end, without a panic and
//! without a hang.

use crate::support::{cocarry, repository, stderr};
use cbor4ii::core::Value;
use cbor4ii::serde::{from_slice, to_vec};
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::process::Command;

/// A snapshot's bytes before its contents, and its contents. Saved parts are CBOR within CBOR.
pub fn opened(bytes: &[u8]) -> (&[u8], Value) {
    let begin = 16 + 4 + 1 + usize::from(bytes[20]) + 8;
    (&bytes[..begin - 8], unfolded(from_slice(&bytes[begin..bytes.len() - 4]).unwrap()))
}

/// The tag (of this file alone) of bytes that are CBOR themselves.
const FOLDED: u64 = 0x636f;

fn unfolded(value: Value) -> Value {
    match value {
        Value::Bytes(bytes) => match from_slice(&bytes) {
            Ok(inner) if !bytes.is_empty() => Value::Tag(FOLDED, Box::new(unfolded(inner))),
            _ => Value::Bytes(bytes),
        },
        Value::Array(items) => Value::Array(items.into_iter().map(unfolded).collect()),
        Value::Map(items) => Value::Map(items.into_iter().map(|(k, v)| (k, unfolded(v))).collect()),
        other => other,
    }
}

fn folded(value: Value) -> Value {
    match value {
        Value::Tag(FOLDED, inner) => Value::Bytes(to_vec(Vec::new(), &folded(*inner)).unwrap()),
        Value::Array(items) => Value::Array(items.into_iter().map(folded).collect()),
        Value::Map(items) => Value::Map(items.into_iter().map(|(k, v)| (k, folded(v))).collect()),
        other => other,
    }
}

/// A snapshot with these contents and the right length and checksum.
pub fn closed(head: &[u8], contents: Value) -> Vec<u8> {
    sealed(head, &to_vec(Vec::new(), &folded(contents)).unwrap())
}

fn sealed(head: &[u8], inner: &[u8]) -> Vec<u8> {
    let mut bytes = [head, &(inner.len() as u64).to_le_bytes(), inner].concat();
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

/// Calls `act` with every number, flag and list, and its path.
fn each(value: &mut Value, path: &str, act: &mut dyn FnMut(&str, &mut Value)) {
    match value {
        Value::Tag(FOLDED, inner) => each(inner, path, act),
        Value::Map(items) => {
            for (key, value) in items {
                let key = match key {
                    Value::Text(key) => key.clone(),
                    other => format!("{other:?}"),
                };
                each(value, &format!("{path}.{key}"), act);
            }
        }
        Value::Array(items) => {
            for (i, value) in items.iter_mut().enumerate() {
                each(value, &format!("{path}[{i}]"), act);
            }
        }
        number => act(path, number),
    }
}

/// Another value of the same kind, of those that break programs.
fn extreme(value: &Value, rng: &mut ChaCha8Rng) -> Option<Value> {
    let floats = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, 1e9, -1e9, 0.0, 5e-324];
    let whole =
        [0, 1, -1, 7, 1 << 16, (1 << 31) - 1, (1 << 32) - 1, i128::from(i64::MAX), i128::from(u64::MAX)];
    match value {
        Value::Float(x) => Some(Value::Float(if rng.random_bool(0.2) { -x } else { *floats.choose(rng)? })),
        Value::Integer(_) => Some(Value::Integer(*whole.choose(rng)?)),
        Value::Bool(flag) => Some(Value::Bool(!flag)),
        _ => None,
    }
}

/// A snapshot with one to three changed numbers, and what was changed.
fn forged(bytes: &[u8], rng: &mut ChaCha8Rng) -> (Vec<u8>, String) {
    let (head, mut contents) = opened(bytes);
    let mut said = String::new();
    let mut count = 0;
    // groups of values with the same path but for indices, so that lists do not drown the rest
    let mut groups = std::collections::BTreeMap::<String, Vec<usize>>::new();
    each(&mut contents, "", &mut |path, value| {
        if matches!(value, Value::Float(_) | Value::Integer(_) | Value::Bool(_)) {
            let group: String = path.split(['[', ']']).step_by(2).collect();
            groups.entry(group).or_default().push(count);
        }
        count += 1;
    });
    let groups: Vec<_> = groups.into_values().collect();
    let changed: Vec<usize> =
        (0..rng.random_range(1..4)).map(|_| *groups.choose(rng).unwrap().choose(rng).unwrap()).collect();
    let mut at = 0;
    each(&mut contents, "", &mut |path, value| {
        if changed.contains(&at)
            && let Some(other) = extreme(value, rng)
        {
            said += &format!("{path}: {value:?} -> {other:?}; ");
            *value = other;
        }
        at += 1;
    });
    (closed(head, contents), said)
}

/// Forges snapshots of an episode on this plant, three steps before its end, and resumes each in a process.
/// Returns the exit codes.
fn resumed(plant: &str, seeds: std::ops::Range<u64>) -> Vec<Option<i32>> {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let run = |arguments: &[&str], file: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cocarry"));
        command.arg("run").args(arguments).arg(path(file)).current_dir(repository(".")).output().unwrap()
    };
    let steps = ["--eta", "5", "--max-steps", "43", "--save-at", "40"];
    assert_eq!(
        run(&[&["environment-4", "--plant", plant][..], &steps].concat(), "good").status.code(),
        Some(3)
    );
    let good = std::fs::read(path("good")).unwrap();
    let (head, contents) = opened(&good);
    assert!(closed(head, contents) == good, "a snapshot without changes is the same");
    let codes = seeds.map(|seed| {
        let (bytes, changes) = forged(&good, &mut ChaCha8Rng::seed_from_u64(seed));
        std::fs::write(path("forged"), bytes).unwrap();
        let output = run(&["--resume"], "forged");
        let (code, said) = (output.status.code(), stderr(&output));
        assert!(matches!(code, Some(0 | 2 | 3)), "{plant}, seed {seed}: {code:?}: {said}\n{changes}");
        assert!(!said.contains("panicked") && said.len() < 10_000, "{plant}, seed {seed}: {said}\n{changes}");
        assert!(code != Some(2) || said.contains("forged"), "{plant}, seed {seed}: {said}\n{changes}");
        code
    });
    codes.collect()
}

#[test]
fn property_forged_snapshots_are_refused_or_end() {
    for (plant, count) in [("point", 30), ("kinematic", 40), ("rapier", 80)] {
        let codes = resumed(plant, 0..count);
        for code in [2, 3] {
            assert!(codes.contains(&Some(code)), "{plant}: {codes:?}");
        }
    }
}

/// Numbers that would have the physics engine work without end, and one on which it panics.
#[test]
fn a_forged_state_of_the_physics_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (good, bad) = (path("good"), path("bad"));
    assert_eq!(cocarry(&["run", "--max-steps", "6", "--save-at", "5", &good]).status.code(), Some(3));
    let good = std::fs::read(good).unwrap();
    for (end, value, words) in [
        (".additional_solver_iterations", Value::Integer(1 << 40), "its plant does not match"),
        (".num_internal_pgs_iterations", Value::Integer(1 << 40), "its plant does not match"),
        (".plant.settings.rate_hz", Value::Float(1e18), "its plant does not match"),
        (
            ".broad_phase.tree.nodes[0].left.children",
            Value::Integer(65_536),
            "not consistent: the simulation fails",
        ),
    ] {
        let (head, mut contents) = opened(&good);
        let mut changed = 0;
        each(&mut contents, "", &mut |path, old| {
            if path.ends_with(end) {
                *old = value.clone();
                changed += 1;
            }
        });
        assert!(changed > 0, "{end}");
        std::fs::write(&bad, closed(head, contents)).unwrap();
        let output = cocarry(&["run", "--resume", &bad]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{end}: {said}");
        assert!(said.contains(words) && said.contains("bad") && !said.contains("panicked"), "{end}: {said}");
    }
}

#[test]
fn contents_that_are_not_those_of_a_snapshot_are_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (good, bad) = (path("good"), path("bad"));
    assert_eq!(cocarry(&["run", "--max-steps", "6", "--save-at", "5", &good]).status.code(), Some(3));
    let good = std::fs::read(good).unwrap();
    let (head, contents) = opened(&good);
    let Value::Map(mut fields) = contents else { panic!("a snapshot is a map") };
    let scenario = fields.swap_remove(0);
    assert_eq!(scenario.0, Value::Text("scenario".to_owned()));
    for (contents, words) in [
        (Value::Map(fields), "decode error: missing field `scenario`"),
        (Value::Bool(true), "unexpected type bool at position 0: expected map"),
        (Value::Map(vec![(scenario.0, Value::Null)]), "unexpected type null at position 10: expected map"),
    ] {
        std::fs::write(&bad, closed(head, contents)).unwrap();
        let output = cocarry(&["run", "--resume", &bad]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains(&format!(
                "not a valid snapshot, written by cocarry {}: {words}\n",
                env!("CARGO_PKG_VERSION")
            )),
            "{said}"
        );
    }
}

/// The hull of a mesh may be a list of points or a list of such lists; which one is asked of the items.
#[test]
fn a_list_that_is_nested_too_deep_is_refused() {
    const PLACE: &str = "the place of a list";
    fn add_hulls(value: &mut Value) {
        match value {
            Value::Map(items) => {
                items.iter_mut().for_each(|(_, value)| add_hulls(value));
                if items.iter().any(|(key, _)| *key == Value::Text("urdf_file".to_owned())) {
                    items.retain(|(key, _)| *key != Value::Text("hulls".to_owned()));
                    let mesh = (Value::Text("m".to_owned()), Value::Text(PLACE.to_owned()));
                    items.push((Value::Text("hulls".to_owned()), Value::Map(vec![mesh])));
                }
            }
            Value::Array(items) => items.iter_mut().for_each(add_hulls),
            _ => {}
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (good, bad) = (path("good"), path("bad"));
    assert_eq!(cocarry(&["run", "--max-steps", "6", "--save-at", "5", &good]).status.code(), Some(3));
    let good = std::fs::read(good).unwrap();
    let (head, mut contents) = opened(&good);
    add_hulls(&mut contents);
    let inner = to_vec(Vec::new(), &folded(contents)).unwrap();
    let at = inner.windows(PLACE.len()).position(|window| window == PLACE.as_bytes()).expect("a robot");
    for (depth, words) in [(30, "not a valid snapshot"), (1_000_000, "nested deeper than 64")] {
        let (before, after) = (&inner[..at - 1], &inner[at + PLACE.len()..]);
        let deep = [before, &vec![0x81; depth], &[0x80], after].concat();
        std::fs::write(&bad, sealed(head, &deep)).unwrap();
        let output = cocarry(&["run", "--resume", &bad]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{depth}: {said}");
        assert!(said.contains(words), "{depth}: {said}");
    }
}

/// For long: `COCARRY_FUZZ_SECONDS=600 cargo test --test suite forging_for_long -- --ignored`.
#[test]
#[ignore = "runs as long as it is told to"]
fn forging_for_long() {
    let seconds = std::env::var("COCARRY_FUZZ_SECONDS").ok().and_then(|s| s.parse().ok()).unwrap_or(10);
    let begun = std::time::Instant::now();
    let mut seed = 1000;
    while begun.elapsed() < std::time::Duration::from_secs(seconds) {
        for plant in ["point", "kinematic", "rapier", "rapier"] {
            resumed(plant, seed..seed + 20);
            seed += 20;
        }
    }
    println!("{} snapshots", seed - 1000);
}
