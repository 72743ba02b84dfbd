//! The two clocks: what a person does counts in planning steps, whatever the controller's rate.

use crate::support::{cocarry, stderr};
use cocarry::episode::{Episode, EpisodeSettings, HumanObserver, Outcome};
use cocarry::geometry::{Point, Vector};
use cocarry::human::{HandView, Human, HumanDecision, HumanView, Stance};
use cocarry::learning;
use cocarry::robot::Robot;
use cocarry::scenario::{Decisions, Plant, PlantKind, PreparedScenario, RobotSetup, Scenario};
use cocarry_recording::recording;
use cocarry_studies::paper;
use std::io::Cursor;

const CONTROL_PERIODS_S: [f64; 4] = [0.2, 0.1, 0.05, 0.02];

fn prepared(kind: PlantKind, control_period: f64) -> PreparedScenario {
    let world = paper::ENVIRONMENTS[3].world().expect("a world");
    let plant = Plant::new(kind, RobotSetup::new(&Robot::built_in().expect("the robot")));
    let settings = EpisodeSettings { control_period: Some(control_period), ..EpisodeSettings::default() };
    let scenario = Scenario { human: paper::EXAMPLE_HUMAN, settings, ..Scenario::new(world.into(), plant) };
    scenario.prepare().unwrap_or_else(|e| panic!("{e}"))
}

/// Metamorphic: another control period is another controller, and the same person.
#[test]
fn property_the_control_period_changes_neither_who_carries_nor_where() {
    for kind in PlantKind::ALL {
        let mut first = None;
        for period in CONTROL_PERIODS_S {
            let prepared = prepared(kind, period);
            let mut episode = prepared.episode().unwrap_or_else(|e| panic!("{e}"));
            while episode.step().is_none() {}
            let end = episode.summary().clone();
            let case = format!("{} at {period} s", kind.name());
            assert_eq!(end.outcome, Outcome::Arrived, "{case}: {:?}", end.loss);
            let transition = end.transition.expect("the human takes over").step;
            let (step, option, cost) =
                *first.get_or_insert((transition, end.last_option, end.accumulated_cost));
            assert!(transition.abs_diff(step) <= 1, "{case}: taken over at {transition}, {step} at 0.2 s");
            assert_eq!(end.last_option, option, "{case}");
            let ratio = end.accumulated_cost / cost;
            assert!((ratio - 1.0).abs() < 0.02, "{case}: {ratio}");
        }
    }
}

/// Takes over six seconds into the walk.
#[derive(Clone, Debug)]
struct Pressing;

impl Human for Pressing {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        let stance = if view.time >= 6.0 - 1e-9 { Stance::TakeOver } else { Stance::Follow };
        HumanDecision { stance, ..HumanDecision::following(3) }
    }
}

#[test]
fn issue_the_same_press_another_eta() {
    let etas = CONTROL_PERIODS_S.map(|period| {
        let prepared = prepared(PlantKind::Point, period);
        let builder = prepared.builder().unwrap_or_else(|e| panic!("{e}"));
        let mut episode = builder.with_human(Pressing).begin().expect("a point has room");
        let mut observer = HumanObserver::new(learning::LearningSettings::default(), 0.1).expect("settings");
        while episode.step().is_none() {
            observer.observe(&episode);
        }
        (observer.etas(), observer.sightings().len())
    });
    assert!(etas[0].0[0] > 1.0 && etas[0].0[1].is_finite(), "{etas:?}");
    // places on the path are sums of more parts, so that the last digits differ
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
    let is_first = |(eta, sightings): &([f64; 2], usize)| {
        near(eta[0], etas[0].0[0]) && near(eta[1], etas[0].0[1]) && *sightings == etas[0].1
    };
    assert!(etas.iter().all(is_first), "{etas:?}");
}

#[test]
fn a_period_that_does_not_fill_the_step_is_refused() {
    for (arguments, said) in [
        (
            &["--control-period", "0.15"][..],
            &["control_period_s = 0.15", "a whole fraction of planning_step_s = 0.2"][..],
        ),
        (&["--control-period", "0.4"], &["control_period_s = 0.4"]),
        (
            &["--control-period", "0.01", "--physics-rate", "60"],
            &["control_period_s = 0.01", "a physics step"],
        ),
        (&["--period", "0.1"], &["--period", "--planning-step", "--control-period"]),
    ] {
        let output = cocarry(&[&["run"], arguments].concat());
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        for part in said {
            assert!(error.contains(part), "{arguments:?}: {error}");
        }
    }
}

