//! The robot learns who it carries with: episodes, snapshots, and the calibration of what it learns.

use crate::support::{cocarry, json, load, repository, stderr};
use cocarry::coordination::Mode;
use cocarry::episode::{Episode, EpisodeSettings};
use cocarry::learning::{self, Learner};
use cocarry::options::OptionSet;
use cocarry::policy::Method;
use cocarry::preference::Perception;
use cocarry::scenario::{Plant, SETTINGS, Scenario, Value};
use cocarry::world::World;
use cocarry_studies::fit::{Calibration, checks};

const HUMAN: Perception = Perception { alpha: 0.747, gamma: 0.765 };

fn scenario(method: Method) -> Scenario {
    let world = World::load(&repository("worlds/environment-4.toml")).expect("a world");
    let learning = Some(learning::LearningSettings::default());
    let settings = EpisodeSettings { method, learning, ..EpisodeSettings::default() };
    Scenario { human: HUMAN, settings, ..Scenario::new(world.into(), Plant::Point) }
}

#[test]
fn the_belief_is_a_setting_and_its_default_leaves_no_trace() {
    let setting = SETTINGS.iter().find(|setting| setting.flag == "belief").expect("a setting");
    let mut scenario = scenario(Method::MUTUAL);
    assert_eq!(setting.get(&scenario), Some(Value::Text("learn".to_owned())));
    assert_eq!(Scenario::parse(&scenario.text().expect("text")).expect("a scenario"), scenario);
    setting.set(&mut scenario, &Value::Text("prior".to_owned()));
    assert_eq!(scenario.settings.learning, None);
    assert!(!scenario.text().expect("text").contains("learning"));
}

#[test]
fn numbers_out_of_range_are_refused_by_their_key() {
    let text = scenario(Method::MUTUAL).text().expect("text");
    assert!(text.contains("lapse_rate = 0.02"), "{text}");
    let refused = Scenario::parse(&text.replace("lapse_rate = 0.02", "lapse_rate = 0.7")).unwrap_err();
    assert!(refused.to_string().contains("settings.learning.lapse_rate"), "{refused}");
}

#[test]
fn a_robot_that_follows_learns_what_the_human_prefers() {
    let prepared = scenario(Method::HUMAN_LED).prepare().expect("prepared");
    let mut episode = prepared.episode().expect("an episode");
    let (mut first, mut last) = (None, 0.0);
    while episode.step().is_none() {
        let tick = episode.tick();
        last = tick.options[tick.preferred].probability;
        first.get_or_insert(last);
    }
    assert!(last > 0.9 && last > first.expect("a step") + 0.2, "{first:?} {last}");
    let mut learner = episode.into_learner().expect("a learner");
    assert!(learner.density(HUMAN) > 1.0);
    assert!(learner.perception_mut().estimate().information > 0.1);
}

#[test]
fn the_human_takes_over_as_with_the_prior_and_the_robot_learns_eta() {
    let (_, options) = load(&repository("worlds/environment-4.toml"));
    let learns = scenario(Method::MUTUAL).settings;
    let mut episode = Episode::new(&options, &learns, HUMAN);
    let mut led = 0.0;
    while episode.step().is_none() {
        let tick = episode.tick();
        if tick.mode == Mode::RobotLed {
            led = tick.discomfort;
        }
    }
    let switched = episode.summary().transition.is_some();
    let learner = episode.into_learner().expect("a learner");
    let [low, high] = learner.tolerance().tasks()[0];
    assert!(low <= 10.5 && 10.5 < high, "{low} {high}");
    assert_eq!(high.is_finite(), switched);
    assert!((low - led / learning::discomfort_limit(0.1)).abs() < 1e-9, "{low} {led}");
    // the next task begins with what is known
    let again = Episode::new(&options, &learns, HUMAN).with_learner(learner);
    assert_eq!(again.learner().expect("a learner").tolerance().tasks().len(), 2);
}

