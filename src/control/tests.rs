//! Fast paths compared with slow references, on random states of the built-in robot.

use super::limits::Constraint;
use super::*;
use crate::geometry::{PlanarPose, Point, direction};
use crate::robot::{BaseInput, Configuration, InputVector, JointVector, Kinematics, Robot};
use nalgebra::{DMatrix, DVector, Matrix6, Vector6};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

const PERIOD: f64 = 0.2;
const N: usize = MAX_INPUTS * HORIZON;

fn robot() -> Robot {
    Robot::built_in().expect("the built-in robot")
}

/// A configuration inside the joint limits, its kinematics, and trajectories from there at `speed_factor`
/// times walking speed.
fn random_state(
    robot: &Robot,
    rng: &mut ChaCha8Rng,
    speed_factor: f64,
) -> (Configuration, Kinematics, Vec<Reference>) {
    let mut joints = JointVector::zeros();
    for (q, joint) in joints.iter_mut().zip(&robot.joints) {
        *q = rng.random_range(joint.lower.max(-3.0)..joint.upper.min(3.0));
    }
    let base = PlanarPose { position: Point::new(1.0, -2.0), yaw: rng.random_range(-3.0..3.0) };
    let q = Configuration { base, joints };
    let at = robot.kinematics(&q);
    let references = (0..4)
        .map(|_| {
            let heading = direction(rng.random_range(-3.0..3.0)) * (speed_factor * 0.5 * PERIOD);
            let turn = rng.random_range(-0.16..0.16) * speed_factor;
            let offset = Vector6::from_fn(|_, _| rng.random_range(-0.02..0.02) * speed_factor);
            Reference::from_fn(|row, t| {
                let way = [heading.x, heading.y, 0.0, 0.0, 0.0, turn][row];
                offset[row] + way * (t + 1) as f64
            })
        })
        .collect();
    (q, at, references)
}

fn input_matrix(at: &Kinematics) -> crate::robot::InputJacobian {
    at.jacobian * PERIOD
}

/// Eq. (7) without limits by the textbook matrix recursion.
fn riccati(b: &crate::robot::InputJacobian, reference: &Reference) -> (f64, Inputs) {
    let q = Matrix6::identity() * 1000.0;
    let r = nalgebra::SMatrix::<f64, MAX_INPUTS, MAX_INPUTS>::identity();
    let mut gains = Vec::new();
    let last = reference.column(HORIZON - 1).into_owned();
    let (mut p, mut g, mut c) = (q, q * last, last.dot(&(q * last)));
    for t in (0..HORIZON).rev() {
        let inverse = (r + b.transpose() * p * b).try_inverse().unwrap();
        let (k, l) = (inverse * b.transpose() * p, inverse * b.transpose());
        gains.push((k, l * g));
        c -= g.dot(&(b * l * g));
        let closed = Matrix6::identity() - b * k;
        (p, g) = (closed.transpose() * p, closed.transpose() * g);
        if t > 0 {
            let s = reference.column(t - 1).into_owned();
            p += q;
            g += q * s;
            c += s.dot(&(q * s));
        }
    }
    let (mut x, mut inputs) = (Vector6::zeros(), Inputs::zeros());
    for (t, (k, l)) in gains.iter().rev().enumerate() {
        let u = l - k * x;
        x += b * u;
        inputs.set_column(t, &u);
    }
    (c, inputs)
}

/// The cost of eq. (7), term by term.
fn rolled_out(b: &crate::robot::InputJacobian, reference: &Reference, inputs: &Inputs) -> f64 {
    let mut x = Vector6::zeros();
    let mut cost = 0.0;
    for t in 0..HORIZON {
        x += b * inputs.column(t);
        cost += 1000.0 * (x - reference.column(t)).norm_squared() + inputs.column(t).norm_squared();
    }
    cost
}

