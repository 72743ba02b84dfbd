//! A manipulator that holds its end of the object: what it does in each step of the loop.

use super::tick::{Pursuit, RobotTick};
use crate::control;
use crate::control::{
    BaseObstacles, ClosedForm, HORIZON, Inputs, Intent, Limits, Mpc, PoseCriterion, PoseOptimiser,
    PoseProblem, Reference, reference,
};
use crate::coordination::Mode;
use crate::geometry::{Path, PlanarPose};
use crate::options::{OptionSet, Progress, nominal_trajectory, turned};
use crate::preference::ChoiceDistribution;
use crate::robot::{Configuration, InputVector, JointVector, Robot, pose_difference};
use crate::simulation::KinematicPlant;

/// Who carries, from which posture, controlled how.
#[derive(Clone, Copy, Debug)]
pub struct Manipulator<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Its joint positions at the start.
    pub posture: JointVector,
    /// The controller.
    pub control: control::Settings,
    /// The obstacles of the world.
    pub obstacles: &'a BaseObstacles,
}

/// How the team moves: what the robot knows of its walk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk {
    pub period: f64,
    pub speed: f64,
    pub yaw_rate: f64,
}

/// The robot's side of an episode.
#[derive(Clone, Debug)]
pub(super) struct Carrier<'a> {
    manipulator: Manipulator<'a>,
    walk: Walk,
    plant: Option<KinematicPlant<'a>>,
    /// s(k): the human's state, as the pose that the grasp should have.
    human: PlanarPose,
    intent: Intent,
    poses: PoseOptimiser,
    limits: Limits,
    mpc: Mpc,
    paths: Vec<Path>,
    references: Vec<Reference>,
    weights: Vec<f64>,
    /// What the step decided: q* and u.
    target: Option<Configuration>,
    input: InputVector,
}

/// What the loop knows when the robot is to act.
pub(super) struct Situation<'s> {
    pub mode: Mode,
    pub options: &'s OptionSet,
    pub progress: &'s Progress,
    /// P_o from here.
    pub choice: &'s ChoiceDistribution,
    /// The path that the team is on and how far along it is, m: known to the robot while it leads.
    pub path: &'s Path,
    pub along: f64,
}

impl<'a> Carrier<'a> {
    pub fn new(manipulator: Manipulator<'a>, walk: Walk, options: usize) -> Self {
        Self {
            manipulator,
            walk,
            plant: None,
            human: PlanarPose { position: Default::default(), yaw: 0.0 },
            intent: Intent::new(manipulator.control.direction_concentration),
            poses: PoseOptimiser::default(),
            limits: Limits::new(manipulator.robot),
            mpc: Mpc::default(),
            // longer than the ways that worlds have: what is left of an option may grow when the team turns away from it
            paths: (0..options).map(|_| Path::with_capacity(64)).collect(),
            references: Vec::with_capacity(options),
            weights: Vec::with_capacity(options),
            target: None,
            input: InputVector::zeros(),
        }
    }

    /// Where the robot is; `None` before the first step.
    pub fn configuration(&self) -> Option<&Configuration> {
        self.plant.as_ref().map(KinematicPlant::configuration)
    }