#[test]
fn settings_of_learning_out_of_their_range_are_refused_before_the_first_step() {
    let (_, options) = load(&repository("worlds/environment-4.toml"));
    let begun = |learning: learning::LearningSettings| {
        let settings = EpisodeSettings { learning: Some(learning), ..EpisodeSettings::default() };
        let begun = Episode::builder(&options, &settings, HUMAN).begin().map(|episode| {
            assert!(episode.learner().is_some());
        });
        begun.map_err(|error| error.to_string())
    };
    assert_eq!(begun(learning::LearningSettings::default()), Ok(()));
    let change_rate = begun(learning::LearningSettings { change_rate: 0.0, ..Default::default() });
    assert_eq!(change_rate, Err("change_rate = 0: it must be at least 0.0001 and at most 0.5".to_owned()));
    let look_steps = begun(learning::LearningSettings { look_steps: 0, ..Default::default() });
    assert_eq!(look_steps, Err("look_steps = 0: it must be at least 1".to_owned()));
}

#[test]
fn a_snapshot_of_a_robot_that_learns_goes_on_with_the_same_bits() {
    for method in [Method::HUMAN_LED, Method::MUTUAL] {
        let prepared = scenario(method).prepare().expect("prepared");
        let mut whole = prepared.episode().expect("an episode");
        for _ in 0..45 {
            assert!(whole.step().is_none());
        }
        let bytes = prepared.snapshot(&whole).bytes().expect("bytes");
        let snapshot = cocarry::scenario::Snapshot::parse("x", &bytes).expect("a snapshot");
        let mut resumed = prepared.resume(snapshot.state).expect("resumed");
        loop {
            let ended = whole.step();
            assert_eq!(ended, resumed.step());
            assert_eq!(format!("{:?}", whole.tick()), format!("{:?}", resumed.tick()));
            if ended.is_some() {
                break;
            }
        }
        let states = [whole, resumed].map(|episode| episode.learner().map(Learner::state));
        assert!(states[0] == states[1]);
    }
}

#[test]
fn the_belief_is_calibrated_and_a_wrong_likelihood_is_not() {
    let worlds = ["environment-1", "environment-3", "environment-4"];
    let sets: Vec<OptionSet> =
        worlds.iter().map(|name| load(&repository(&format!("worlds/{name}.toml"))).1).collect();
    let right = Calibration { replications: 1500, ..Calibration::default() };
    let found = checks(&right.run(&sets, &|| {}).expect("settings"));
    assert!(found.iter().all(|check| check.is_calibrated), "{found:#?}");
    // the robot trusts sightings and times that say nothing in three of ten cases
    let lapses = |lapse_rate| learning::LearningSettings { lapse_rate, ..right.truth };
    let wrong = Calibration { truth: lapses(0.3), assumed: lapses(0.001), ..right.clone() };
    let found = checks(&wrong.run(&sets, &|| {}).expect("settings"));
    assert!(found.iter().any(|check| !check.is_calibrated), "{found:#?}");
}

#[test]
fn rates_out_of_their_range_are_refused_by_flag() {
    for (flag, value, expected) in [
        ("--lapse-rate", "0.7", "must be a number from 0 to 0.5"),
        ("--lapse-rate", "-1", "must be a number from 0 to 0.5"),
        ("--assumed-lapse-rate", "nan", "must be a number from 0 to 0.5"),
        ("--assumed-lapse-rate", "often", "must be a number from 0 to 0.5"),
    ] {
        let output = cocarry(&["calibrate", flag, value]);
        assert_eq!(output.status.code(), Some(2), "{flag} {value}");
        let said = stderr(&output);
        assert!(said.contains(&format!("'{value}' for '{flag} <RATE>': {expected}")), "{said}");
    }
}

