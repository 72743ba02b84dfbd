//! Whole episodes with a robot: what must hold of every step.

use crate::support::{cocarry, json, load, repository, stderr, stdout};
use cocarry::control::{self, Avoid, CandidateSet, PoseCriterion, RobotObstacles, SolveOutcome};
use cocarry::coordination::Mode;
use cocarry::episode::{Episode, EpisodeSettings, Manipulator, Outcome, Summary, Tick};
use cocarry::math;
use cocarry::policy::Method;
use cocarry::robot::Robot;
use cocarry_studies::paper::EXAMPLE_HUMAN;

fn carry(
    world: &str,
    method: Method,
    control: control::ControlSettings,
    robot: &Robot,
) -> (Summary, Vec<Tick>) {
    let (world, options) = load(&repository(world));
    let obstacles = RobotObstacles::new(&world);
    let settings = EpisodeSettings { method, ..EpisodeSettings::default() };
    let posture = robot.postures[0].joints;
    let manipulator = Manipulator { robot, posture, control, obstacles: &obstacles };
    let mut episode =
        Episode::builder(&options, &settings, EXAMPLE_HUMAN).with_robot(manipulator).begin().expect("room");
    let mut ticks = Vec::new();
    while episode.step().is_none() {
        ticks.push(episode.tick().clone());
    }
    (episode.summary().clone(), ticks)
}

fn carrier() -> Robot {
    Robot::built_in().expect("the built-in robot")
}

#[test]
fn property_every_step_of_the_robot_keeps_its_limits_and_its_books() {
    let robot = carrier();
    for set in [CandidateSet::None, CandidateSet::Arm, CandidateSet::WholeBody] {
        for method in [Method::HUMAN_LED, Method::MUTUAL] {
            let control = control::ControlSettings { candidates: set, ..control::ControlSettings::default() };
            let (summary, ticks) = carry("worlds/environment-4.toml", method, control, &robot);
            assert_eq!(summary.outcome, Outcome::Arrived);
            let total: f64 = ticks.iter().map(|t| t.robot.unwrap().cost()).sum();
            let control = summary.control.unwrap();
            assert!((control.cost() - total).abs() < 1e-9 * total);
            assert_eq!(control.fallback_steps, 0);
            for pair in ticks.windows(2) {
                let (now, next) = (pair[0].robot.unwrap(), pair[1].robot.unwrap());
                assert_eq!(now.preparation.is_some(), pair[0].mode == Mode::HumanLed);
                assert!(set != CandidateSet::None || now.pose_cost == 0.0);
                for (i, joint) in robot.joints.iter().enumerate() {
                    // pose change and input together
                    let moved = next.configuration.joints[i] - now.configuration.joints[i];
                    assert!(
                        moved.abs() <= 0.2 * joint.rate_limit + 1e-8,
                        "{} at {}",
                        joint.name,
                        pair[0].step
                    );
                    let there = next.configuration.joints[i];
                    assert!((joint.lower - 1e-8..=joint.upper + 1e-8).contains(&there), "{}", joint.name);
                }
                let rolled = (next.configuration.base.position - now.configuration.base.position).norm();
                assert!(rolled <= 0.2 * robot.drive.rim_speed_limit + 1e-8);
                assert!((next.grasp_goal.position - now.grasp_goal.position).norm() <= 0.1 + 1e-9);
                assert!(math::sin(next.grasp_goal.yaw - now.grasp_goal.yaw).abs() <= 0.16 + 1e-9);
            }
        }
    }
}

