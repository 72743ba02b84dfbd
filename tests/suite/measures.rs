//! How well a team carries: what is measured is what anybody would work out from the bodies' motion and forces.

use crate::quantity_values::WORLD;
use crate::support::{load, repository};
use cocarry::control::{self, RobotObstacles};
use cocarry::coordination::Mode;
use cocarry::episode::{Episode, EpisodeSettings, Manipulator, Outcome};
use cocarry::geometry::rotation_vector;
use cocarry::quantities::{EPISODE, View};
use cocarry::robot::Robot;
use cocarry::scenario::{Plant, Scenario};
use cocarry::simulation::{PhysicsSettings, PhysicsStep};
use cocarry::world::World;
use cocarry_studies::paper::EXAMPLE_HUMAN;
use nalgebra::{Point3, Vector3};
use std::sync::{Arc, Mutex};

#[track_caller]
fn near(found: f64, wanted: f64, share: f64) {
    assert!((found - wanted).abs() <= share * wanted.abs().max(1e-3), "{found}, not {wanted}");
}

/// Forces, their parts along the object and the work of both, again from every physics step.
#[test]
fn property_brute_force_of_how_forces_and_work_are_shared() {
    let robot = Robot::built_in().expect("the built-in robot");
    let (world, options) = load(&repository("worlds/environment-3.toml"));
    let (obstacles, settings, physics) =
        (RobotObstacles::new(&world), EpisodeSettings::default(), PhysicsSettings::default());
    let posture = robot.postures[0].joints;
    let manipulator = Manipulator {
        robot: &robot,
        posture,
        control: control::ControlSettings::default(),
        obstacles: &obstacles,
    };
    let steps: Arc<Mutex<Vec<PhysicsStep>>> = Arc::default();
    let seen = Arc::clone(&steps);
    let builder = Episode::builder(&options, &settings, EXAMPLE_HUMAN);
    let builder = builder.with_physics(manipulator, &world, &physics, 1);
    let builder =
        builder.with_step_observer(move |step: &PhysicsStep| seen.lock().expect("a list").push(*step));
    let mut episode = builder.begin().unwrap_or_else(|e| panic!("{e}"));
    let half = world.object.size[0] / 2.0;
    let ends = [-half, half].map(|x| Point3::new(x, 0.0, 0.0));
    let mut before = episode.observation().expect("bodies").object;
    let (mut squares, mut driving) = ([0.0; 2], [0.0; 2]);
    let (mut opposed, mut count) = (0, 0);
    for _ in 0..60 {
        assert_eq!(episode.step(), None);
        let steps = std::mem::take(&mut *steps.lock().expect("a list"));
        let (mut parts, mut level) = ([0.0; 2], [0.0; 2]);
        let mut driving_here = [0.0; 2];
        for step in &steps {
            let ahead = step.object.rotation * Vector3::x();
            let [robot, human] = step.grips.map(|grip| grip.force.dot(&ahead));
            let cancelled = if robot * human < 0.0 { robot.abs().min(human.abs()) } else { 0.0 };
            opposed += u32::from(cancelled > 0.0);
            parts[0] += (robot + human) * (robot + human);
            parts[1] += cancelled * cancelled;
            let turned = rotation_vector(&(step.object.rotation * before.rotation.inverse()));
            for by in 0..2 {
                let moved = step.object * ends[by] - before * ends[by];
                let work = step.grips[by].force.dot(&moved) + step.grips[by].torque.dot(&turned);
                driving_here[by] += work.max(0.0);
                level[by] += step.grips[by].force.xy().norm();
            }
            before = step.object;
        }
        count += steps.len();
        let seen = episode.tick().robot.and_then(|robot| robot.physics).expect("bodies");
        for i in 0..2 {
            near(seen.sharing.squared_parts[i], parts[i], 1e-9);
            near(seen.sharing.level_force[i], level[i], 1e-9);
            // positions of the ends here, velocities there: over a physics step they differ by its turn
            near(seen.sharing.driving_work[i], driving_here[i], 0.01);
            squares[i] += parts[i];
            driving[i] += driving_here[i];
        }
    }
    assert!(opposed > 100, "the two forces are opposed in {opposed} steps only");
    let summary = *episode.summary().interaction.as_ref().expect("bodies");
    for (by, driving) in driving.into_iter().enumerate() {
        near(summary.sharing.driving_work[by], driving, 0.01);
        assert!(summary.sharing.driving_work[by] >= summary.work[by]);
    }
    let rms = squares.map(|sum| (sum / count as f64).sqrt());
    near(summary.sharing.motive_force(), rms[0], 1e-9);
    near(summary.sharing.internal_force(), rms[1], 1e-9);
}

