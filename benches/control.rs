//! Control against the slow obvious way: the closed form and the constrained MPC against a sparse program in
//! clarabel, pose optimisation against 15 x options such programs (same winner?), and a full control tick
//! against its budget.

mod rows;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, ZeroConeT};
use cocarry::control::{
    Candidate, ClosedForm, ControlSettings, HORIZON, Limits, ModalReference, Mpc, PoseOptimiser, PoseProblem,
    Reference, RobotObstacles, SolveOutcome, motion_cost,
};
use cocarry::episode::{self, Episode, Manipulator};
use cocarry::geometry::{PlanarPose, Point, direction};
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::policy::Method;
use cocarry::robot::{Configuration, InputJacobian, InputVector, JointVector, Kinematics, Robot};
use cocarry_studies::paper::{ENVIRONMENTS, EXAMPLE_HUMAN};
use criterion::Criterion;
use nalgebra::Vector6;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use rows::{Against, Bench, Declared};
use std::hint::black_box;
use std::time::{Duration, Instant};

const PERIOD: f64 = 0.2;
/// States on which the winner is compared: in the table, and with `--winners`.
const STATES: u64 = 500;
const ALL_STATES: u64 = 10_000;
/// States on which the times are compared.
const TIMED: u64 = 200;
/// Budgets of a control tick, us.
const FREE_BUDGET_US: f64 = 250.0;
const LIMITED_BUDGET_US: f64 = 1000.0;
/// Share of the joints' speed at which limits are active in most ticks.
const SLOW: f64 = 0.15;

const ROWS: &[Declared] = &[
    Declared {
        name: "eq. (7) in closed form",
        unit: "us",
        cases: &["mpc/closed form"],
        against: &[Against::Peer("one sparse program in clarabel", &["mpc/naive"])],
    },
    Declared {
        name: "eq. (7) with active limits",
        unit: "us",
        cases: &["mpc/with active limits"],
        against: &[Against::Peer("that program", &["mpc/naive"])],
    },
    Declared {
        name: "eq. (8), 15 candidates x 4 options, random states",
        unit: "us",
        cases: &["pose/exact"],
        against: &[Against::Peer("such a program for each of the 60", &["pose/naive"])],
    },
    Declared {
        name: "states of 500 in which those programs choose otherwise",
        unit: "",
        cases: &["pose/other winners"],
        against: &[],
    },
    Declared {
        name: "control tick, the human leads, median",
        unit: "us",
        cases: &TICKS[0],
        against: &[Against::Budget(FREE_BUDGET_US)],
    },
    Declared {
        name: "the same, joints at 15 % of their speed",
        unit: "us",
        cases: &TICKS[1],
        against: &[Against::Budget(LIMITED_BUDGET_US)],
    },
    Declared {
        name: "99th percentile of these ticks",
        unit: "us",
        cases: &SLOWEST,
        against: &[Against::Budget(LIMITED_BUDGET_US)],
    },
    Declared { name: "share of these ticks with active limits", unit: "%", cases: &LIMITED, against: &[] },
];
/// Medians of ticks with the joints as they are, and with slow ones, in the four environments.
const TICKS: [[&str; 4]; 2] =
    [["ticks/1", "ticks/2", "ticks/3", "ticks/4"], ["slow/1", "slow/2", "slow/3", "slow/4"]];
const SLOWEST: [&str; 4] = ["slowest/1", "slowest/2", "slowest/3", "slowest/4"];
const LIMITED: [&str; 4] = ["limited/1", "limited/2", "limited/3", "limited/4"];

/// An arm anywhere inside its limits, and four ways that it may be led at walking speed.
struct BenchState {
    q: Configuration,
    at: Kinematics,
    references: Vec<Reference>,
    weights: [f64; 4],
}

fn random_state(robot: &Robot, seed: u64) -> BenchState {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut joints = JointVector::zeros();
    for (q, joint) in joints.iter_mut().zip(&robot.joints) {
        *q = rng.random_range(joint.lower.max(-3.0)..joint.upper.min(3.0));
    }
    let base = PlanarPose { position: Point::new(1.0, -2.0), yaw: rng.random_range(-3.0..3.0) };
    let q = Configuration { base, joints };
    let at = robot.kinematics(&q);
    let references = (0..4)
        .map(|_| {
            let heading = direction(rng.random_range(-3.0..3.0)) * (0.5 * PERIOD);
            let turn = rng.random_range(-0.16..0.16);
            let offset = Vector6::from_fn(|_, _| rng.random_range(-0.02..0.02));
            let way = [heading.x, heading.y, 0.0, 0.0, 0.0, turn];
            Reference::from_fn(|row, t| offset[row] + way[row] * (t + 1) as f64)
        })
        .collect();
    BenchState { q, at, references, weights: std::array::from_fn(|_| rng.random_range(0.0..1.0)) }
}

fn problem<'a>(robot: &'a Robot, state: &'a BenchState) -> PoseProblem<'a> {
    PoseProblem {
        robot,
        configuration: &state.q,
        kinematics: &state.at,
        references: &state.references,
        weights: &state.weights,
        obstacles: None,
        base: None,
        period: PERIOD,
        share: 1.0,
    }
}

