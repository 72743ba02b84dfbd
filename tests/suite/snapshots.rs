//! An episode saved and gone on with is the episode that was never cut, to the last bit; a damaged snapshot
//! is refused and named.

use crate::support::{cocarry, stderr, stdout};
use cocarry::control;
use cocarry::coordination;
use cocarry::episode::{Episode, EpisodeSettings, PreferenceChange};
use cocarry::policy::Method;
use cocarry::preference::Perception;
use cocarry::robot::Robot;
use cocarry::scenario::{Plant, PreparedScenario, RobotSetup, Scenario, Snapshot};
use cocarry::simulation::PhysicsSettings;
use cocarry_studies::paper;
use std::path::Path;

fn scenario(plant: Plant, method: Method) -> Scenario {
    let world = paper::ENVIRONMENTS[3].world().unwrap_or_else(|e| panic!("{e}"));
    let coordination =
        coordination::StubbornnessSettings { eta: 5.0, ..coordination::StubbornnessSettings::default() };
    let settings = EpisodeSettings { method, coordination, ..EpisodeSettings::default() };
    Scenario {
        seed: 5,
        world: world.into(),
        human: paper::EXAMPLE_HUMAN,
        changes: Vec::new(),
        human_model: Default::default(),
        settings,
        plant,
    }
}

fn plants() -> [Plant; 3] {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let posture = robot.postures[0].name.clone();
    let carrier = RobotSetup { posture, control: control::ControlSettings::default(), robot: robot.into() };
    let physics = PhysicsSettings::default();
    assert!(physics.human.sway_lateral > 0.0, "the gait's generator matters");
    [Plant::Point, Plant::Kinematic { setup: carrier.clone() }, Plant::Rapier { setup: carrier, physics }]
}

fn prepared(scenario: Scenario) -> PreparedScenario {
    scenario.prepare().unwrap_or_else(|e| panic!("{e}"))
}

/// The ticks that are left, and the summary, to the last bit. As text: what was not evaluated is NaN.
fn rest(mut episode: Episode) -> Vec<String> {
    let mut bits = Vec::new();
    while episode.step().is_none() {
        bits.push(format!("{:?}", episode.tick()));
    }
    bits.push(format!("{:?}", episode.summary()));
    bits
}

fn parse(bytes: &[u8]) -> Result<Snapshot, cocarry::Error> {
    Snapshot::parse("cut.snapshot", bytes)
}

/// An episode's snapshot after so many steps, as a file's contents.
fn saved(prepared: &PreparedScenario, steps: u64) -> Vec<u8> {
    let mut episode = prepared.episode().unwrap_or_else(|e| panic!("{e}"));
    for _ in 0..steps {
        assert_eq!(episode.step(), None);
    }
    prepared.snapshot(&episode).bytes().unwrap_or_else(|e| panic!("{e}"))
}

/// Asserts that an episode saved after so many steps goes on with the bits of `whole`, and that its snapshot
/// is the one read.
fn assert_resumes(of_whole: &PreparedScenario, whole: &[String], cuts: &[u64]) {
    let name = of_whole.scenario().plant.name();
    for &cut in cuts {
        let bytes = saved(of_whole, cut);
        let snapshot = parse(&bytes).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(snapshot.state.steps(), cut);
        let prepared = prepared(snapshot.scenario);
        let episode = prepared.resume(snapshot.state).unwrap_or_else(|e| panic!("{e}"));
        let again = prepared.snapshot(&episode).bytes().unwrap_or_else(|e| panic!("{e}"));
        assert!(again == bytes, "{name}: something is lost after {cut} steps");
        assert!(rest(episode) == whole[cut as usize..], "{name}: cut after {cut} steps");
    }
}

