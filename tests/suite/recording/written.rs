//! What is in a recording is what happened, under the names that are documented.

use super::{carrier, decoded, encoded, example, messages, path, rapier};
use crate::support::{cocarry, json, repository, stderr, stdout};
use cocarry::episode::Tick;
use cocarry::geometry::Pose;
use cocarry::robot::Robot;
use cocarry::scenario::Plant;
use cocarry_recording::recording::{Channel, Contents, Definition, Encoder, Message, Reader};
use jsonschema::Validator;
use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use serde_json::Value;
use std::collections::BTreeMap;

#[test]
fn what_is_read_is_what_was_written() {
    let (bytes, written) = encoded(example(rapier()), |_| {});
    let read = messages(&bytes);
    assert_eq!(read.len(), written.len());
    for (read, written) in read.iter().zip(&written) {
        assert_eq!((&*read.0, read.1, &read.2), (written.channel.topic(), written.time, &written.data));
    }
    assert!(written.windows(2).all(|w| w[0].time <= w[1].time), "time runs forward");
    let contents = Contents::read(&mut Reader::new(&bytes[..], "test").unwrap()).unwrap();
    assert_eq!(contents.provenance["seed"], "1");
    assert_eq!(contents.outcome.expect("an outcome")["outcome"], "arrived");
    // of omnidirectional bases and robots that learn only
    let others = [Channel::Base, Channel::Learned];
    for channel in Channel::ALL.into_iter().filter(|channel| !others.contains(channel)) {
        assert!(contents.channels[channel.topic()].messages > 0, "{channel:?}");
    }
}