/// Hess and f of eq. (7) in the stacked inputs, cost u' Hess u - 2 f' u + const.
fn condensed(b: &crate::robot::InputJacobian, reference: &Reference) -> (DMatrix<f64>, DVector<f64>) {
    let mut to_states = DMatrix::zeros(6 * HORIZON, N);
    for t in 0..HORIZON {
        for step in 0..=t {
            to_states.view_mut((6 * t, MAX_INPUTS * step), (6, MAX_INPUTS)).copy_from(b);
        }
    }
    let stacked = DVector::from_column_slice(reference.as_slice());
    let hessian = to_states.transpose() * &to_states * 1000.0 + DMatrix::identity(N, N);
    (hessian, to_states.transpose() * stacked * 1000.0)
}

fn all_rows(robot: &Robot) -> Vec<Constraint> {
    let mut rows = Vec::new();
    for sign in [1.0, -1.0] {
        for step in 0..HORIZON {
            for input in 0..robot.joint_count() + 2 {
                rows.push(Constraint::Rate { input, step, sign });
                if input >= 2 {
                    rows.push(Constraint::Position { input, step, sign });
                }
            }
        }
    }
    rows
}

/// Eq. (7) with limits as one dense program over all inputs and all constraints.
fn dense(robot: &Robot, b: &crate::robot::InputJacobian, reference: &Reference, limits: &Limits) -> Inputs {
    let (hessian, f) = condensed(b, reference);
    let rows: Vec<Constraint> =
        all_rows(robot).into_iter().filter(|row| limits.bound(*row).is_finite()).collect();
    let a = DMatrix::from_rows(
        &rows
            .iter()
            .map(|row| DVector::from_column_slice(limits.coefficients(*row).as_slice()).transpose())
            .collect::<Vec<_>>(),
    );
    let bounds: Vec<f64> = rows.iter().map(|row| limits.bound(*row)).collect();
    let u = super::qp::dense(&hessian, f.as_slice(), &a, &bounds).expect("solved");
    Inputs::from_column_slice(&u)
}

#[test]
fn closed_form_agrees_with_the_riccati_recursion() {
    let (robot, mut rng) = (robot(), ChaCha8Rng::seed_from_u64(1));
    for _ in 0..200 {
        let (_, at, references) = random_state(&robot, &mut rng, 1.0);
        let b = input_matrix(&at);
        let free = ClosedForm::new(&b, 1000.0, 1.0);
        for reference in &references {
            let (cost, inputs) = riccati(&b, reference);
            let modal = ModalReference::new(reference);
            assert!((free.cost(&modal) - cost).abs() < 1e-9 * cost.max(1.0));
            assert!((free.inputs(&modal) - inputs).amax() < 1e-9);
            assert!((rolled_out(&b, reference, &inputs) - cost).abs() < 1e-9 * cost.max(1.0));
        }
    }
}

#[test]
fn closed_form_survives_a_jacobian_without_rank() {
    let free = ClosedForm::new(&crate::robot::InputJacobian::zeros(), 1000.0, 1.0);
    let reference = ModalReference::new(&Reference::repeat(0.1));
    assert!((free.cost(&reference) - 1000.0 * 48.0 * 0.01).abs() < 1e-9);
    assert_eq!(free.inputs(&reference), Inputs::zeros());
    assert_eq!(least_singular_value(&crate::robot::InputJacobian::zeros()), 0.0);
}

#[test]
fn closed_form_inverse_hessian_is_the_inverse() {
    let (robot, mut rng) = (robot(), ChaCha8Rng::seed_from_u64(2));
    for _ in 0..20 {
        let (_, at, references) = random_state(&robot, &mut rng, 1.0);
        let b = input_matrix(&at);
        let free = ClosedForm::new(&b, 1000.0, 1.0);
        let (hessian, _) = condensed(&b, &references[0]);
        let a = Inputs::from_fn(|_, _| rng.random_range(-1.0..1.0));
        let back = hessian * DVector::from_column_slice(free.inverse_hessian_times(&a).as_slice());
        assert!((back - DVector::from_column_slice(a.as_slice())).amax() < 1e-9);
    }
}