/// Walks as usual; from the first second on, the hand swings about the way in every control period.
#[derive(Clone, Debug)]
struct Swinging;

impl Human for Swinging {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        let stance = if view.step >= 5 { Stance::TakeOver } else { Stance::Follow };
        HumanDecision { stance, ..HumanDecision::following(2) }
    }

    fn hand(&mut self, view: &HandView<'_>) -> Option<Point> {
        let swing = 0.01 * cocarry::math::sin(10.0 * view.time);
        (view.time > 1.0).then(|| view.hand[1] + Vector::new(0.02, swing))
    }
}

/// The targets of control periods are followed between planning steps, recorded, and replayed to the byte.
#[test]
fn a_hand_from_outside_has_a_target_in_every_control_period() {
    let prepared = prepared(PlantKind::Rapier, 0.05);
    let builder = prepared.builder().unwrap_or_else(|e| panic!("{e}"));
    let mut episode = builder.with_human(Swinging).begin().unwrap_or_else(|e| panic!("{e}"));
    let log = Decisions::new(true, None);
    let recorder = recording::Recorder::new(Cursor::new(Vec::new()), "a hand", &prepared, &episode);
    let mut recorder = recorder.expect("a recorder").logging(log);
    for _ in 0..9 {
        assert_eq!(episode.step(), None);
        recorder.step(&episode).expect("a step");
        let asked = if episode.tick().step >= 6 { 4 } else { 0 };
        assert!(episode.hands().len() == asked || episode.tick().step == 5, "{:?}", episode.hands());
    }
    let recorded =
        recorder.finish(&episode, recording::Ending::Interrupted).expect("a recording").into_inner();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("hand.mcap");
    std::fs::write(&file, recorded).expect("a file");
    let output = cocarry(&["replay", file.to_str().expect("a name")]);
    assert!(output.status.success(), "{}", stderr(&output));
    // its page says that nobody can go on from there: this human is not in the recording, nor what they are
    // like
    let page = folder.path().join("hand.html");
    let output = cocarry(&["render", file.to_str().expect("a name"), "-o", page.to_str().expect("a name")]);
    assert!(output.status.success(), "{}", stderr(&output));
    let page = std::fs::read_to_string(page).expect("a page");
    assert!(
        page.contains("cannot be taken over: a program decided for the human") && !page.contains("127.0.0.1")
    );
    assert!(page.contains(r#""alpha":null"#) && page.contains(r#""method":"mutual""#));
}

/// Without targets of its own, a hand goes straight to that of the decision.
#[test]
fn closed_form_a_hand_goes_straight_to_the_target_of_its_step() {
    let decision = HumanDecision { hand: Some(Point::new(1.0, 2.0)), ..HumanDecision::following(0) };
    let hand = [Point::new(0.0, 0.0), Point::new(9.0, 9.0)];
    let target = |period| {
        let view = HandView {
            time: 0.0,
            period: [period, 4],
            control_period: 0.05,
            decision: &decision,
            hand,
            heading: 0.0,
            wrench: None,
        };
        view.toward_target().expect("a target")
    };
    assert!((target(0) - Point::new(0.25, 0.5)).norm() < 1e-15);
    assert_eq!(target(3), Point::new(1.0, 2.0));
}

/// The planning step is another matter: a person who waits a number of steps waits longer with longer steps.
#[test]
fn the_planning_step_is_the_time_in_which_a_person_counts() {
    let world = paper::ENVIRONMENTS[3].world().expect("a world");
    let options = cocarry::options::OptionSet::new(&world, 10.0).expect("options");
    let times = [0.2, 0.1].map(|planning_step| {
        let settings = EpisodeSettings { planning_step, ..EpisodeSettings::default() };
        let mut episode = Episode::new(&options, &settings, paper::EXAMPLE_HUMAN);
        while episode.step().is_none() {}
        episode.summary().transition.expect("a transition").step as f64 * planning_step
    });
    assert!((times[1] / times[0] - 0.5).abs() < 0.1, "{times:?}");
}