#[test]
fn h4_pairs_the_same_people_and_a_robot_that_knows_them_has_no_regret() {
    let folder = tempfile::tempdir().unwrap();
    let h4 = |threads: &str| {
        let file = folder.path().join(format!("{threads}.csv"));
        let name = file.to_str().unwrap();
        let arguments = [
            "reproduce",
            "h4",
            "--humans",
            "2",
            "--worlds",
            "2",
            "--threads",
            threads,
            "--rows",
            name,
            "--json",
        ];
        (json(&arguments), std::fs::read_to_string(&file).unwrap())
    };
    let (found, people) = h4("2");
    let rows = |table: &str| found[table].as_array().expect("rows").clone();
    // 5 worlds and the random ones, or 6 kinds of humans; 2 tasks, 4 robots
    assert_eq!([rows("by_world").len(), rows("by_human").len()], [48, 48]);
    for row in rows("by_world").iter().chain(&rows("by_human")) {
        let regret = row["regret"].as_f64().expect("a number");
        match row["robot"].as_str().expect("a name") {
            "knows" => assert!(regret < 1e-6, "{row}"),
            "prior" => assert!(regret >= 0.0 && row["regret_against_prior"].is_null(), "{row}"),
            _ => assert!(regret >= 0.0, "{row}"),
        }
    }
    let total = |robot: &str| {
        let of = rows("by_human").into_iter().filter(|row| row["robot"] == robot);
        of.map(|row| row["regret"].as_f64().expect("a number")).sum::<f64>()
    };
    assert!(total("prior") > 1.0, "the paper's robot does not know them: {}", total("prior"));
    // 4 methods of control, 5 worlds, the random ones and all of them
    let control = rows("control");
    assert_eq!(control.len(), 224);
    let cost = |pose: &str, robot: &str, part: &str| {
        let is_it = |row: &&serde_json::Value| {
            row["world"] == "all"
                && row["method"] == "human-led"
                && row["pose"] == pose
                && row["robot"] == robot
                && row["task"] == 2
        };
        let row = control.iter().find(is_it).expect("a row");
        match part {
            "all" => row["control_cost"].as_f64(),
            _ => row["parts"][0].as_f64(),
        }
        .expect("a cost")
    };
    // the way is the same with every robot; one that has learned tracks the human's option, with and without
    // pose optimisation
    for pose in ["with-po", "uniform-weights", "without-po"] {
        for robot in ["learns", "knows"] {
            let [knows, prior] = [robot, "prior"].map(|robot| cost(pose, robot, "all"));
            assert!(prior > 10.0 && knows < 0.9 * prior, "{pose}, {robot}: {knows} and {prior}");
            let [less, all] = [robot, "prior"].map(|robot| cost(pose, robot, "tracking"));
            assert!(prior - knows < 1.5 * (all - less), "{pose}, {robot}: tracking {less} and {all}");
        }
    }
    // the rows of people are what the tables are of
    let lines: Vec<Vec<&str>> = people.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| lines[0].iter().position(|heading| *heading == name).expect("a column");
    // 6 groups of 2 people: 6 kinds as points, 4 with an arm; 2 tasks, 4 robots
    assert_eq!(lines.len() - 1, 6 * 2 * (6 + 4) * 2 * 4);
    let [pose, robot, method, task] = ["pose", "robot", "method", "task"].map(column);
    let costs = lines[1..].iter().filter(|line| {
        line[method] == "human-led"
            && line[pose] == "without-po"
            && line[robot] == "learns"
            && line[task] == "2"
    });
    let costs: Vec<f64> = costs.map(|line| line[column("control_cost")].parse().unwrap()).collect();
    let mean = costs.iter().sum::<f64>() / costs.len() as f64;
    assert!((mean - cost("without-po", "learns", "all")).abs() < 1e-9, "{mean}");
    let walked = column("objective_cost_m");
    for line in lines[1..].iter().filter(|line| line[method] == "human-led") {
        let same = |other: &&Vec<&str>| {
            ["world", "stream", "task", "method"].map(column).iter().all(|&c| other[c] == line[c])
        };
        assert!(lines.iter().filter(same).all(|other| other[walked] == line[walked]), "{line:?}");
    }
    assert!(h4("1") == (found, people), "the figures do not depend on the threads");
}