#[test]
fn closed_form_a_guided_base_has_the_optimum_with_the_deviation_in_the_cost() {
    let (robot, mut rng) = (robot(), ChaCha8Rng::seed_from_u64(12));
    for prices in [[3.0; 2], [GUIDE_PRICE; 2], [0.0, 100.0]] {
        for _ in 0..20 {
            let (_, at, references) = random_state(&robot, &mut rng, 1.0);
            let b = input_matrix(&at);
            let given: BaseInputs = std::array::from_fn(|_| {
                BaseInput::new(rng.random_range(-0.5..0.5), rng.random_range(-0.5..0.5), 0.0)
            });
            let [left, right] = prices;
            let of_inputs = BaseInput::new(left, right, 0.0);
            let guided = ClosedForm::guided(&b, [1000.0, 1.0], &robot.drive, &given, &of_inputs);
            let (mut hessian, mut f) = condensed(&b, &references[0]);
            for (t, given) in given.iter().enumerate() {
                for i in 0..2 {
                    let at = t * MAX_INPUTS + i;
                    hessian[(at, at)] += prices[i];
                    f[at] += prices[i] * given[i];
                }
            }
            let optimum = hessian.clone().cholesky().unwrap().solve(&f);
            let reference = ModalReference::new(&references[0]);
            let inputs = guided.inputs(&reference);
            assert!((DVector::from_column_slice(inputs.as_slice()) - optimum).amax() < 1e-9);
            let off: f64 = given
                .iter()
                .enumerate()
                .map(|(t, given)| {
                    (0..2).map(|i| prices[i] * crate::math::squared(inputs[(i, t)] - given[i])).sum::<f64>()
                })
                .sum();
            let cost = rolled_out(&b, &references[0], &inputs) + off;
            assert!((guided.cost(&reference) - cost).abs() < 1e-9 * cost);
            let a = Inputs::from_fn(|_, _| rng.random_range(-1.0..1.0));
            let back = hessian * DVector::from_column_slice(guided.inverse_hessian_times(&a).as_slice());
            assert!((back - DVector::from_column_slice(a.as_slice())).amax() < 1e-8);
        }
    }
}

#[test]
fn the_constrained_solution_agrees_with_a_dense_program() {
    let (robot, mut rng) = (robot(), ChaCha8Rng::seed_from_u64(3));
    let (mut mpc, mut limits) = (Mpc::default(), Limits::new(&robot));
    let mut constrained = 0;
    for case in 0..60 {
        let (q, at, references) = random_state(&robot, &mut rng, [1.0, 2.0, 5.0][case % 3]);
        let b = input_matrix(&at);
        let free = ClosedForm::new(&b, 1000.0, 1.0);
        let taken = InputVector::from_fn(|i, _| if i >= 2 { 0.5 * limits.rates()[i] } else { 0.0 });
        limits.set(&robot, &q, &taken, PERIOD);
        let reference = &references[0];
        let plan = mpc.solve(&free, &limits, reference);
        let slow = dense(&robot, &b, reference, &limits);
        assert!((plan.inputs - slow).amax() < 1e-6, "case {case}: {}", (plan.inputs - slow).amax());
        let cost = rolled_out(&b, reference, &plan.inputs);
        assert!((plan.cost - cost).abs() < 1e-7 * cost.max(1.0), "case {case}: {} {cost}", plan.cost);
        assert!(plan.cost >= free.cost(&ModalReference::new(reference)) - 1e-9);
        assert!(limits.allow(&plan.inputs), "case {case}");
        match plan.outcome {
            SolveOutcome::Unconstrained => {}
            SolveOutcome::Constrained { active } => {
                assert!(active > 0);
                constrained += 1;
            }
            SolveOutcome::Fallback(why) => panic!("case {case}: {why:?}"),
        }
    }
    assert!(constrained > 30, "{constrained}");
}

