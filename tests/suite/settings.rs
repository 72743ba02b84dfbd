//! The table of settings: command line, studies, scenario texts and baselines take the same values and refuse
//! the others in the same words.

use crate::support::{cocarry, stderr};
use cocarry::robot::Robot;
use cocarry::scenario::{
    Plant, PlantKind, RobotSetup, SETTINGS, Scenario, Setting, SettingKind, Snapshot, Value,
};
use cocarry::world::World;
use cocarry_studies::study::Study;
use std::path::Path;

const WORLD: &str = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n";

fn scenario(plant: PlantKind) -> Scenario {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let world = World::parse("w.toml", WORLD).unwrap_or_else(|e| panic!("{e}"));
    Scenario::new(world.into(), Plant::new(plant, RobotSetup::new(&robot)))
}

fn list_key(setting: &Setting) -> String {
    let is_plural = ["method", "posture"].contains(&setting.key);
    format!("{}{}", setting.key, if is_plural { "s" } else { "" })
}

/// As in a TOML file.
fn toml(value: &Value) -> String {
    if let Value::Text(text) = value { format!("{text:?}") } else { value.to_string() }
}

/// What the four say of a value: command line, study, scenario text, baseline.
fn refusals(setting: &Setting, value: &Value) -> Vec<String> {
    let program = |arguments: &[&str]| {
        let output = cocarry(arguments);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        said.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let folder = tempfile::tempdir().expect("a folder");
    let baseline = folder.path().join("runs.toml");
    let run = format!("[[run]]\nworld = \"environment-1\"\n{} = {}\n", setting.flag, toml(value));
    std::fs::write(&baseline, run).expect("a file");
    let study =
        format!("worlds = \"environment-1\"\nplants = \"rapier\"\n{} = {}\n", list_key(setting), toml(value));
    let study = Study::parse("study.toml", &study, Path::new(""), None).expect_err(&study);
    let text = (!is_table(setting)).then(|| {
        let text = spoiled(setting, value);
        format!("{:#}", anyhow::Error::from(Scenario::parse(&text).expect_err(&text)))
    });
    let mut said = vec![
        program(&["run", &format!("--{}={value}", setting.flag)]),
        format!("{:#}", anyhow::Error::from(study)),
        program(&["regress", "check", baseline.to_str().expect("UTF-8")]),
    ];
    said.extend(text);
    said
}

/// Whether a scenario's text has a table in place of the word, or nothing.
fn is_table(setting: &Setting) -> bool {
    setting.key == "belief_update"
}

/// A scenario's text with that value, which it does not take.
fn spoiled(setting: &Setting, value: &Value) -> String {
    let mut scenario = scenario(PlantKind::Rapier);
    let current = match setting.get(&scenario) {
        // what is not there by default is not written
        _ if setting.key == "human_model" => Value::Text("boltzmann(1)".to_owned()),
        _ if setting.key.starts_with("belief_") => Value::Number(0.25),
        Some(Value::Text(text)) => Value::Text(text),
        _ => value.clone(),
    };
    setting.set(&mut scenario, &current);
    let text = scenario.text().unwrap_or_else(|e| panic!("{e}"));
    let key = setting.path.rsplit('.').next().expect("a key");
    let line = |value: &Value| format!("\n{key} = {}\n", toml(value));
    if current == *value {
        return text;
    }
    assert_eq!(text.matches(&line(&current)).count(), 1, "{key}:\n{text}");
    text.replace(&line(&current), &line(value))
}

#[test]
fn property_what_a_setting_does_not_take_is_refused_in_the_same_words_everywhere() {
    let mut looked_at = 0;
    for setting in SETTINGS {
        let bad = match setting.kind {
            SettingKind::Number(..) => Value::Number(2_000_000.5),
            SettingKind::Count(..) => Value::Count(2_000_000_000),
            SettingKind::Word(..) | SettingKind::Text(..) => Value::Text("nonsense".to_owned()),
            SettingKind::Flag(_) => continue,
        };
        if setting.accepts(&bad) {
            assert_eq!(setting.key, "posture", "only the robot knows its postures");
            continue;
        }
        let expected = match setting.words() {
            Some(words) => words.iter().map(|(word, _)| (*word).to_owned()).collect(),
            // a scenario's text is read by another parser than the rest, which says the same forms
            None if setting.key == "human_model" => vec!["boltzmann(RATIONALITY)".to_owned()],
            None => vec![setting.expected().to_string()],
        };
        for said in refusals(setting, &bad) {
            for expected in &expected {
                assert!(said.contains(expected), "{}: {expected:?} is missing from: {said}", setting.key);
            }
        }
        looked_at += 1;
    }
    assert!(looked_at >= 15, "{looked_at}");
}

#[test]
fn every_word_is_the_one_of_scenario_texts() {
    for setting in SETTINGS {
        for (word, _) in setting.words().unwrap_or_default() {
            let (mut scenario, value) = (scenario(PlantKind::Rapier), Value::Text(word.to_owned()));
            setting.set(&mut scenario, &value);
            let text = scenario.text().unwrap_or_else(|e| panic!("{e}"));
            let key = setting.path.rsplit('.').next().expect("a key");
            let is_there = text.contains(&format!("\n{key} = {word:?}\n"));
            assert!(is_there || is_table(setting), "{key} = {word:?}:\n{text}");
            let again = Scenario::parse(&text).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(setting.get(&again), Some(value));
        }
    }
}

/// A value that is not the default.
fn another(setting: &Setting, defaults: &Scenario) -> Value {
    let default = setting.get(defaults);
    let words = setting.words().unwrap_or_default().into_iter().map(|(word, _)| word);
    let texts = ["0.7", "0.03", "2", "400", "5000", "true", "boltzmann(0.5)", "elbow-out"];
    // from the last, so that there are candidates
    let words: Vec<&str> = words.rev().collect();
    let texts = if words.is_empty() { texts.to_vec() } else { words };
    let texts = match setting.key {
        "posture" => vec!["elbow-out"],
        // as fast as the robot can, or slower
        "speed_m_per_s" => vec!["0.4"],
        // an option that every world has
        "lead_option" => vec!["1"],
        // a whole fraction of the planning step and of another one
        "control_period_s" => vec!["0.05"],
        _ => texts,
    };
    let found =
        texts.iter().filter_map(|text| setting.parse(text).ok()).find(|v| Some(v) != default.as_ref());
    found.unwrap_or_else(|| panic!("no other value for {}", setting.key))
}

#[test]
fn every_setting_is_the_same_on_the_command_line_in_scenarios_and_in_studies() {
    let defaults = scenario(PlantKind::Rapier);
    for plant in [PlantKind::Kinematic, PlantKind::Rapier] {
        // on the physical plant, what is of bodies alone: the rest was seen already
        let is_shown = |setting: &&Setting| {
            // a robot that learns does not take it
            let fits = setting.key != "belief_rationality";
            let is_of_plant = setting.key == "max_steps"
                || setting.applies.is_on(PlantKind::Kinematic, true) == (plant == PlantKind::Kinematic);
            fits && is_of_plant
        };
        let settings: Vec<(&Setting, Value)> =
            SETTINGS.iter().filter(is_shown).map(|setting| (setting, another(setting, &defaults))).collect();
        let folder = tempfile::tempdir().expect("a folder");
        let file = |name: &str| folder.path().join(name).display().to_string();
        let mut arguments =
            ["run", "environment-1", "--plant", plant.name(), "--save-at", "0", &file("snapshot")]
                .map(str::to_owned)
                .to_vec();
        let mut study = format!("worlds = \"environment-1\"\nplants = \"{}\"\nseeds = 1\n", plant.name());
        for (setting, value) in &settings {
            match value {
                Value::Flag(_) => arguments.push(format!("--{}", setting.flag)),
                value => arguments.push(format!("--{}={value}", setting.flag)),
            }
            study += &format!("{} = {}\n", list_key(setting), toml(value));
        }
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let output = cocarry(&arguments);
        assert_eq!(output.status.code(), Some(3), "two steps: {}", stderr(&output));
        let scenario =
            Snapshot::load(Path::new(&file("snapshot"))).unwrap_or_else(|e| panic!("{e}")).scenario;
        let text = scenario.text().unwrap_or_else(|e| panic!("{e}"));
        let scenario = Scenario::parse(&text).unwrap_or_else(|e| panic!("{e}"));
        std::fs::write(file("study.toml"), &study).expect("a study");
        let swept = cocarry(&["sweep", &file("study.toml"), "--output", &file("out.csv")]);
        assert!(swept.status.success(), "{}", stderr(&swept));
        let mut rows = csv::Reader::from_path(file("out.csv")).expect("rows");
        let headers = rows.headers().expect("headings").clone();
        let row = rows.records().next().expect("a row").expect("a row");
        for (setting, value) in &settings {
            assert_eq!(setting.get(&scenario).as_ref(), Some(value), "{}", setting.key);
            let column = headers.iter().position(|name| name == setting.key).expect(setting.key);
            assert_eq!(row[column], value.to_string(), "{}", setting.key);
        }
    }
}

#[test]
fn a_digest_knows_every_value_the_worlds_and_the_seeds_and_no_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let digest = |world: &str, study: &str| {
        std::fs::write(folder.path().join("w.toml"), world).expect("a world");
        let study = format!("worlds = \"w.toml\"\nplants = \"kinematic\"\n{study}\n");
        let study =
            Study::parse("study.toml", &study, folder.path(), None).unwrap_or_else(|e| panic!("{e:?}"));
        study.digest().to_owned()
    };
    let plain = digest(WORLD, "");
    assert_eq!(plain, digest(WORLD, "name = \"another\"\nnote = \"and more\""));
    let mut digests = vec![plain, digest(&WORLD.replace("[9, 0]", "[9, 1]"), "")];
    digests.extend(["seeds = 2", "preference_changes = 1"].map(|study| digest(WORLD, study)));
    let human = "[[human]]\nname = \"paper\"\nalpha = \"uniform(0.55,0.95)\"\ngamma = 0.8";
    digests.extend(
        [human, &human.replace("human", "belief").replace("0.8", "\"uniform(0.5,1)\"")]
            .map(|s| digest(WORLD, s)),
    );
    let defaults = scenario(PlantKind::Rapier);
    for setting in SETTINGS.iter().filter(|setting| setting.applies.is_on(PlantKind::Kinematic, true)) {
        let value = another(setting, &defaults);
        digests.push(digest(WORLD, &format!("{} = {}", list_key(setting), toml(&value))));
    }
    let n = digests.len();
    digests.sort_unstable();
    digests.dedup();
    assert_eq!(digests.len(), n, "two studies of one digest");
}
