//! The same bits: run again, read back, and cloned.

use super::*;

/// What an observation is, to the last bit.
fn bits(seen: &Observation) -> String {
    format!("{seen:?}")
}

/// A drive with contacts: a command for every tick.
fn eventful(robot: &Robot, tick: usize) -> (InputVector, HumanCommand) {
    let mut rates = wheels(robot, 0.4, 0.12);
    rates[3] = 0.1 * math::sin(tick as f64);
    let hand = PlanarPose { position: Point::new(0.6 + 0.05 * tick as f64, 0.0), yaw: 0.0 };
    let human = if tick % 20 < 15 { HumanCommand::Follow } else { HumanCommand::Walk { hand } };
    (rates, human)
}

#[test]
fn the_same_inputs_and_seed_give_the_same_bits() {
    let robot = carrier();
    let world = world(&WALL.replace("center_m = [WALL, 0]", "center_m = [2.0, 1.7]"));
    let run = |seed| {
        let joints = &robot.postures[0].joints;
        let settings = PhysicsSettings::default();
        let mut plant = PhysicalPlant::new(&world, &robot, joints, &AT_ORIGIN, &settings, seed)
            .unwrap_or_else(|e| panic!("{e}"));
        let step = |tick| {
            let (rates, human) = eventful(&robot, tick);
            bits(&plant.step(&rates, &human, PERIOD))
        };
        (0..40).map(step).collect::<Vec<_>>()
    };
    let first = run(1);
    assert!(first.last().is_some_and(|seen| seen.contains("wall")));
    assert_eq!(first, run(1));
    assert_ne!(first, run(2));
}

#[test]
fn a_plant_read_back_and_a_clone_go_on_with_the_same_bits() {
    let robot = carrier();
    let world = world(&WALL.replace("center_m = [WALL, 0]", "center_m = [2.0, 1.7]"));
    let mut plant = plant(&robot, &world, &PhysicsSettings::default());
    for pause in [8, 30] {
        for tick in pause - 8..pause {
            let (rates, human) = eventful(&robot, tick);
            plant.step(&rates, &human, PERIOD);
        }
        let text = serde_json::to_string(&plant).expect("JSON");
        let mut others: [PhysicalPlant; 2] = [serde_json::from_str(&text).expect("a plant"), plant.clone()];
        let mut ahead = plant.clone();
        for tick in pause..pause + 30 {
            let (rates, human) = eventful(&robot, tick);
            let expected = bits(&ahead.step(&rates, &human, PERIOD));
            for other in &mut others {
                assert_eq!(bits(&other.step(&rates, &human, PERIOD)), expected, "tick {tick}");
            }
        }
    }
}