#[test]
fn closed_form_a_joint_may_use_the_way_to_its_limit_and_no_more() {
    let robot = robot();
    let mut q = Configuration {
        base: PlanarPose { position: Point::origin(), yaw: 0.0 },
        joints: robot.postures[0].joints,
    };
    let mut limits = Limits::new(&robot);
    let (elbow, upper) = (3, robot.joints[3].upper);
    let row = Constraint::Position { input: elbow + 2, step: 5, sign: 1.0 };
    for (position, room) in [(upper - 0.05, 0.25), (upper, 0.0), (upper + 0.1, 0.0)] {
        q.joints[elbow] = position;
        limits.set(&robot, &q, &InputVector::zeros(), PERIOD);
        assert!((limits.bound(row) - room).abs() < 1e-12);
        assert!(limits.allow(&Inputs::zeros()), "standing still is always allowed");
    }
}

#[test]
fn closed_form_the_fallback_keeps_every_hard_limit() {
    let (robot, mut rng) = (robot(), ChaCha8Rng::seed_from_u64(8));
    let mut limits = Limits::new(&robot);
    for _ in 0..50 {
        let (q, ..) = random_state(&robot, &mut rng, 1.0);
        limits.set(&robot, &q, &InputVector::zeros(), PERIOD);
        let wild =
            Inputs::from_fn(
                |i, _| if i < robot.joint_count() + 2 { rng.random_range(-9.0..9.0) } else { 0.0 },
            );
        let first = limits.scaled_first(&wild);
        assert!(limits.allow(&first));
        let scale = first[(0, 0)] / wild[(0, 0)];
        assert!((first.column(0) - wild.column(0) * scale).amax() < 1e-12, "scaled as a whole");
        assert_eq!(first.columns(1, HORIZON - 1).amax(), 0.0);
    }
}

#[test]
fn a_reference_that_is_not_finite_stops_the_robot() {
    let robot = robot();
    let q = Configuration {
        base: PlanarPose { position: Point::origin(), yaw: 0.0 },
        joints: robot.postures[0].joints,
    };
    let b = input_matrix(&robot.kinematics(&q));
    let mut limits = Limits::new(&robot);
    limits.set(&robot, &q, &InputVector::zeros(), PERIOD);
    for bad in [f64::NAN, f64::INFINITY, 1e200] {
        let plan = Mpc::default().solve(&ClosedForm::new(&b, 1000.0, 1.0), &limits, &Reference::repeat(bad));
        assert_eq!(plan.outcome, SolveOutcome::Fallback(Failure::NotFinite));
        assert_eq!(plan.inputs, Inputs::zeros());
    }
}

#[test]
fn candidates_hold_the_grasp_and_keep_all_limits() {
    let (robot, mut rng) = (robot(), ChaCha8Rng::seed_from_u64(4));
    let mut limits = Limits::new(&robot);
    let (mut found, mut full) = (Vec::new(), 0);
    for (set, share) in [(CandidateSet::Arm, 1.0), (CandidateSet::WholeBody, 1.0), (CandidateSet::Arm, 0.25)]
    {
        for _ in 0..100 {
            let (q, at, _) = random_state(&robot, &mut rng, 1.0);
            limits.set(&robot, &q, &InputVector::zeros(), PERIOD);
            let around = Neighbourhood {
                robot: &robot,
                configuration: &q,
                kinematics: &at,
                limits: &limits,
                period: PERIOD,
                share,
            };
            around.candidates(set, &mut found);
            assert_eq!(found[0].configuration, q);
            assert!(found.len() <= 15);
            full += usize::from(found.len() == 15);
            for candidate in &found {
                let off = pose_difference(&robot.grasp_pose(&candidate.configuration), &at.grasp);
                assert!(off.norm() < 1e-6);
                for (i, joint) in robot.joints.iter().enumerate() {
                    let there = candidate.configuration.joints[i];
                    assert!((joint.lower..=joint.upper).contains(&there), "{}", joint.name);
                    assert!(
                        (there - q.joints[i]).abs() <= share * joint.rate_limit * PERIOD + 1e-12,
                        "{}",
                        joint.name
                    );
                }
                let moved = robot.advance(&q, &candidate.rates, PERIOD);
                assert!((moved.base.position - candidate.configuration.base.position).norm() < 1e-12);
                assert!((moved.joints - candidate.configuration.joints).norm() < 1e-12);
            }
        }
    }
    assert!(full > 150, "{full} of 200 sets are full");
}

