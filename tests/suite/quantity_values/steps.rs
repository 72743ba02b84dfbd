//! The quantities of a step, of its options and of its preparation.

use super::*;

#[test]
fn closed_form_every_quantity_of_a_step_with_bodies() {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let plant = scenario::Plant::Rapier { setup: setup(&robot), physics: PhysicsSettings::default() };
    let prepared = prepared(plant, EpisodeSettings::default());
    let mut episode = told(&prepared, ToldPlant::new(&robot));
    assert_eq!(episode.step(), None);
    let tick = read(&View::new(&prepared, &episode), &TICK);
    numbers(
        &tick,
        [
            ("step", 0.0),
            ("time_s", 0.0),
            ("x_m", 1.0),
            ("y_m", 0.0),
            ("heading_deg", 90.0),
            ("stubbornness", 0.2),
            ("stubbornness_threshold", 1.0),
            ("discomfort", 1.5),
            ("executed_index", 0.0),
            ("preferred_index", 1.0),
            // J = D + c_r S = 8 m + 10 m / 2
            ("objective_cost_m", 13.0),
            ("accumulated_objective_cost_m", 13.0),
            ("robot_work_j", 1.5),
            ("human_work_j", -0.5),
        ],
    );
    placed(&tick, [("walked_m", 0.01)]);
    words(&tick, [("mode", "robot-led"), ("executed", "near"), ("preferred", "far")]);
    let turn = 2.0_f64.to_radians();
    let tracking = STATE_WEIGHT * (0.005 * 0.005 + turn * turn);
    // from its place at the start to 3 mm aside and 4 cm ahead of it
    let grasp_speed = math::hypot(0.003, 0.04) / 0.2;
    let effort = INPUT_WEIGHT * 0.01 * 0.01 * (1..=11).map(|i| f64::from(i * i)).sum::<f64>();
    numbers(
        &tick,
        [
            // half the object's length behind its centre
            ("grasp_goal_x_m", 1.0),
            ("grasp_goal_y_m", -0.6),
            ("grasp_goal_yaw_deg", 90.0),
            ("base_x_m", 1.2),
            ("base_y_m", -1.3),
            ("base_yaw_deg", 88.0),
            // from a disc of half the base's width to the corner (1.5, 3.9) of the wall
            ("base_clearance_m", math::hypot(0.3, 5.2) - 0.25),
            ("mpc_active_limits", 3.0),
            ("least_singular_value", 0.125),
            ("position_error_m", 0.005),
            ("orientation_error_deg", 2.0),
            ("tracking_cost", tracking),
            ("effort_cost", effort),
            ("pose_cost", 0.75),
            ("accumulated_tracking_cost", tracking),
            ("accumulated_effort_cost", effort),
            ("accumulated_pose_cost", 0.75),
            ("accumulated_control_cost", tracking + effort + 0.75),
            ("left_rim_m_per_s", 0.01),
            ("right_rim_m_per_s", 0.02),
            ("grasp_speed_m_per_s", grasp_speed),
            ("hand_speed_m_per_s", 0.15),
            ("grasp_acceleration_m_per_s2", grasp_speed / 0.2),
            ("hand_acceleration_m_per_s2", 0.75),
            ("grasp_jerk_m_per_s3", grasp_speed / 0.04),
            ("hand_jerk_m_per_s3", 3.75),
        ],
    );
    words(&tick, [("mpc_outcome", "constrained")]);
    for missing in ["reverses_for", "tracked", "pose_candidate", "pose_candidates", "self_contact"] {
        assert!(tick[missing].is_null(), "{missing}: {}", tick[missing]);
    }
    for missing in ["base_ahead_m_per_s", "base_left_m_per_s", "base_turn_rad_per_s"] {
        assert!(tick[missing].is_null(), "{missing} of wheels with rims");
    }
    numbers(
        &tick,
        [
            ("object_x_m", 1.0),
            ("object_y_m", 0.01),
            ("object_yaw_deg", 91.0),
            ("hand_x_m", 1.1),
            ("hand_y_m", 0.62),
            ("hand_yaw_deg", 92.0),
            ("torso_x_m", 1.2),
            ("torso_y_m", 0.98),
            ("torso_yaw_deg", 93.0),
            ("grip_force_n", 21.0),
            ("hand_force_n", 11.0),
            ("grip_peak_force_n", 41.0),
            ("hand_peak_force_n", 32.0),
            ("peak_force_n", 41.0),
            ("grip_mean_force_x_n", 2.0),
            ("grip_mean_force_y_n", 3.0),
            ("grip_mean_force_z_n", 4.0),
            ("grip_mean_torque_x_nm", 1.1),
            ("grip_mean_torque_y_nm", 1.2),
            ("grip_mean_torque_z_nm", 1.3),
            ("hand_mean_force_x_n", -2.5),
            ("hand_mean_force_y_n", -3.5),
            ("hand_mean_force_z_n", -4.5),
            ("hand_mean_torque_x_nm", -1.4),
            ("hand_mean_torque_y_nm", -1.5),
            ("hand_mean_torque_z_nm", -1.6),
            ("motive_force_n", 34.0),
            ("internal_force_n", 23.0),
            ("grip_driving_work_j", 2.5),
            ("hand_driving_work_j", 0.75),
            ("grip_deflection_m", 0.012),
            ("hand_deflection_m", 0.013),
            ("grip_force_above_10_hz_n", 0.51),
            ("hand_force_above_10_hz_n", 0.26),
            ("effort_share", 0.31),
            ("time_at_effort_limit_s", 0.01),
            ("grip_work_j", 1.5),
            ("hand_work_j", -0.5),
            ("squared_jerk_m2_per_s5", 8.0),
            ("obstacle_distance_m", 0.79),
            ("human_distance_m", 1.76),
            ("contacts", 0.0),
        ],
    );
    // the leader has accelerated for a period, 0.9 m/s^2 * (0.2 s)^2, and the object has moved 1 cm
    placed(&tick, [("path_lead_m", 0.026)]);
    let joints = tick["joints"].as_array().expect("joints");
    assert_eq!(joints.len(), 7);
    for (i, joint) in joints.iter().enumerate() {
        assert_eq!(joint["name"].as_str(), Some(robot.joints[i].name.as_str()));
        near(&joint["position_rad"], robot.postures[0].joints[i]);
        near(&joint["rate_rad_per_s"], 0.01 * (i + 3) as f64);
    }
}