#[test]
fn a_step_that_has_begun_goes_on_with_the_same_bits() {
    let learning = |scenario: Scenario| Scenario {
        settings: EpisodeSettings { learning: Some(Default::default()), ..scenario.settings },
        ..scenario
    };
    let plain = plants().map(|plant| scenario(plant, Method::MUTUAL));
    let learns = learning(scenario(Plant::Point, Method::MUTUAL));
    for scenario in plain.into_iter().chain([learns]) {
        let name = (scenario.plant.name(), scenario.settings.learning.is_some());
        let of_whole = prepared(scenario);
        let whole = rest(of_whole.episode().unwrap_or_else(|e| panic!("{e}")));
        for cut in [0, 1, 60] {
            let mut episode = of_whole.episode().unwrap_or_else(|e| panic!("{e}"));
            (0..cut).for_each(|_| assert_eq!(episode.step(), None));
            assert_eq!(episode.begin_step(), None);
            let bytes = of_whole.snapshot(&episode).bytes().unwrap_or_else(|e| panic!("{e}"));
            let Snapshot { scenario, state, .. } = parse(&bytes).unwrap_or_else(|e| panic!("{e}"));
            let prepared = prepared(scenario);
            let episode = prepared.resume(state).unwrap_or_else(|e| panic!("{e}"));
            assert!(episode.robot_view().is_some(), "{name:?}: the human has decided");
            let again = prepared.snapshot(&episode).bytes().unwrap_or_else(|e| panic!("{e}"));
            assert!(again == bytes, "{name:?}: something is lost in step {cut}");
            assert!(rest(episode) == whole[cut..], "{name:?}: cut in step {cut}");
        }
    }
}

#[test]
fn a_resumed_episode_is_the_one_never_cut() {
    for plant in plants() {
        let name = plant.name();
        let prepared_of_whole = prepared(scenario(plant, Method::MUTUAL));
        let whole = prepared_of_whole.episode().unwrap_or_else(|e| panic!("{e}"));
        let transition = {
            let mut episode = whole.clone();
            while episode.step().is_none() {}
            assert!(episode.summary().option_changes > 0, "{name}: the option changes");
            episode.summary().transition.expect("a transition").step
        };
        let whole = rest(whole);
        let end = whole.len() as u64 - 1;
        let cuts = [0, 1, transition - 1, transition, transition + 1, (transition + end) / 2, end];
        assert_resumes(&prepared_of_whole, &whole, &cuts);
    }
}

/// Nothing is lost on the way through a file that a later snapshot would show.
#[test]
fn a_snapshot_of_a_resumed_episode_is_the_one_of_the_episode_never_cut() {
    for plant in plants() {
        let name = plant.name();
        let whole = prepared(scenario(plant, Method::HUMAN_LED));
        let early = parse(&saved(&whole, 20)).unwrap_or_else(|e| panic!("{e}"));
        let prepared = prepared(early.scenario);
        let mut episode = prepared.resume(early.state).unwrap_or_else(|e| panic!("{e}"));
        for _ in 20..50 {
            assert_eq!(episode.step(), None);
        }
        let late = prepared.snapshot(&episode).bytes().unwrap_or_else(|e| panic!("{e}"));
        assert!(late == saved(&whole, 50), "{name}: the files differ");
    }
}

#[test]
fn a_cut_or_flipped_snapshot_is_refused() {
    let [_, kinematic, rapier] = plants().map(|plant| saved(&prepared(scenario(plant, Method::MUTUAL)), 30));
    for (bytes, stride) in [(kinematic, 97), (rapier, 9973)] {
        assert!(parse(&bytes).is_ok());
        for at in (0..bytes.len()).step_by(stride) {
            let error = parse(&bytes[..at]).map(|s| s.state.steps()).expect_err("cut").to_string();
            assert!(error.contains("cut.snapshot: "), "{error}");
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (at % 8);
            let error = parse(&flipped).map(|s| s.state.steps()).expect_err("flipped").to_string();
            assert!(error.contains("cut.snapshot: "), "{error}");
        }
        let longer = [&bytes[..], &[0]].concat();
        assert!(parse(&longer).unwrap_err().to_string().contains("a damaged snapshot: it has"));
    }
}