/// Eq. (8) by 15 times options solutions of eq. (7) with all limits.
fn brute_force(problem: &PoseProblem, settings: &ControlSettings, found: &[Candidate]) -> Vec<f64> {
    let (mut mpc, mut limits) = (Mpc::default(), Limits::new(problem.robot));
    let total = |candidate: &Candidate| {
        let b = problem.robot.kinematics(&candidate.configuration).jacobian * PERIOD;
        let free = ClosedForm::new(&b, 1000.0, 1.0);
        limits.set(problem.robot, &candidate.configuration, &candidate.rates, PERIOD);
        let costs = problem
            .references
            .iter()
            .zip(problem.weights)
            .map(|(reference, weight)| weight * mpc.solve(&free, &limits, reference).cost);
        costs.sum::<f64>() + motion_cost(problem.robot, candidate, problem.configuration, settings)
    };
    found.iter().map(total).collect()
}

#[test]
fn the_pose_chosen_is_the_exact_minimum_over_candidates() {
    let (robot, mut rng) = (robot(), ChaCha8Rng::seed_from_u64(5));
    let (mut poses, mut mpc, mut limits) = (PoseOptimiser::default(), Mpc::default(), Limits::new(&robot));
    let (mut moved, mut solved, mut problems) = (0, 0, 0);
    for case in 0..90 {
        let set = if case % 2 == 0 { CandidateSet::Arm } else { CandidateSet::WholeBody };
        let settings = ControlSettings { candidates: set, ..ControlSettings::default() };
        let (q, at, references) = random_state(&robot, &mut rng, [1.0, 2.0, 4.0][case % 3]);
        let weights: [f64; 4] = std::array::from_fn(|_| rng.random_range(0.0..1.0));
        let problem = PoseProblem {
            robot: &robot,
            configuration: &q,
            kinematics: &at,
            references: &references,
            weights: &weights,
            obstacles: None,
            base: None,
            period: PERIOD,
            share: 1.0,
        };
        let choice = poses.choose(&problem, &settings, &mut limits, &mut mpc);
        let totals = brute_force(&problem, &settings, poses.candidates());
        let least = totals.iter().copied().fold(f64::INFINITY, f64::min);
        let expected = totals.iter().position(|t| *t <= least + super::pose::TIE).unwrap();
        assert_eq!(choice.index, expected, "case {case}: {totals:?}");
        if case % 3 == 0 {
            solved += choice.solved;
            problems += 4 * choice.candidates;
        }
        moved += usize::from(choice.index != 0);
    }
    assert!(moved > 45, "{moved}");
    assert!(2 * solved < problems, "{solved} of {problems} solved");
}

#[test]
fn in_the_planar_posture_both_ways_out_are_equal_and_the_first_is_taken() {
    let robot = robot();
    let base = PlanarPose { position: Point::origin(), yaw: 0.0 };
    let q = Configuration { base, joints: robot.postures[0].joints };
    let at = robot.kinematics(&q);
    let straight = Reference::from_fn(|row, t| if row == 0 { 0.1 * (t + 1) as f64 } else { 0.0 });
    let problem = PoseProblem {
        robot: &robot,
        configuration: &q,
        kinematics: &at,
        references: &[straight],
        weights: &[1.0],
        obstacles: None,
        base: None,
        period: PERIOD,
        share: 1.0,
    };
    let (mut poses, mut mpc, mut limits) = (PoseOptimiser::default(), Mpc::default(), Limits::new(&robot));
    let choice = poses.choose(&problem, &ControlSettings::default(), &mut limits, &mut mpc);
    assert_eq!(choice.candidates, 15);
    assert!(choice.index <= 7, "{}", choice.index);
}
