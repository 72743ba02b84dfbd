//! The quantities of an episode as a whole.

use super::*;

#[test]
fn closed_form_every_quantity_of_an_episode_with_bodies() {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let plant = scenario::Plant::Rapier { setup: setup(&robot), physics: PhysicsSettings::default() };
    let prepared = prepared(plant, EpisodeSettings::default());
    let mut episode = told(&prepared, ToldPlant::new(&robot));
    let mut errors = Vec::new();
    let mut tracking = 0.0;
    while episode.step().is_none() {
        let robot = episode.tick().robot.expect("a robot");
        errors.push(robot.position_error);
        tracking += robot.tracking_cost;
    }
    let n = STEPS as f64;
    assert_eq!(errors.len(), STEPS);
    let record = read(&View::new(&prepared, &episode), &[EPISODE]);
    words(
        &record,
        [
            ("outcome", "collided"),
            ("preferred_at_start", "far"),
            ("first_option", "near"),
            ("last_option", "near"),
            ("collision_of", "object"),
            ("collision_part", "beam"),
            ("collision_with", "obstacle"),
            ("collision_with_part", "middle"),
        ],
    );
    let steps = || (0..STEPS).map(|k| k as f64);
    let mean_of_squares =
        |value: &dyn Fn(f64) -> f64| steps().map(|k| value(k + 1.0) * value(k + 1.0)).sum::<f64>() / n;
    let effort = n * INPUT_WEIGHT * 0.01 * 0.01 * (1..=11).map(|i| f64::from(i * i)).sum::<f64>();
    let grasp_speed = math::hypot(0.003, 0.04) / 0.2;
    numbers(
        &record,
        [
            ("steps", n),
            ("time_s", 1.6),
            ("final_stubbornness", 0.9),
            ("final_discomfort", 8.5),
            ("share_off_preference", 0.5),
            ("disagreement_time_s", 0.8),
            ("overruled_time_s", 0.0),
            ("preference_change_count", 2.0),
            ("preferred_option_switches", 3.0),
            ("option_change_count", 0.0),
            ("transition_step", 6.0),
            ("transition_time_s", 1.2),
            ("transition_x_m", 1.0),
            ("accumulated_tracking_cost", tracking),
            ("accumulated_effort_cost", effort),
            ("accumulated_pose_cost", 6.0),
            ("accumulated_control_cost", tracking + effort + 6.0),
            ("position_error_rms_m", (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt()),
            ("largest_position_error_m", errors.iter().copied().fold(0.0, f64::max)),
            ("constrained_steps", 4.0),
            ("fallback_steps", 2.0),
            ("pose_change_count", 3.0),
            ("overlapping_steps", 1.0),
            ("least_base_clearance_m", -0.35),
            ("self_contact_steps", 5.0),
            // in the first step to a speed that it has lost in the second
            ("grasp_acceleration_mean_m_per_s2", 2.0 * grasp_speed / 0.2 / n),
            ("grasp_jerk_mean_m_per_s3", 4.0 * grasp_speed / 0.04 / n),
            ("hand_acceleration_mean_m_per_s2", 2.0 * 0.75 / n),
            ("hand_jerk_mean_m_per_s3", 4.0 * 3.75 / n),
            ("robot_idle_share", 7.0 / n),
            ("human_idle_share", 2.0 / n),
            ("concurrent_activity", 1.0 / n),
            ("idle_time_s", 0.4),
            ("motive_force_rms_n", mean_of_squares(&|k| 33.0 + k).sqrt()),
            ("internal_force_rms_n", mean_of_squares(&|k| 22.0 + k).sqrt()),
            ("human_force_share", 84.0 / (84.0 + 124.0)),
            ("robot_driving_work_j", 20.0),
            ("human_driving_work_j", 6.0),
            ("human_work_share", 6.0 / 26.0),
            ("least_obstacle_distance_m", 0.72),
            ("least_human_distance_m", 1.76),
            ("hand_force_mean_n", 14.5),
            ("hand_force_rms_n", mean_of_squares(&|k| 10.0 + k).sqrt()),
            ("peak_force_n", 48.0),
            ("robot_work_j", 12.0),
            ("human_work_j", -4.0),
            ("squared_jerk_m2_per_s5", steps().map(|k| 8.0 + k).sum()),
            ("force_above_10_hz_rms_n", mean_of_squares(&|k| 0.5 + 0.01 * k).sqrt()),
            ("largest_grip_deflection_m", 0.02),
            ("largest_effort_share", 0.38),
            ("time_at_effort_limit_s", steps().map(|k| 0.01 * (k + 1.0)).sum()),
            ("collision_x_m", 1.25),
            ("collision_y_m", 3.75),
            ("collision_z_m", 0.65),
            ("collision_depth_m", 0.004),
            ("collision_force_n", 17.0),
        ],
    );
    placed(
        &record,
        [
            ("walked_m", 0.08),
            ("accumulated_objective_cost_m", steps().map(|k| 13.0 - 0.01 * k).sum()),
            ("accumulated_subjective_cost", steps().map(|k| subjective(8.0 - 0.01 * k)).sum()),
            ("transition_y_m", 0.06),
        ],
    );
    for missing in ["path_efficiency", "lost_by", "lost_at_step", "lost_distance_m", "failure"] {
        assert!(record[missing].is_null(), "{missing}: {}", record[missing]);
    }
    let contacts = read(&View::new(&prepared, &episode), &TICK)["contacts"].clone();
    assert_eq!(contacts, 3);
}

#[test]
fn closed_form_what_broke_is_named() {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let plant = scenario::Plant::Rapier { setup: setup(&robot), physics: PhysicsSettings::default() };
    let prepared = prepared(plant, EpisodeSettings::default());
    let not_finite = Failure::NonFinite { body: "torso".to_owned() };
    for (failure, outcome, said) in [
        (not_finite, Outcome::NonFinite, "torso stopped being a number"),
        (Failure::Dropped, Outcome::Dropped, "the object fell"),
    ] {
        let mut episode = told(&prepared, ToldPlant { failure: Some(failure), ..ToldPlant::new(&robot) });
        assert_eq!(episode.step(), None);
        assert_eq!(episode.step(), Some(outcome));
        let record = read(&View::new(&prepared, &episode), &[EPISODE]);
        words(&record, [("outcome", outcome.name()), ("failure", said)]);
    }
}

/// A human who leads changes the option at step 3: the executed option follows.
#[test]
fn closed_form_changes_of_the_executed_option_are_counted() {
    let mut scenario = prepared(scenario::Plant::Point, EpisodeSettings::default()).scenario().clone();
    scenario.settings.method = "human-led".parse().unwrap_or_else(|e| panic!("{e}"));
    scenario.human_model = "scripted(0:near,3:far,5:near,6:far)".parse().unwrap_or_else(|e| panic!("{e}"));
    let prepared = scenario.prepare().unwrap_or_else(|e| panic!("{e}"));
    let mut episode = prepared.episode().unwrap_or_else(|e| panic!("{e}"));
    while episode.step().is_none() {}
    let record = read(&View::new(&prepared, &episode), &[EPISODE]);
    words(&record, [("outcome", "arrived"), ("first_option", "near"), ("last_option", "far")]);
    numbers(&record, [("option_change_count", 3.0), ("preferred_option_switches", 3.0)]);
    assert!(record["transition_step"].is_null() && record["accumulated_control_cost"].is_null());
}