#[test]
fn closed_form_every_quantity_of_an_option() {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let plant = scenario::Plant::Rapier { setup: setup(&robot), physics: PhysicsSettings::default() };
    let prepared = prepared(plant, EpisodeSettings::default());
    let mut episode = told(&prepared, ToldPlant::new(&robot));
    for _ in 0..2 {
        assert_eq!(episode.step(), None);
    }
    let tick = read(&View::new(&prepared, &episode), &TICK);
    let [near_option, far] = tick["options"].as_array().expect("options").as_slice() else { panic!("two") };
    // J~ over alpha from 0.55 to 0.95 and gamma from 0.5 to 1.1
    let length = 7.99;
    let distance = (math::pow(length, 0.95) - math::pow(length, 0.55)) / (0.4 * math::ln(length));
    let risk = |gamma: f64| math::exp(-math::pow(math::ln(2.0), gamma));
    let simpson = |i: u32| if i == 0 || i == 1000 { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    let risk = (0..=1000).map(|i| simpson(i) * risk(0.5 + 0.6 * f64::from(i) / 1000.0)).sum::<f64>() / 3000.0;
    let record = near_option.as_object().expect("a record");
    words(record, [("name", "near")]);
    placed(
        record,
        [
            ("length_m", length),
            ("objective_cost_m", length + 5.0),
            ("expected_subjective_cost", distance + 10.0 * risk),
        ],
    );
    // it is shorter at the same risk
    numbers(record, [("risk", 0.5), ("probability", 1.0)]);
    assert_eq!((&record["misaligned"], &far["misaligned"]), (&Value::Bool(false), &Value::Bool(true)));
    assert_eq!((far["name"].as_str(), far["probability"].as_f64()), (Some("far"), Some(0.0)));
}

#[test]
fn closed_form_the_preparation_of_a_step() {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let plant = scenario::Plant::Rapier { setup: setup(&robot), physics: PhysicsSettings::default() };
    let prepared = prepared(plant, EpisodeSettings::default());
    let mut episode = told(&prepared, ToldPlant::new(&robot));
    for _ in 0..2 {
        assert_eq!(episode.step(), None);
    }
    let view = View::new(&prepared, &episode);
    let tick = read(&view, &[CONTROL]);
    words(&tick, [("tracked", "far")]);
    numbers(
        &tick,
        [
            ("pose_candidate", 4.0),
            ("pose_candidates", 15.0),
            ("pose_constrained_problems", 7.0),
            ("mpc_active_limits", 2.0),
        ],
    );
    let record = read(&view, &[PREPARATION]);
    for (i, (name, weight)) in [("near", 0.375), ("far", 0.625)].into_iter().enumerate() {
        let reference = record["references"][i].as_object().expect("a reference");
        words(reference, [("name", name)]);
        numbers(reference, [("weight", weight)]);
        let s = reference["s"].as_array().expect("s");
        assert_eq!(s.len(), 6 * HORIZON);
        near(&s[0], 100.0 * i as f64);
        near(&s[6 * 2 + 3], 100.0 * i as f64 + 23.0);
    }
    let target = record["target"].as_object().expect("a configuration");
    numbers(target, [("x_m", 5.5), ("y_m", 6.5), ("yaw_rad", 0.75)]);
    target["joints"]
        .as_array()
        .expect("joints")
        .iter()
        .enumerate()
        .for_each(|(i, q)| near(q, 0.5 + i as f64));
    // at the end of the fourth step the arm touches the base
    for _ in 2..4 {
        assert_eq!(episode.step(), None);
    }
    let tick = read(&View::new(&prepared, &episode), &TICK);
    assert!(tick["self_contact"].as_str().is_some_and(|links| links.starts_with("base_link, ")), "{tick:?}");
    assert_eq!(tick["mpc_active_limits"], 4);
    episode.step();
    words(&read(&View::new(&prepared, &episode), &[CONTROL]), [("mpc_outcome", "fallback: not solved")]);
    episode.step();
    let tick = read(&View::new(&prepared, &episode), &TICK);
    words(&tick, [("mpc_outcome", "fallback: not finite")]);
    // the base's centre is 10 cm inside the wall
    near(&tick["base_clearance_m"], -0.1 - 0.25);
}