/// A message for every change of the belief, with its figures; its density means the same over the grid.
#[test]
fn what_the_robot_learns_of_the_human_is_recorded_as_it_changes() {
    let mut scenario = example(Plant::Point);
    scenario.settings.learning = Some(Default::default());
    let mut last = None;
    let (bytes, _) = encoded(scenario, |episode| last = episode.learner().cloned());
    let learned: Vec<Value> = messages(&bytes)
        .iter()
        .filter(|(topic, ..)| topic == "/learned")
        .map(|(_, _, data)| serde_json::from_slice(data).expect("JSON"))
        .collect();
    assert!(learned.len() > 20, "{}", learned.len());
    let numbers = |human: &Value, key: &str| -> Vec<f64> {
        human[key].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let mut shares = Vec::new();
    for message in &learned {
        let human = &message["human"];
        let density = numbers(human, "density");
        assert_eq!(density.len(), 32 * 32);
        let [alphas, gammas] = ["alpha_range", "gamma_range"].map(|key| numbers(human, key));
        let total: f64 = density.iter().sum();
        let middle = |range: &[f64], i: usize| range[0] + (range[1] - range[0]) * (i as f64 + 0.5) / 32.0;
        let mean = |of: &dyn Fn(usize) -> f64| {
            density.iter().enumerate().map(|(cell, d)| d * of(cell)).sum::<f64>() / total
        };
        let [alpha, gamma] =
            [mean(&|cell| middle(&alphas, cell / 32)), mean(&|cell| middle(&gammas, cell % 32))];
        for (key, on_grid) in [("alpha_mean", alpha), ("gamma_mean", gamma)] {
            let exact = human[key].as_f64().unwrap();
            assert!((exact - on_grid).abs() < 0.01, "{key}: {exact}, on the grid {on_grid}");
        }
        shares.push(human["region_share"].as_f64().unwrap());
    }
    let mut learner = last.expect("a robot that learns");
    let estimate = learner.perception_mut().estimate();
    let human = &learned.last().unwrap()["human"];
    assert_eq!(human["alpha_variance"], estimate.covariance[0]);
    assert_eq!(human["eta_mean"], learner.tolerance().moments()[0]);
    assert!(shares[shares.len() - 1] < 0.6 * shares[0], "{shares:?}");
}

/// The poses of a `/tf` message's frames in the world. Every frame has one parent, which comes before it.
fn frames_in_the_world(message: &Value) -> BTreeMap<String, Pose> {
    let mut known = BTreeMap::from([("world".to_owned(), Pose::identity())]);
    for t in message["transforms"].as_array().unwrap() {
        let numbers = |part: &str, keys: &[&str]| -> Vec<f64> {
            keys.iter().map(|key| t[part][key].as_f64().unwrap()).collect()
        };
        let at = numbers("translation", &["x", "y", "z"]);
        let q = numbers("rotation", &["w", "x", "y", "z"]);
        let q = Quaternion::new(q[0], q[1], q[2], q[3]);
        assert!((q.norm() - 1.0).abs() < 1e-12, "{t}: a quaternion of length {}", q.norm());
        let turned = UnitQuaternion::new_unchecked(q);
        let pose = Pose::from_parts(Translation3::new(at[0], at[1], at[2]), turned.to_rotation_matrix());
        let [parent, child] = ["parent_frame_id", "child_frame_id"].map(|key| t[key].as_str().unwrap());
        let above = known.get(parent).unwrap_or_else(|| panic!("{child} is below an unknown {parent}"));
        let pose = above * pose;
        assert!(known.insert(child.to_owned(), pose).is_none(), "{child} has two parents");
    }
    known
}

/// A viewer without a layout draws a line from every frame to its parent: three lines from the origin, to
/// robot, object and human, and theirs.
#[test]
fn frames_are_a_tree_of_robot_object_and_human_in_which_every_shape_has_its_frame() {
    let robot = Robot::built_in().unwrap();
    for plant in [Plant::Kinematic { setup: carrier() }, rapier()] {
        let (_, written) = encoded(example(plant), |_| {});
        let first = |channel: Channel| decoded(written.iter().find(|m| m.channel == channel).unwrap());
        let frames = first(Channel::Transforms);
        let known = frames_in_the_world(&frames);
        let parent = |frame: &str| -> String {
            let all = frames["transforms"].as_array().unwrap();
            let found =
                all.iter().find(|t| t["child_frame_id"] == frame).unwrap_or_else(|| panic!("{frame}"));
            found["parent_frame_id"].as_str().unwrap().to_owned()
        };
        for link in &robot.links {
            let above = link.parent.map_or("odom".to_owned(), |p| format!("robot/{}", robot.links[p].name));
            assert_eq!(parent(&format!("robot/{}", link.name)), above);
        }
        for (frame, above) in
            [("odom", "world"), ("object", "world"), ("human", "world"), ("human/left_foot", "human")]
        {
            assert_eq!(parent(frame), above);
        }
        let team = first(Channel::Team);
        let shapes: Vec<&str> =
            team["entities"].as_array().unwrap().iter().map(|e| e["frame_id"].as_str().unwrap()).collect();
        assert!(shapes.iter().all(|frame| known.contains_key(*frame)), "{shapes:?}");
        for part in ["human", "human/left_thigh", "human/right_shin", "human/left_upper_arm", "object"] {
            assert!(shapes.contains(&part), "no {part}");
        }
        // the feet are on the floor, the head is a head higher than the shoulders
        for message in written.iter().filter(|m| m.channel == Channel::Transforms) {
            let poses = frames_in_the_world(&decoded(message));
            let height = |frame: &str| poses[frame].translation.z;
            let feet = [height("human/left_foot"), height("human/right_foot")];
            assert!(feet.iter().any(|z| (z - 0.075).abs() < 1e-3), "one foot is down: {feet:?}");
            assert!((height("human/left_upper_arm") - 1.36).abs() < 1e-3);
        }
    }
}

/// Frames, joints and figures say what the episode says.
#[test]
fn frames_and_figures_are_those_of_the_episode() {
    let mut seen: Vec<(u64, Vec<Pose>, [Pose; 3], f64)> = Vec::new();
    let mut ticks: Vec<Tick> = Vec::new();
    let (_, written) = encoded(example(rapier()), |episode| {
        let o = episode.observation().expect("physics");
        let bodies = [o.object, o.hand, o.torso];
        let links = episode.link_poses().expect("a robot");
        seen.push(((o.time * 1e9).round() as u64, links, bodies, o.hand_grip.mean.force.z));
        if seen.len() > 1 {
            ticks.push(episode.tick().clone());
        }
    });
    let robot = Robot::built_in().unwrap();
    let of = |channel: Channel| written.iter().filter(move |m| m.channel == channel);
    assert_eq!(of(Channel::Transforms).count(), seen.len());
    for (message, (time, links, bodies, _)) in of(Channel::Transforms).zip(&seen) {
        assert!(message.time.abs_diff(*time) < 1000);
        let poses = frames_in_the_world(&decoded(message));
        let is_at = |frame: &str, pose: &Pose| {
            let found = poses.get(frame).unwrap_or_else(|| panic!("{frame}")).translation.vector;
            assert!((found - pose.translation.vector).norm() < 1e-12, "{frame}: {found}");
        };
        for (link, pose) in robot.links.iter().zip(links) {
            is_at(&format!("robot/{}", link.name), pose);
        }
        for (frame, pose) in ["object", "human/hand", "human/torso"].iter().zip(bodies) {
            is_at(frame, pose);
        }
    }
    for (message, (_, _, _, force)) in of(Channel::Interaction).zip(&seen[1..]) {
        assert_eq!(decoded(message)["hand_mean_force_z_n"].as_f64(), Some(*force));
    }
    for (message, tick) in of(Channel::Coordination).zip(&ticks) {
        let value = decoded(message);
        assert_eq!(value["stubbornness"].as_f64(), Some(tick.stubbornness));
        assert_eq!(value["x_m"].as_f64(), Some(tick.position.x));
    }
    for (message, tick) in of(Channel::Options).zip(&ticks) {
        let value = decoded(message);
        for (o, option) in tick.options.iter().enumerate() {
            let recorded = &value["options"][o];
            assert_eq!(recorded["probability"].as_f64(), Some(option.probability));
            let expected = Some(option.expected).filter(|e| e.is_finite());
            assert_eq!(
                recorded["expected_subjective_cost"].as_f64(),
                expected,
                "what is no number is left out"
            );
        }
    }
    assert_eq!(of(Channel::Preparation).count(), ticks.len());
    for (message, tick) in of(Channel::Preparation).zip(&ticks) {
        let value = decoded(message);
        let references = value["references"].as_array().unwrap();
        let prepared = tick.robot.unwrap().preparation;
        assert_eq!(references.len(), if prepared.is_some() { tick.options.len() } else { 1 });
        assert!(references.iter().all(|r| r["s"].as_array().is_some_and(|s| s.len() == 48)));
        let chosen = prepared.map(|p| &value["candidates"][p.candidate]["q"]);
        assert!(chosen.is_none_or(|chosen| *chosen == value["target"]), "{value}");
    }
    let said: Vec<String> =
        of(Channel::Log).map(|m| decoded(m)["message"].as_str().unwrap().to_owned()).collect();
    for words in ["leads on option 3", "the human takes the lead", "arrived at B on option 3"] {
        assert!(said.iter().any(|s| s.contains(words)), "{words:?} is missing from {said:?}");
    }
}

/// Where a step has several control periods, the tick and the recording tell of the last one, and a change of
/// configuration in any of them counts.
#[test]
fn a_preparation_is_that_of_the_last_control_period_of_its_step() {
    let mut scenario = example(Plant::Kinematic { setup: carrier() });
    scenario.settings.control_period = Some(0.05);
    let (mut last, mut changes) = (Vec::new(), 0);
    let (_, written) = encoded(scenario, |episode| {
        if let Some(control) = &episode.summary().control {
            last.push(episode.tick().robot.and_then(|robot| robot.preparation));
            changes = control.pose_changes;
        }
    });
    let messages: Vec<_> = written.iter().filter(|m| m.channel == Channel::Preparation).collect();
    let last = &last[last.len() - messages.len()..];
    for (message, prepared) in messages.iter().zip(last) {
        let value = decoded(message);
        let chosen = prepared.map(|p| &value["candidates"][p.candidate]["q"]);
        assert!(chosen.is_none_or(|chosen| *chosen == value["target"]), "{value}");
    }
    let changed_last = last.iter().flatten().filter(|p| p.candidate != 0).count() as u64;
    assert!(
        changed_last > 0 && changes > changed_last,
        "{changes} steps, {changed_last} in their last period"
    );
}

/// The validators of the schemas of JSON channels, by topic; a schema must use only what Foxglove reads.
#[derive(Default)]
struct Schemas(BTreeMap<String, (Value, Validator)>);

impl Schemas {
    fn check(&mut self, channel: &Definition, data: &[u8]) {
        let (schema, validator) = self.0.entry(channel.topic.clone()).or_insert_with(|| {
            let text = &channel.schema.as_ref().expect("a schema").data;
            let schema = serde_json::from_slice(text).expect("JSON");
            assert!(jsonschema::meta::is_valid(&schema), "{} is no JSON Schema", channel.topic);
            let validator = jsonschema::validator_for(&schema).expect("a JSON Schema");
            (schema, validator)
        });
        let message = serde_json::from_slice(data).expect("JSON");
        if let Some(error) = validator.iter_errors(&message).next() {
            panic!("{}: {error} at `{}`: {message}", channel.topic, error.instance_path());
        }
        only_declared(schema, &message, &channel.topic);
    }
}

/// A message has no field that its schema does not describe, and every description has one plain type.
fn only_declared(schema: &Value, value: &Value, path: &str) {
    assert!(schema["type"].is_string(), "{path}: one plain type");
    match value {
        Value::Object(fields) => {
            for (key, value) in fields {
                let path = format!("{path}.{key}");
                let property = &schema["properties"][key];
                assert!(property["description"].is_string(), "{path} is not in the schema");
                only_declared(property, value, &path);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| only_declared(&schema["items"], item, path)),
        _ => {}
    }
}

#[test]
fn json_messages_satisfy_their_schemas_on_every_plant() {
    let mut schemas = Schemas::default();
    let mut checked = 0;
    for plant in [Plant::Point, Plant::Kinematic { setup: carrier() }, rapier()] {
        for message in encoded(example(plant), |_| {}).1.iter().filter(|m| m.channel.encoding() == "json") {
            schemas.check(&Definition::of(message.channel), &message.data);
            checked += 1;
        }
    }
    assert!(checked > 1000);
    assert_eq!(schemas.0.len(), 7);
}

#[test]
fn json_messages_of_the_reference_recordings_satisfy_the_schemas_in_them() {
    let mut checked = 0;
    for environment in 1..=4 {
        let file = repository(&format!("recordings/environment-{environment}.mcap"));
        let mut reader = Reader::open(&file).expect("a recording");
        let mut schemas = Schemas::default();
        while let Some(entry) = reader.next().expect("a whole recording") {
            if let Some(message) = entry.message().filter(|m| m.channel.encoding == "json") {
                schemas.check(message.channel, message.data);
                checked += 1;
            }
        }
    }
    assert!(checked > 2000);
}

/// What a message leaves out has its column in a table all the same.
#[test]
fn a_table_has_a_column_for_every_field_of_the_schema() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(folder.path(), "point.mcap");
    json(&["run", "--plant", "point", "--record", &file, "--json"]);
    let table = stdout(&cocarry(&["inspect", &file, "--csv", "/cost"]));
    let (heading, rest) = table.split_once('\n').expect("a heading");
    assert!(heading.contains("accumulated_control_cost") && heading.contains("robot_work_j"), "{heading}");
    assert!(rest.lines().all(|line| line.split(',').count() == heading.split(',').count()));
}

#[test]
fn two_runs_give_the_same_bytes_and_recovering_a_whole_recording_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b, c] = ["a.mcap", "b.mcap", "c.mcap"].map(|name| path(folder.path(), name));
    for file in [&a, &b] {
        json(&["run", "environment-1", "--plant", "rapier", "--seed", "7", "--record", file, "--json"]);
    }
    let bytes = std::fs::read(&a).unwrap();
    assert!(bytes == std::fs::read(&b).unwrap());
    assert!(bytes.len() < 3 << 20);
    let output = cocarry(&["recover", &a, "-o", &c]);
    assert!(stdout(&output).contains("nothing is lost"), "{}", stderr(&output));
    assert!(bytes == std::fs::read(&c).unwrap());
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 3, "{left:?}");
    let text = String::from_utf8_lossy(&bytes);
    assert!(!text.contains(folder.path().to_str().unwrap()), "no path of this machine");
}