#[test]
fn closed_form_a_detour_costs_efficiency() {
    let world = World::parse("two.toml", WORLD).unwrap_or_else(|e| panic!("{e}"));
    let mut scenario = Scenario::new(world.into(), Plant::Point);
    scenario.settings.method = "human-led".parse().unwrap_or_else(|e| panic!("{e}"));
    for (option, steps) in [("near", None), ("far", None), ("near", Some(3))] {
        scenario.human_model = format!("scripted(0:{option})").parse().unwrap_or_else(|e| panic!("{e}"));
        let prepared = scenario.clone().prepare().unwrap_or_else(|e| panic!("{e}"));
        let mut episode = prepared.episode().unwrap_or_else(|e| panic!("{e}"));
        let mut lengths = Vec::new();
        while steps.is_none_or(|steps| episode.summary().steps < steps) && episode.step().is_none() {
            if lengths.is_empty() {
                lengths = episode.tick().options.iter().map(|option| option.remaining.length).collect();
            }
        }
        let record = View::new(&prepared, &episode).read(EPISODE);
        let value = record.into_iter().find(|(key, _)| *key == "path_efficiency").expect("a quantity").1;
        let walked = lengths[if option == "near" { 0 } else { 1 }];
        match steps {
            None => {
                assert_eq!(episode.summary().outcome, Outcome::Arrived);
                near(value.as_f64().expect("a number"), lengths[0] / walked, 1e-4);
                assert!(option == "near" || walked > 1.01 * lengths[0], "{lengths:?}");
            }
            Some(_) => assert!(value.as_f64().is_none(), "a team that is still on its way"),
        }
    }
}

/// The robot leads to the left and the human wants to go right, from the start to the end.
#[test]
fn a_robot_that_leads_on_overrules_and_one_that_gives_way_does_not() {
    let file = repository("worlds/environment-1.toml");
    let world = World::load(&file).unwrap_or_else(|e| panic!("{e}"));
    let mut scenario = Scenario::new(world.into(), Plant::Point);
    scenario.settings.coordination.eta = 5.0;
    for (method, overrules) in [("robot-led", true), ("mutual", false), ("human-led", false)] {
        scenario.settings.method = method.parse().unwrap_or_else(|e| panic!("{e}"));
        let prepared = scenario.clone().prepare().unwrap_or_else(|e| panic!("{e}"));
        let mut episode = prepared.episode().unwrap_or_else(|e| panic!("{e}"));
        let mut overruled = 0.0;
        while episode.step().is_none() {
            let tick = episode.tick();
            overruled += if tick.mode == Mode::RobotLed && tick.stubbornness > 1.0 { 0.2 } else { 0.0 };
        }
        let record = View::new(&prepared, &episode).read(EPISODE);
        let value = record.into_iter().find(|(key, _)| *key == "overruled_time_s").expect("a quantity").1;
        near(value.as_f64().expect("a number"), overruled, 1e-9);
        assert_eq!(overruled > 1.0, overrules, "{method}: {overruled} s");
        assert!(method != "mutual" || episode.summary().transition.is_some(), "the human did take the lead");
    }
}
