//! Step and solver iterations are such that the error of the simulation is within stated bounds.

use super::*;

/// Largest differences of an object's position (m) and of the forces of gripper and hand (N) around a corner,
/// between this number of solver iterations and a hundred.
fn spoiled_by(solver_iterations: usize, mass: f64) -> [f64; 2] {
    let robot = carrier();
    let world = world(&format!("[object]\nshape = \"beam\"\nsize_m = [1.2, 0.1, 0.1]\nmass_kg = {mass}\n"));
    let reach = world.object.size[0] / 2.0;
    let walk = |solver_iterations| {
        let mut plant =
            plant(&robot, &world, &PhysicsSettings { solver_iterations, ..PhysicsSettings::default() });
        let mut seen = plant.observe();
        let step = |tick: i32| {
            let goal = around_a_corner(f64::from(tick) * PERIOD);
            let hand = PlanarPose { position: goal.position + direction(goal.yaw) * reach, ..goal };
            let rates = around(&robot, &seen, f64::from(tick - 1) * PERIOD, reach);
            seen = plant.step(&rates, &HumanCommand::Walk { hand }, PERIOD);
            seen.clone()
        };
        (1..=45).map(step).collect::<Vec<_>>()
    };
    let mut worst = [0.0_f64; 2];
    for (seen, exact) in walk(solver_iterations).iter().zip(&walk(100)) {
        let place = (seen.object.translation.vector - exact.object.translation.vector).norm();
        let force = (seen.grip.mean.force - exact.grip.mean.force).norm();
        let hand = (seen.hand_grip.mean.force - exact.hand_grip.mean.force).norm();
        worst = [worst[0].max(place), worst[1].max(force).max(hand)];
    }
    worst
}

#[test]
fn oracle_the_default_solver_iterations_suffice() {
    let solver_iterations = PhysicsSettings::default().solver_iterations;
    for (mass, bounds) in [(0.5, [1e-4, 0.02]), (4.0, [1e-6, 1e-3]), (15.0, [1e-6, 1e-3])] {
        let spoiled = spoiled_by(solver_iterations, mass);
        assert!(spoiled[0] < bounds[0] && spoiled[1] < bounds[1], "{mass} kg: {spoiled:?}");
    }
}

/// Around a corner with a human who follows, at a rate (Hz): where the object is after each control period,
/// and the noise of gripper and hand, rms over the way (N).
fn at_rate(rate_hz: f64) -> (Vec<Vector3<f64>>, [f64; 2]) {
    let robot = carrier();
    let world = world("");
    let reach = world.object.size[0] / 2.0;
    let mut plant = plant(&robot, &world, &PhysicsSettings { rate_hz, ..PhysicsSettings::default() });
    let mut seen = plant.observe();
    let (mut places, mut squares) = (Vec::new(), [0.0; 2]);
    for tick in 1..=45 {
        let rates = around(&robot, &seen, f64::from(tick - 1) * PERIOD, reach);
        seen = plant.step(&rates, &HumanCommand::Follow, PERIOD);
        places.push(seen.object.translation.vector);
        squares[0] += math::squared(seen.grip.noise) / 45.0;
        squares[1] += math::squared(seen.hand_grip.noise) / 45.0;
    }
    (places, squares.map(f64::sqrt))
}

/// The change of a force from one step to the next would double with the step.
#[test]
fn the_noise_of_forces_does_not_depend_on_the_step() {
    let exact = at_rate(960.0).1;
    for rate_hz in [60.0, 100.0, 240.0, 480.0] {
        let noise = at_rate(rate_hz).1;
        for (found, expected) in noise.iter().zip(&exact) {
            assert!(*expected > 0.01, "{exact:?}");
            assert!((found / expected - 1.0).abs() < 0.25, "{rate_hz} Hz: {noise:?}, {exact:?}");
        }
    }
}

#[test]
fn oracle_the_default_step_is_short_enough() {
    let exact = at_rate(960.0).0;
    let default = at_rate(PhysicsSettings::default().rate_hz).0;
    let off = default.iter().zip(&exact).map(|(at, exact)| (at - exact).norm()).fold(0.0, f64::max);
    assert!(off < 0.002, "{off} m");
}
