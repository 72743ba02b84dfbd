//! Contacts, starts inside obstacles, and states that are not numbers.

use super::*;

#[test]
fn a_collision_says_who_with_what_where_and_how_hard() {
    let robot = carrier();
    let world = World::parse(
        "w.toml",
        &format!(
            "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n{}",
            WALL.replace("center_m = [WALL, 0]", "center_m = [2.0, 1.7]")
        ),
    )
    .unwrap_or_else(|e| panic!("{e}"));
    let mut plant = plant(&robot, &world, &PhysicsSettings::default());
    let first = plant.observe();
    let near = first.clearances.object_obstacle.clone().expect("a wall");
    assert!((near.distance - math::hypot(1.3_f64, 0.15)).abs() < 1e-9, "{near:?}");
    assert_eq!(near.between[1].name, "wall");
    // to the left into the wall's end
    let (mut met, mut deepest, mut hardest) = (None, 0.0_f64, 0.0_f64);
    for _ in 0..40 {
        let seen = plant.step(&wheels(&robot, 0.4, 0.12), &HumanCommand::Follow, PERIOD);
        assert_eq!(seen.failure, None);
        let speed = Vector3::from_column_slice(&seen.object_twist[..3]).norm();
        assert!(speed < 2.0, "{speed} m/s");
        for contact in &seen.contacts {
            assert_eq!(contact.between[1].kind, BodyKind::Obstacle);
            assert_eq!(contact.between[1].name, "wall");
            // nothing holds the human back; what is dynamic must not go in
            if contact.between[0].kind == BodyKind::Human {
                assert_eq!(contact.force, 0.0);
                continue;
            }
            deepest = deepest.max(contact.depth);
            hardest = hardest.max(contact.force);
            if contact.between[0].kind == BodyKind::Object {
                assert_eq!(contact.between[0].name, "beam");
                assert!((contact.point - nalgebra::Point3::new(2.0, 1.7, 0.7)).norm() < 1.6, "{contact:?}");
                met.get_or_insert((seen.time, contact.clone()));
            }
        }
    }
    assert!(met.is_some());
    assert!(deepest < 0.01 && hardest > 5.0 && hardest < 10_000.0, "{deepest} m, {hardest} N");
}

#[test]
fn a_team_that_starts_in_an_obstacle_is_refused() {
    let robot = carrier();
    let world = world(&WALL.replace("WALL", "0.9"));
    let refused = PhysicalPlant::new(&world, &robot, &robot.postures[0].joints, &AT_ORIGIN, &steady(), 1);
    let error = refused.expect_err("the human stands in the wall");
    assert_eq!(error.kind(), cocarry::ErrorKind::World);
    let text = error.to_string();
    for part in ["w.toml", "human", "torso", "`wall`"] {
        assert!(text.contains(part), "{text}");
    }
    let settings = PhysicsSettings { rate_hz: 0.0, ..steady() };
    let refused = PhysicalPlant::new(&world, &robot, &robot.postures[0].joints, &AT_ORIGIN, &settings, 1);
    assert!(refused.expect_err("no rate").to_string().contains("rate_hz = 0"));
}

#[test]
fn what_is_not_a_number_stops_the_plant_and_is_named() {
    let robot = carrier();
    let mut plant = plant(&robot, &world(""), &steady());
    let mut rates = InputVector::zeros();
    rates[3] = f64::NAN;
    let seen = plant.step(&rates, &HumanCommand::Follow, PERIOD);
    assert_eq!(seen.failure, Some(Failure::NonFinite { body: "command".to_owned() }));
    assert_eq!(plant.step(&InputVector::zeros(), &HumanCommand::Follow, PERIOD).time, 0.0);
}