#[test]
fn a_snapshot_of_another_format_says_so() {
    let mut bytes = saved(&prepared(scenario(Plant::Point, Method::MUTUAL)), 3);
    let version = &bytes[21..21 + usize::from(bytes[20])];
    assert_eq!(version, env!("CARGO_PKG_VERSION").as_bytes());
    bytes[16] += 1;
    let error = parse(&bytes).map(|s| s.state.steps()).expect_err("another format").to_string();
    let (other, own) = (Snapshot::FORMAT + 1, Snapshot::FORMAT);
    let formats = [format!("format {other}"), format!("this program reads format {own}")];
    for part in formats.iter().map(String::as_str).chain([env!("CARGO_PKG_VERSION")]) {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn a_state_of_another_scenario_is_refused() {
    let [point, kinematic, rapier] = plants();
    let point = prepared(scenario(point, Method::MUTUAL));
    let kinematic = prepared(scenario(kinematic, Method::MUTUAL));
    let rapier = prepared(scenario(rapier, Method::MUTUAL));
    let state = |of: &PreparedScenario| of.episode().unwrap_or_else(|e| panic!("{e}")).state();
    let refused = |prepared: &PreparedScenario, of: &PreparedScenario| {
        prepared.resume(state(of)).map(|_| ()).expect_err("misfit").to_string()
    };
    assert!(refused(&point, &kinematic).contains("plant"));
    assert!(refused(&kinematic, &point).contains("plant"));
    assert!(refused(&kinematic, &rapier).contains("plant"));
    let door = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n";
    let world = cocarry::world::World::parse("w.toml", door).unwrap_or_else(|e| panic!("{e}"));
    let other = prepared(Scenario { world: world.into(), ..scenario(Plant::Point, Method::MUTUAL) });
    assert!(refused(&other, &point).contains("place"));
}

/// Saved before, at and after a change of mind, the human goes on as they would have: what they have become
/// is in the file, and what is to come too.
#[test]
fn a_human_cut_around_a_change_of_mind_is_the_one_never_cut() {
    let change = |step, alpha, gamma| PreferenceChange { step, perception: Perception { alpha, gamma } };
    for plant in plants() {
        let name = plant.name();
        // at step 25, the second of the two stands
        let changes =
            vec![change(45, 0.6, 0.6), change(25, 0.5, 0.5), change(25, 0.95, 1.1), change(0, 0.7, 0.8)];
        let scenario = scenario(plant, Method::HUMAN_LED);
        let kept = rest(prepared(scenario.clone()).episode().unwrap_or_else(|e| panic!("{e}")));
        let of_whole = prepared(Scenario { changes, ..scenario });
        let whole = rest(of_whole.episode().unwrap_or_else(|e| panic!("{e}")));
        assert!(whole[25..30] != kept[25..30], "{name}: the change makes a difference");
        let end = whole.len() as u64 - 1;
        assert_resumes(&of_whole, &whole, &[0, 1, 24, 25, 26, 44, 45, 46, end]);
    }
}

/// How long it has been stuck already is part of an episode.
/// The team remembers where it reverses to, and that it could not.
#[test]
fn a_team_cut_while_it_reverses_is_the_one_never_cut() {
    let [_, _, plant] = plants();
    let coordination =
        coordination::StubbornnessSettings { eta: 15.0, ..coordination::StubbornnessSettings::default() };
    let settings = EpisodeSettings { coordination, ..EpisodeSettings::default() };
    let human = Perception { alpha: 0.7572, gamma: 0.9508 };
    let whole = prepared(Scenario { settings, human, ..scenario(plant, Method::MUTUAL) });
    let mut episode = whole.episode().unwrap_or_else(|e| panic!("{e}"));
    let mut back = 0;
    while back < 4 {
        assert_eq!(episode.step(), None, "it reverses");
        back += u32::from(episode.tick().reverses_for.is_some());
    }
    let bytes = whole.snapshot(&episode).bytes().unwrap_or_else(|e| panic!("{e}"));
    let snapshot = parse(&bytes).unwrap_or_else(|e| panic!("{e}"));
    let prepared = prepared(snapshot.scenario);
    let again = prepared.resume(snapshot.state).unwrap_or_else(|e| panic!("{e}"));
    let (whole, again) = (rest(episode), rest(again));
    assert!(whole[0].contains("reverses_for: Some") && again == whole);
}

#[test]
fn an_episode_that_is_stuck_stays_so() {
    let [_, _, mut plant] = plants();
    let Plant::Rapier { setup: carrier, physics } = &mut plant else { panic!("the physical plant") };
    // wheels that hardly turn: the arm stretches by 9 cm, nearly enough to lose the object
    physics.rate_hz = 240.0;
    let mut texts = carrier.robot.texts().clone();
    texts.urdf = texts.urdf.replace("velocity=\"17.4\"", "velocity=\"0.001\"");
    carrier.robot = texts.into();
    let whole = prepared(scenario(plant, Method::ROBOT_LED));
    let end = rest(whole.episode().unwrap_or_else(|e| panic!("{e}")));
    assert!(end.last().expect("a summary").contains("Stuck"), "{:?}", end.last());
    let snapshot = parse(&saved(&whole, 40)).unwrap_or_else(|e| panic!("{e}"));
    assert!(rest(whole.resume(snapshot.state).unwrap_or_else(|e| panic!("{e}"))) == end[40..]);
}

/// The rows of a table of ticks, without its heading.
fn rows(file: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    text.lines().skip(1).map(str::to_owned).collect()
}

#[test]
fn another_process_resumes_with_the_same_bits() {
    for plant in ["point", "kinematic", "rapier"] {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
        let (first, second, svg) = (path("20.snapshot"), path("60.snapshot"), path("rest.svg"));
        let (all, left) = (path("all.csv"), path("left.csv"));
        let run = |arguments: &[&str]| {
            let output = cocarry(&[&["run"], arguments, &["--json"]].concat());
            assert!(output.status.success(), "{plant}: {}", stderr(&output));
            serde_json::from_str::<serde_json::Value>(&stdout(&output)).expect("JSON")
        };
        let asked = ["environment-1", "--plant", plant, "--seed", "4", "--eta", "5", "--ticks", &all];
        let saves = ["--save-at", "60", &second, "--save-at", "20", &first];
        let whole = run(&[&asked[..], &saves].concat());
        for (snapshot, step) in [(&first, 20), (&second, 60)] {
            let told = run(&["--resume", snapshot, "--ticks", &left, "--svg", &svg, "--overwrite"]);
            assert!(rows(Path::new(&left)) == rows(Path::new(&all))[step..], "{plant}: the ticks differ");
            assert_eq!(told["resumed_at_step"], step);
            // these tell of single ticks: from the snapshot on
            let of_ticks = ["options", "option_changes", "resumed_at_step"];
            let expected = whole.as_object().expect("an object").iter();
            for (key, value) in expected.filter(|(key, _)| !of_ticks.contains(&key.as_str())) {
                assert_eq!(&told[key], value, "{plant}: {key}");
            }
        }
        // what is saved on the way, from there on or from the beginning, is the same
        let again = path("again.snapshot");
        run(&["--resume", &first, "--save-at", "60", &again]);
        assert!(std::fs::read(&again).expect("a file") == std::fs::read(&second).expect("a file"), "{plant}");
    }
}

#[test]
fn what_is_told_of_an_episode_gone_on_with() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("end.snapshot").to_str().expect("UTF-8").to_owned();
    let whole = cocarry(&["run", "--alpha", "0.747", "--gamma", "0.765", "--save-at", "60", &file]);
    let told = cocarry(&["run", "--resume", &file]);
    assert_eq!((whole.status.code(), told.status.code()), (Some(0), Some(0)), "{}", stderr(&told));
    let (whole, told) = (stdout(&whole), stdout(&told));
    for part in ["Options at step 60", "step   60", "the human takes the lead"] {
        assert!(told.contains(part), "{part:?} is missing from:\n{told}");
    }
    let end =
        |text: &str| text.lines().skip_while(|l| !l.contains("arrived at B")).collect::<Vec<_>>().join("\n");
    assert_eq!(end(&told), end(&whole));
    assert!(end(&told).lines().count() >= 4, "{told}");
}

/// Gone on with after it, a change is told as what it was; where the team was then is not known.
#[test]
fn a_change_before_a_snapshot_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("30.snapshot").to_str().expect("UTF-8").to_owned();
    let changes = ["--change", "20:0.95,1.1", "--change", "40:0.7,0.7"];
    let asked = ["run", "--plant", "point", "--method", "human-led", "--save-at", "30", &file];
    let whole = cocarry(&[&asked[..], &changes].concat());
    assert!(whole.status.success(), "{}", stderr(&whole));
    let told = stdout(&cocarry(&["run", "--resume", &file]));
    for part in ["step   20 (  4.0 s): the human's preferences change", "step   40 (  8.0 s) at ("] {
        assert!(told.contains(part), "{part:?} is missing from:\n{told}");
    }
    let told = crate::support::json(&["run", "--resume", &file, "--json"]);
    let of = |i: usize, key: &str| told["preference_changes"][i][key].clone();
    assert_eq!((of(0, "applied"), of(1, "applied")), (true.into(), true.into()));
    assert!(of(0, "preferred").is_null() && of(1, "preferred").is_string());
}