    /// Decides q* (eq. 8, while the human leads) and u (eq. 7).
    pub fn decide(&mut self, situation: &Situation) -> RobotTick {
        let Manipulator { robot, posture, control, obstacles } = self.manipulator;
        let Walk { period, .. } = self.walk;
        if self.plant.is_none() {
            // the team starts facing its way
            let yaw = situation.path.heading_at(situation.along).unwrap_or(0.0);
            self.human = PlanarPose { position: situation.progress.position, yaw };
            self.plant = Some(KinematicPlant::place(robot, &posture, &self.human));
        }
        let q = self
            .plant
            .as_ref()
            .map_or(Configuration { base: self.human, joints: posture }, |p| *p.configuration());
        let at = robot.kinematics(&q);
        let tracked = self.anticipate(situation, &at.grasp);
        let near = control.obstacles.then_some(obstacles);
        let mut tick = RobotTick::at(&q, self.human);
        let (candidate, to_track) = match tracked {
            None => {
                let path = self.reference(situation.path, situation.along, self.walk.speed, &at.grasp);
                (crate::control::Candidate { configuration: q, rates: InputVector::zeros() }, path)
            }
            Some(option) => {
                let problem = PoseProblem {
                    robot,
                    configuration: &q,
                    kinematics: &at,
                    references: &self.references,
                    weights: &self.weights,
                    obstacles: near,
                    period,
                };
                let chosen = self.poses.choose(&problem, &control, &mut self.limits, &mut self.mpc);
                tick.pursuit = Some(Pursuit {
                    tracked: option,
                    candidate: chosen.index,
                    candidates: chosen.candidates,
                    constrained: chosen.solved,
                });
                tick.pose_cost = chosen.motion_cost;
                (chosen.candidate, self.references[option])
            }
        };
        let input_matrix = robot.kinematics(&candidate.configuration).jacobian * period;
        let free = ClosedForm::new(&input_matrix, control.state_weight, control.input_weight);
        self.limits.set(robot, &candidate.configuration, &candidate.rates, period);
        if let Some(obstacles) = near {
            let inputs: Inputs = free.inputs(&to_track);
            obstacles.half_planes(
                &robot.drive,
                &candidate.configuration.base,
                &inputs,
                period,
                &mut self.limits,
            );
        }
        let plan = self.mpc.solve(&free, &self.limits, &to_track);
        self.input = plan.inputs.column(0).into_owned();
        self.target = Some(candidate.configuration);
        tick.input = self.input;
        tick.outcome = plan.outcome;
        tick.least_singular_value = free.least_singular_value();
        tick.control_effort = control.input_weight * self.input.norm_squared();
        tick.base_clearance = obstacles.clearance(q.base.position, robot.drive.base_radius);
        tick
    }

    /// While the human leads: s_o(1..H) of every option, from where the human is, and which of them to track.
    fn anticipate(&mut self, situation: &Situation, grasp: &crate::geometry::Pose) -> Option<usize> {
        if situation.mode == Mode::RobotLed {
            return None;
        }
        let Walk { period, speed, .. } = self.walk;
        let probabilities = situation.choice.probabilities();
        let position = situation.progress.position;
        let tracked = self.intent.observe(position, probabilities, period);
        let observed = self.intent.speed().unwrap_or(speed);
        self.references.clear();
        for option in 0..probabilities.len() {
            situation.options.write_path(situation.progress, option, &mut self.paths[option]);
            let reference = self.reference(&self.paths[option], 0.0, observed, grasp);
            self.references.push(reference);
        }
        let step = observed * period;
        self.intent.expect(
            self.paths.iter().map(|path| path.point_at(step).map_or(Default::default(), |p| p - position)),
        );
        self.weights.clear();
        let uniform = 1.0 / probabilities.len() as f64;
        self.weights.extend(probabilities.iter().enumerate().map(|(option, p)| {
            match self.manipulator.control.criterion {
                PoseCriterion::Expected | PoseCriterion::Manipulability => *p,
                PoseCriterion::Uniform => uniform,
                PoseCriterion::Tracked => f64::from(u8::from(option == tracked)),
            }
        }));
        Some(tracked)
    }

    /// s(1..H) along a path from `along` (m), from the human's present heading.
    fn reference(&self, path: &Path, along: f64, speed: f64, grasp: &crate::geometry::Pose) -> Reference {
        let Walk { period, yaw_rate, .. } = self.walk;
        let trajectory =
            nominal_trajectory(path, along, self.human.yaw, speed, yaw_rate, period).take(HORIZON);
        reference(trajectory, grasp, self.manipulator.robot.grasp_height)
    }

    /// Moves the robot, now that the human has walked to where `path` is after `along` (m), and books what the step cost: ||x - s||_Q^2,
    /// ||u||_R^2 and kappa ||q* - q_c||^2 (Sec. V-C).
    pub fn act(&mut self, progress: &Progress, path: &Path, along: f64, tick: &mut RobotTick) {
        let Walk { period, yaw_rate, .. } = self.walk;
        if let Some(tangent) = path.heading_at(along) {
            self.human.yaw = turned(self.human.yaw, tangent, yaw_rate * period);
        }
        self.human.position = progress.position;
        let (Some(plant), Some(target)) = (&mut self.plant, self.target.take()) else { return };
        plant.step(&target, &self.input, period);
        let error =
            pose_difference(&self.human.at_height(self.manipulator.robot.grasp_height), &plant.grasp());
        tick.position_error = error.fixed_rows::<3>(0).norm();
        tick.orientation_error = error.fixed_rows::<3>(3).norm();
        tick.tracking_cost = self.manipulator.control.state_weight * error.norm_squared();
    }
}