#[test]
fn inspect_tells_what_is_in_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let [file, table, picture, ticks] =
        ["r.mcap", "t.csv", "p.svg", "t.jsonl"].map(|n| path(folder.path(), n));
    let run = json(&["run", "--record", &file, "--seed", "3", "--json", "--ticks", &ticks]);
    let told = json(&["inspect", &file, "--json"]);
    assert_eq!(told["outcome"]["outcome"], run["outcome"]);
    assert_eq!(told["outcome"]["steps"], run["steps"]);
    assert_eq!(told["outcome"]["accumulated_control_cost"], run["accumulated_control_cost"]);
    assert_eq!(told["provenance"]["seed"], "3");
    assert_eq!(told["attachments"][0]["name"], "scenario.toml");
    let steps = run["steps"].as_u64().unwrap();
    let tf = told["channels"].as_array().unwrap().iter().find(|c| c["topic"] == "/tf").unwrap();
    assert_eq!(tf["messages"], steps + 1);
    let text = stdout(&cocarry(&["inspect", &file]));
    assert!(text.contains("foxglove.SceneUpdate") && text.contains("arrived"), "{text}");

    let output = cocarry(&["inspect", &file, "--csv", "/options", "--output", &table]);
    assert!(output.status.success(), "{}", stderr(&output));
    let mut reader = csv::Reader::from_path(&table).unwrap();
    let headings = reader.headers().unwrap().clone();
    let column = headings.iter().position(|h| h == "options[3].probability").expect("a column");
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len() as u64, steps);
    let ticks = std::fs::read_to_string(&ticks).unwrap();
    for (row, line) in rows.iter().zip(ticks.lines()) {
        let tick: Value = serde_json::from_str(line).unwrap();
        assert_eq!(row[column].parse::<f64>().unwrap(), tick["options"][2]["probability"].as_f64().unwrap());
    }
    let joints = stdout(&cocarry(&["inspect", &file, "--csv", "/joints"]));
    assert!(joints.lines().next().unwrap().contains("joints[elbow_flex_joint].position"));
    let output = cocarry(&["inspect", &file, "--csv", "/nothing"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("no channel `/nothing`") && stderr(&output).contains("`/options`"));

    let drawn = path(folder.path(), "run.svg");
    json(&["run", "--seed", "3", "--json", "--svg", &drawn]);
    assert!(cocarry(&["inspect", &file, "--svg", &picture]).status.success());
    assert_eq!(std::fs::read_to_string(picture).unwrap(), std::fs::read_to_string(drawn).unwrap());
}

/// As a viewer of an episode that goes on from a snapshot is told of it.
#[test]
fn an_episode_under_way_is_told_of_from_where_it_is() {
    let prepared = example(Plant::Kinematic { setup: carrier() }).prepare().unwrap();
    let mut episode = prepared.episode().unwrap();
    let mut encoder = Encoder::new(&prepared);
    encoder.begin(&episode);
    let mut told = Vec::new();
    for _ in 0..7 {
        assert_eq!(episode.step(), None);
        told = encoder.step(&episode).to_vec();
    }
    let mut encoder = Encoder::new(&prepared);
    let begun = encoder.begin(&episode);
    assert!(begun.iter().all(|message| message.time == 1_400_000_000));
    for channel in [Channel::Transforms, Channel::Joints] {
        let state = |all: &[Message]| all.iter().find(|m| m.channel == channel).cloned();
        assert!(state(begun).is_some() && state(begun) == state(&told), "{channel:?}");
    }
    assert!(begun.iter().any(|message| message.channel == Channel::World));
}