fn refused(arguments: &[&str], said: &[&str]) {
    let output = cocarry(arguments);
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(error.starts_with("error: ") && !error.contains("panicked"), "{error}");
    for part in said {
        assert!(error.contains(part), "{part:?} is missing from: {error}");
    }
}

#[test]
fn what_cannot_be_gone_on_with_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let (file, bad) = (path("good.snapshot"), path("bad.snapshot"));
    let run = ["run", "--plant", "point", "--max-steps", "50", "--save-at", "10", &file];
    assert_eq!(cocarry(&run).status.code(), Some(3));
    let bytes = std::fs::read(&file).expect("a file");
    let resume = |contents: &[u8], said: &str| {
        std::fs::write(&bad, contents).expect("a file");
        refused(&["run", "--resume", &bad], &["bad.snapshot: ", said]);
    };
    resume(&[], "not a snapshot");
    resume(b"name = \"a world\"\n", "not a snapshot");
    resume(&bytes[..7], "damaged snapshot: it has 7 bytes");
    resume(&bytes[..bytes.len() - 1], "bytes; expected");
    let mut flipped = bytes.clone();
    flipped[bytes.len() / 2] ^= 4;
    resume(&flipped, "checksum");
    // with the right checksum
    let mut forged = bytes[..bytes.len() - 4].to_vec();
    let name = forged.windows(12).position(|w| w == b"name = \"xi3\"").expect("an opening");
    forged[name + 10] = b'1';
    forged.extend(crc32fast::hash(&forged).to_le_bytes());
    resume(&forged, "opening `xi1`");
    refused(&["run", "--resume", &path("none.snapshot")], &["none.snapshot: cannot be read"]);
    refused(&["run", "--resume", folder.path().to_str().expect("UTF-8")], &["cannot be read"]);
    for other in [
        &["environment-1"][..],
        &["--eta", "5"],
        &["--risk-weight", "3"],
        &["--plant", "point"],
        &["--change", "3:0.7,0.8"],
        &["--preference-changes", "1"],
    ] {
        refused(&[&["run", "--resume", &file], other].concat(), &["--resume", "cannot be used with"]);
    }
    refused(&["run", "--resume", &file, "--save-at", "9", &bad], &["--save-at 9", "step 10"]);
    refused(&["run", "--save-at", "ten", &bad], &["--save-at ten", "whole number"]);
}

#[test]
fn a_step_that_is_never_reached_is_told_after_the_outcome() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("late.snapshot");
    let name = file.to_str().expect("UTF-8");
    let arguments = ["run", "--plant", "point", "--save-at", "100000", name];
    refused(&arguments, &["--save-at 100000", "the episode ended after", "late.snapshot is not written"]);
    assert!(stdout(&cocarry(&arguments)).contains("arrived at B"));
    assert!(!file.exists());
    let output = cocarry(&["run", "--plant", "point", "--save-at", "3", "no-such-folder/x.snapshot"]);
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
}

#[test]
fn a_resumed_run_is_not_recorded() {
    let output = cocarry(&["run", "--resume", "half.snapshot", "--record", "run.mcap"]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("--resume") && said.contains("--record"), "{said}");
}