#[test]
fn closed_form_the_tracking_error_of_a_step_is_the_distance_to_the_human_after_it() {
    let robot = carrier();
    let (summary, ticks) =
        carry("worlds/environment-1.toml", Method::HUMAN_LED, control::ControlSettings::default(), &robot);
    for pair in ticks.windows(2) {
        let (now, next) = (pair[0].robot.unwrap(), pair[1].robot.unwrap());
        let grasp = robot.grasp_pose(&next.configuration);
        let off = (grasp.translation.vector - next.grasp_goal.at_height(0.7).translation.vector).norm();
        assert!((off - now.position_error).abs() < 1e-9, "step {}", pair[0].step);
        let cost = 1000.0 * (math::squared(now.position_error) + math::squared(now.orientation_error));
        assert!((cost - now.tracking_cost).abs() < 1e-9 * cost.max(1.0));
        assert!((now.effort_cost - now.input.norm_squared()).abs() < 1e-12);
    }
    // kappa ||q* - q_c||^2 with kappa = 1: what moved the joints besides the input
    for pair in ticks.windows(2) {
        let (now, next) = (pair[0].robot.unwrap(), pair[1].robot.unwrap());
        let by_input = now.input.fixed_rows::<8>(2) * 0.2;
        let by_choice = next.configuration.joints - now.configuration.joints - by_input;
        assert!((by_choice.norm_squared() - now.pose_cost).abs() < 1e-9, "step {}", pair[0].step);
    }
    assert!(summary.control.unwrap().pose > 0.1);
    let first = ticks[0].robot.unwrap();
    let grasp = robot.grasp_pose(&first.configuration).translation.vector.xy();
    assert!((grasp - ticks[0].position.coords).norm() < 1e-9, "the grasp starts at the team's start");
}

#[test]
fn a_robot_that_leads_follows_the_path_it_chose() {
    let (summary, _) = carry(
        "worlds/environment-4.toml",
        Method::ROBOT_LED,
        control::ControlSettings::default(),
        &carrier(),
    );
    let control = summary.control.unwrap();
    assert!(control.error_rms(summary.steps) < 0.01, "{control:?}");
    assert_eq!(control.pose_changes, 0);
}

#[test]
fn obstacles_in_the_mpc_keep_the_base_clear() {
    let robot = carrier();
    let with = |avoid| {
        let control = control::ControlSettings { avoid, ..control::ControlSettings::default() };
        let (_, ticks) = carry("worlds/environment-2.toml", Method::HUMAN_LED, control, &robot);
        let limited =
            ticks.iter().filter(|t| t.robot.unwrap().outcome != SolveOutcome::Unconstrained).count();
        (ticks.iter().map(|t| t.robot.unwrap().base_clearance).fold(f64::INFINITY, f64::min), limited)
    };
    let (without, _) = with(Avoid::Nothing);
    let (kept, limited) = with(Avoid::Base);
    assert!(without < 0.0, "the base overlaps an obstacle by itself: {without}");
    assert!(kept > -0.002 && limited > 0, "{kept} m, {limited} steps");
}

#[test]
fn the_criterion_decides_the_pose() {
    let robot = carrier();
    let cost = |criterion| {
        let control = control::ControlSettings {
            criterion,
            avoid: Avoid::Nothing,
            ..control::ControlSettings::default()
        };
        let (summary, _) = carry("worlds/environment-3.toml", Method::HUMAN_LED, control, &robot);
        summary.control.unwrap().cost()
    };
    assert!(cost(PoseCriterion::Expected) < cost(PoseCriterion::Manipulability));
}

/// Eq. (8) once more from what is told of a step: the totals of all candidates, each problem solved by
/// itself, and the least of them.
#[test]
fn closed_form_eq_8_can_be_worked_out_from_what_a_step_tells() {
    let robot = carrier();
    let (world, options) = load(&repository("worlds/environment-4.toml"));
    let obstacles = RobotObstacles::new(&world);
    let settings = EpisodeSettings { method: Method::HUMAN_LED, ..EpisodeSettings::default() };
    let control = control::ControlSettings { avoid: Avoid::Nothing, ..control::ControlSettings::default() };
    let posture = robot.postures[0].joints;
    let manipulator = Manipulator { robot: &robot, posture, control, obstacles: &obstacles };
    let mut episode =
        Episode::builder(&options, &settings, EXAMPLE_HUMAN).with_robot(manipulator).begin().expect("room");
    let (mut limits, mut mpc) = (control::Limits::new(&robot), control::Mpc::default());
    let (mut changed, mut skipped) = (0, 0);
    while episode.step().is_none() {
        let tick = episode.tick().robot.unwrap();
        let decision = episode.decision_basis().unwrap();
        assert_eq!(decision.references.len(), options.options().len());
        let mut totals = Vec::new();
        for candidate_cost in decision.poses.candidate_costs() {
            let candidate = candidate_cost.candidate;
            let jacobian = robot.kinematics(&candidate.configuration).jacobian * settings.planning_step;
            let form = control::ClosedForm::new(&jacobian, control.state_weight, control.input_weight);
            limits.set(&robot, &candidate.configuration, &candidate.rates, settings.planning_step);
            let mut total = control::motion_cost(&robot, candidate, &tick.configuration, &control);
            let mut floor = total;
            for (reference, weight) in decision.references.iter().zip(decision.weights) {
                total += weight * mpc.solve(&form, &limits, reference).cost;
                floor += weight * form.cost(&control::ModalReference::new(reference));
            }
            let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.max(1.0);
            assert!(
                candidate_cost.lower_bound.is_some_and(|told| near(told, floor)),
                "{candidate_cost:?} {floor}"
            );
            assert!(candidate_cost.cost.is_none_or(|told| near(told, total)), "{candidate_cost:?} {total}");
            skipped += usize::from(candidate_cost.cost.is_none());
            totals.push(total);
        }
        let least = totals.iter().copied().fold(f64::INFINITY, f64::min);
        let chosen = tick.preparation.unwrap().candidate;
        assert!(totals[chosen] <= least + 2e-9, "{totals:?} {chosen}");
        let target = decision.poses.candidate_costs().nth(chosen).unwrap().candidate.configuration;
        assert_eq!(&target, decision.target);
        changed += usize::from(chosen > 0);
    }
    assert!(changed > 0 && skipped > 0, "{changed} {skipped}");
}