/// Eq. (7) with all limits as it is written: a sparse program over inputs, states and joint positions. Its
/// cost.
fn naive_mpc(robot: &Robot, b: &InputJacobian, candidate: &Candidate, reference: &Reference) -> f64 {
    let n = robot.joint_count();
    let m = n + 2;
    let (states, positions) = (m * HORIZON, (m + 6) * HORIZON);
    let size = positions + n * HORIZON;
    let (input, state) = (|t: usize, i: usize| t * m + i, |t: usize, i: usize| states + t * 6 + i);
    let position = |t: usize, i: usize| positions + t * n + i;
    let mut weights = vec![0.0; size];
    weights[..states].fill(2.0);
    weights[states..positions].fill(2000.0);
    let p = CscMatrix::new(size, size, (0..=size).collect(), (0..size).collect(), weights);
    let mut linear = vec![0.0; size];
    let mut constant = 0.0;
    let (mut rows, mut columns, mut values, mut right) = (vec![], vec![], vec![], vec![]);
    let mut row = 0;
    let mut entry = |row: usize, column: usize, value: f64| {
        rows.push(row);
        columns.push(column);
        values.push(value);
    };
    for t in 0..HORIZON {
        for i in 0..6 {
            linear[state(t, i)] = -2000.0 * reference[(i, t)];
            constant += 1000.0 * math::squared(reference[(i, t)]);
            entry(row, state(t, i), 1.0);
            if t > 0 {
                entry(row, state(t - 1, i), -1.0);
            }
            for j in 0..m {
                entry(row, input(t, j), -b[(i, j)]);
            }
            right.push(0.0);
            row += 1;
        }
        for i in 0..n {
            entry(row, position(t, i), 1.0);
            if t > 0 {
                entry(row, position(t - 1, i), -1.0);
            }
            entry(row, input(t, i + 2), -PERIOD);
            right.push(if t == 0 { candidate.configuration.joints[i] } else { 0.0 });
            row += 1;
        }
    }
    let equalities = row;
    for t in 0..HORIZON {
        for j in 0..m {
            let limit = if j < 2 { robot.drive.rim_speed_limit } else { robot.joints[j - 2].rate_limit };
            let taken = if t == 0 { candidate.rates[j] } else { 0.0 };
            for sign in [1.0, -1.0] {
                entry(row, input(t, j), sign);
                right.push(limit - sign * taken);
                row += 1;
            }
        }
        for (i, joint) in robot.joints.iter().enumerate() {
            for (sign, limit) in [(1.0, joint.upper), (-1.0, -joint.lower)] {
                if limit.is_finite() {
                    entry(row, position(t, i), sign);
                    right.push(limit);
                    row += 1;
                }
            }
        }
    }
    let a = CscMatrix::new_from_triplets(row, size, rows, columns, values);
    let cones = [ZeroConeT(equalities), NonnegativeConeT(row - equalities)];
    let settings = DefaultSettingsBuilder::default().verbose(false).build().expect("settings");
    let mut solver = DefaultSolver::new(&p, &linear, &a, &right, &cones, settings).expect("a program");
    solver.solve();
    solver.solution.obj_val + constant
}

/// Eq. (8) by one such program for every candidate and option: all totals.
fn naive_totals(robot: &Robot, state: &BenchState, found: &[Candidate]) -> Vec<f64> {
    let total = |candidate: &Candidate| {
        let b = robot.kinematics(&candidate.configuration).jacobian * PERIOD;
        let costs = state.references.iter().zip(state.weights);
        costs.map(|(reference, weight)| weight * naive_mpc(robot, &b, candidate, reference)).sum::<f64>()
            + motion_cost(robot, candidate, &state.q, &ControlSettings::default())
    };
    found.iter().map(total).collect()
}

fn mpc(c: &mut Criterion) {
    let robot = Robot::built_in().expect("the built-in robot");
    let state = random_state(&robot, 0);
    let b = state.at.jacobian * PERIOD;
    let mut limits = Limits::new(&robot);
    limits.set(&robot, &state.q, &InputVector::zeros(), PERIOD);
    let mut group = c.benchmark_group("mpc");
    group.bench_function("closed form", |bench| {
        bench.iter(|| {
            let reference = ModalReference::new(&state.references[0]);
            black_box(ClosedForm::new(&b, 1000.0, 1.0).inputs(&reference))
        });
    });
    let free = ClosedForm::new(&b, 1000.0, 1.0);
    let (mut solver, hurried) = (Mpc::default(), state.references[0] * 4.0);
    group.bench_function("with active limits", |bench| {
        bench.iter(|| black_box(solver.solve(&free, &limits, &hurried)));
    });
    let candidate = Candidate::at_rest(&state.q, &state.at);
    group.bench_function("naive", |bench| {
        bench.iter(|| black_box(naive_mpc(&robot, &b, &candidate, &hurried)));
    });
    group.finish();
}