#[test]
fn another_robot_carries_too() {
    let robot = Robot::load(&repository("tests/fixtures/robots/six.toml")).unwrap_or_else(|e| panic!("{e}"));
    let control = control::ControlSettings {
        candidates: CandidateSet::WholeBody,
        ..control::ControlSettings::default()
    };
    let (summary, ticks) = carry("worlds/environment-4.toml", Method::HUMAN_LED, control, &robot);
    assert_eq!(summary.outcome, Outcome::Arrived);
    assert!(summary.control.unwrap().error_rms(summary.steps) < 0.05, "{:?}", summary.control);
    assert!(ticks.iter().any(|t| t.robot.unwrap().preparation.is_some_and(|p| p.candidate != 0)));
}

#[test]
fn ticks_carry_what_the_robot_did() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ticks.csv");
    let told = json(&["run", "--method", "human-led", "--json", "--ticks", file.to_str().unwrap()]);
    let text = std::fs::read_to_string(&file).unwrap();
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let headings = reader.headers().unwrap().clone();
    let column = |name: &str| headings.iter().position(|h| h == name).unwrap_or_else(|| panic!("{name}"));
    let records: Vec<csv::StringRecord> = reader.records().map(|r| r.unwrap()).collect();
    let sum = |name: &str| records.iter().map(|r| r[column(name)].parse::<f64>().unwrap()).sum::<f64>();
    for name in ["tracking_cost", "effort_cost", "pose_cost"] {
        let expected = told[format!("accumulated_{name}")].as_f64().unwrap();
        assert!((sum(name) - expected).abs() < 1e-9 * expected.max(1.0), "{name}");
    }
    assert!(
        records
            .iter()
            .all(|r| &r[column("mpc_outcome")] == "unconstrained"
                || &r[column("mpc_outcome")] == "constrained")
    );
    assert!(records.iter().all(|r| r[column("least_singular_value")].parse::<f64>().unwrap() > 0.0));
    for name in [
        "position_error_m",
        "tracked",
        "pose_candidate",
        "position_rad[elbow_flex_joint]",
        "rate_rad_per_s[wrist_roll_joint]",
    ] {
        column(name);
    }
}

#[test]
fn the_planning_level_alone_knows_no_robot() {
    let told = json(&["run", "--plant", "point", "--json"]);
    assert!(told["accumulated_control_cost"].is_null() && told["robot"].is_null());
    let output = cocarry(&["run", "--plant", "point", "--pose", "arm"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--pose needs a robot, which --plant point does not have"));
}

#[test]
fn a_posture_or_robot_that_is_not_there_is_named() {
    let output = cocarry(&["run", "--posture", "elbow-down"]);
    assert_eq!(output.status.code(), Some(2));
    let said = stderr(&output);
    assert!(said.contains("elbow-down") && said.contains("`elbow-up`, `elbow-out`"), "{said}");
    let output = cocarry(&["run", "--robot", "nowhere/robot.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("nowhere/robot.toml"));
    assert_eq!(stdout(&output), "");
}