/// Times of eq. (8), each on the next of some random states.
fn pose(c: &mut Criterion) {
    let robot = Robot::built_in().expect("the built-in robot");
    let settings = ControlSettings::default();
    let (mut poses, mut solver, mut limits) = (PoseOptimiser::default(), Mpc::default(), Limits::new(&robot));
    let states: Vec<BenchState> = (0..TIMED).map(|seed| random_state(&robot, seed)).collect();
    let mut group = c.benchmark_group("pose");
    let mut next = states.iter().cycle();
    group.bench_function("exact", |bench| {
        bench.iter(|| {
            let state = next.next().expect("a state");
            black_box(poses.choose(&problem(&robot, state), &settings, &mut limits, &mut solver));
        });
    });
    let candidates: Vec<Vec<Candidate>> = states
        .iter()
        .map(|state| {
            poses.choose(&problem(&robot, state), &settings, &mut limits, &mut solver);
            poses.candidates().to_vec()
        })
        .collect();
    let mut next = states.iter().zip(&candidates).cycle();
    group.sample_size(20).measurement_time(Duration::from_secs(4));
    group.bench_function("naive", |bench| {
        bench.iter(|| {
            let (state, candidates) = next.next().expect("a state");
            black_box(naive_totals(&robot, state, candidates))
        });
    });
    group.finish();
}

/// In how many of so many states the programs have another winner.
fn other_winners(states: u64) -> usize {
    let robot = Robot::built_in().expect("the built-in robot");
    let settings = ControlSettings::default();
    let differences: Vec<f64> = (0..states)
        .into_par_iter()
        .filter_map(|seed| {
            let state = random_state(&robot, seed);
            let mut poses = PoseOptimiser::default();
            let (mut solver, mut limits) = (Mpc::default(), Limits::new(&robot));
            let chosen = poses.choose(&problem(&robot, &state), &settings, &mut limits, &mut solver);
            let totals = naive_totals(&robot, &state, poses.candidates());
            let least = totals.iter().copied().fold(f64::INFINITY, f64::min);
            let other = totals.iter().position(|t| *t <= least).unwrap_or(0);
            (other != chosen.index).then(|| (totals[chosen.index] - least) / least)
        })
        .collect();
    let worst = differences.iter().copied().fold(0.0, f64::max);
    println!(
        "other winners in {} of {states} states; the two winners' costs differ by at most {worst:.1e} of themselves",
        differences.len()
    );
    differences.len()
}

/// Times of all ticks of episodes led by a human, us, and how many of these had a limit active; the arm's rate
/// limits are `share` of what they are.
fn tick_times(environment: usize, share: f64) -> (Vec<f64>, usize) {
    let mut robot = Robot::built_in().expect("the built-in robot");
    for joint in &mut robot.joints {
        joint.rate_limit *= share;
    }
    let world = ENVIRONMENTS[environment].world().expect("a built-in world");
    let options = OptionSet::new(&world, 10.0).expect("its options");
    let obstacles = RobotObstacles::new(&world);
    let settings =
        episode::EpisodeSettings { method: Method::HUMAN_LED, ..episode::EpisodeSettings::default() };
    let posture = robot.postures[0].joints;
    let manipulator =
        Manipulator { robot: &robot, posture, control: ControlSettings::default(), obstacles: &obstacles };
    let (mut times, mut limited) = (Vec::new(), 0);
    for _ in 0..5 {
        let mut episode = Episode::builder(&options, &settings, EXAMPLE_HUMAN)
            .with_robot(manipulator)
            .begin()
            .expect("room");
        loop {
            let begun = Instant::now();
            let ended = black_box(episode.step()).is_some();
            let took = begun.elapsed();
            if ended {
                break;
            }
            let robot = episode.tick().robot.expect("a robot");
            let in_pose = robot.preparation.is_some_and(|p| p.constrained > 0);
            limited += usize::from(in_pose || robot.outcome != SolveOutcome::Unconstrained);
            times.push(took.as_secs_f64() * 1e6);
        }
    }
    times.sort_unstable_by(f64::total_cmp);
    (times, limited)
}

/// All ticks of episodes: planning, 15 x 4 pose optimisation, MPC, obstacles.
fn ticks(bench: &mut Bench) {
    for (medians, share) in TICKS.iter().zip([1.0, SLOW]) {
        for environment in 0..ENVIRONMENTS.len() {
            let (times, limited) = tick_times(environment, share);
            bench.give(medians[environment], times[times.len() / 2]);
            if share < 1.0 {
                bench.give(SLOWEST[environment], times[times.len() * 99 / 100]);
                bench.give(LIMITED[environment], 100.0 * limited as f64 / times.len() as f64);
            }
        }
    }
}

fn main() {
    // a quarter of an hour on two cores, and no row
    if std::env::args().any(|argument| argument == "--winners") {
        other_winners(ALL_STATES);
        return;
    }
    rows::run("control", ROWS, |criterion, bench| {
        mpc(criterion);
        pose(criterion);
        // what is not one function is measured with all others alone
        if bench.is_whole() {
            ticks(bench);
            bench.give("pose/other winners", other_winners(STATES) as f64);
        }
    });
}
