//! A manipulator that holds its end of the object: what it does in each step of the loop.

use super::team::{KinematicTeam, Moved, Onward, PhysicalTeam, Walk};
use super::tick::{Preparation, RobotTick};
use crate::control::{
    self, Avoid, Candidate, ClosedForm, Intent, Limits, Mpc, PoseCriterion, PoseOptimiser, PoseProblem,
    Reference, RobotObstacles,
};
use crate::coordination::Mode;
use crate::geometry::{Path, PlanarPose, Point, Pose};
use crate::options::{OptionSet, Progress};
use crate::preference::ChoiceDistribution;
use crate::robot::{Configuration, InputVector, JointVector, Robot};
use crate::simulation::{KinematicPlant, Observation};

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
    pub obstacles: &'a RobotObstacles,
}

/// The robot's side of an episode.
#[derive(Clone, Debug)]
pub(super) struct Carrier<'a> {
    manipulator: Manipulator<'a>,
    walk: Walk,
    team: Team<'a>,
    intent: Intent,
    poses: PoseOptimiser,
    limits: Limits,
    mpc: Mpc,
    paths: Vec<Path>,
    references: Vec<Reference>,
    weights: Vec<f64>,
    /// What the step decided: q* with the rates that lead there, and u.
    target: Candidate,
    input: InputVector,
}

#[derive(Clone, Debug)]
enum Team<'a> {
    Kinematic(KinematicTeam<'a>),
    Physical(Box<PhysicalTeam>),
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
    /// On the kinematic plant, the grasp at `start`.
    pub fn kinematic(manipulator: Manipulator<'a>, walk: Walk, options: usize, start: PlanarPose) -> Self {
        let Manipulator { robot, posture, .. } = manipulator;
        let plant = KinematicPlant::place(robot, &posture, &start);
        Self::new(manipulator, walk, options, Team::Kinematic(KinematicTeam { robot, plant, human: start }))
    }

    /// On the physical plant.
    pub fn physical(manipulator: Manipulator<'a>, walk: Walk, options: usize, team: PhysicalTeam) -> Self {
        Self::new(manipulator, walk, options, Team::Physical(Box::new(team)))
    }

    fn new(manipulator: Manipulator<'a>, walk: Walk, options: usize, team: Team<'a>) -> Self {
        let at_origin = PlanarPose { position: Point::origin(), yaw: 0.0 };
        let configuration = Configuration { base: at_origin, joints: manipulator.posture };
        Self {
            manipulator,
            walk,
            team,
            intent: Intent::new(manipulator.control.direction_concentration),
            poses: PoseOptimiser::default(),
            limits: Limits::new(manipulator.robot),
            mpc: Mpc::default(),
            // longer than the ways that worlds have: what is left of an option may grow when the team turns away from it
            paths: (0..options).map(|_| Path::with_capacity(64)).collect(),
            references: Vec::with_capacity(options),
            weights: Vec::with_capacity(options),
            target: Candidate { configuration, rates: InputVector::zeros() },
            input: InputVector::zeros(),
        }
    }

    /// Where the robot is.
    pub fn configuration(&self) -> &Configuration {
        match &self.team {
            Team::Kinematic(team) => team.plant.configuration(),
            Team::Physical(team) => &team.seen.configuration,
        }
    }

    /// What is seen of the physical plant; `None` on the other.
    pub fn observation(&self) -> Option<&Observation> {
        match &self.team {
            Team::Kinematic(_) => None,
            Team::Physical(team) => Some(&team.seen),
        }
    }

    /// `world_from_link` of every link; on the physical plant as physics has it.
    pub fn link_poses(&self) -> Vec<Pose> {
        match &self.team {
            Team::Kinematic(team) => self.manipulator.robot.link_poses(team.plant.configuration()),
            Team::Physical(team) => team.link_poses(),
        }
    }

    /// s on the kinematic plant, where the human is a pose; `None` on the other, where it is a body.
    pub fn human(&self) -> Option<&PlanarPose> {
        match &self.team {
            Team::Kinematic(team) => Some(&team.human),
            Team::Physical(_) => None,
        }
    }

    /// The path under way is left `along` (m) on it for another that begins there.
    pub fn turn(&mut self, path: &Path, along: f64) {
        if let Team::Physical(team) = &mut self.team {
            team.turn(path, along);
        }
    }

    /// Decides q* (eq. 8, while the human leads) and u (eq. 7).
    pub fn decide(&mut self, situation: &Situation) -> RobotTick {
        let Manipulator { robot, control, obstacles, .. } = self.manipulator;
        let period = self.walk.period;
        let q = *self.configuration();
        let at = robot.kinematics(&q);
        let tracked = self.anticipate(situation, &at.grasp);
        let near = (control.avoid != Avoid::Nothing).then_some((obstacles, control.avoid));
        let human = match &self.team {
            Team::Kinematic(team) => team.human,
            Team::Physical(team) => team.human(situation.path),
        };
        let mut tick = RobotTick::at(&q, human);
        if tracked.is_none() {
            // the robot knows its own way
            let onward = Onward { path: situation.path, along: situation.along, turn: None };
            let way = self.reference(&onward, self.walk.speed, situation.mode, &at.grasp);
            self.references.clear();
            self.references.push(way);
            self.weights.clear();
            self.weights.push(1.0);
        }
        let to_track = self.references[tracked.unwrap_or(0)];
        self.target = Candidate { configuration: q, rates: InputVector::zeros() };
        if tracked.is_some() || control.prepare_while_leading {
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
            tick.preparation = Some(Preparation {
                tracked,
                candidate: chosen.index,
                candidates: chosen.candidates,
                constrained: chosen.solved,
            });
            tick.pose_cost = chosen.motion_cost;
            self.target = chosen.candidate;
        }
        let Candidate { configuration: target, rates } = self.target;
        let input_matrix = robot.kinematics(&target).jacobian * period;
        let free = ClosedForm::new(&input_matrix, control.state_weight, control.input_weight);
        self.limits.set(robot, &target, &rates, period);
        if let Some((obstacles, avoid)) = near {
            obstacles.half_planes(avoid, robot, &target, &free.inputs(&to_track), period, &mut self.limits);
        }
        let plan = self.mpc.solve(&free, &self.limits, &to_track);
        self.input = plan.inputs.column(0).into_owned();
        tick.input = self.input;
        tick.outcome = plan.outcome;
        tick.least_singular_value = free.least_singular_value();
        tick.control_effort = control.input_weight * self.input.norm_squared();
        tick.base_clearance = obstacles.clearance(q.base.position, robot.drive.base_radius);
        tick
    }

    /// While the human leads: s_o(1..H) of every option, from where the human is, and which of them to track.
    fn anticipate(&mut self, situation: &Situation, grasp: &Pose) -> Option<usize> {
        if situation.mode == Mode::RobotLed {
            return None;
        }
        let Walk { period, speed, .. } = self.walk;
        let probabilities = situation.choice.probabilities();
        let position = match &self.team {
            Team::Kinematic(team) => team.human.position,
            Team::Physical(team) => team.seen.hand.translation.vector.xy().into(),
        };
        let tracked = self.intent.observe(position, probabilities, period);
        let observed = self.intent.speed().unwrap_or(speed);
        self.references.clear();
        for option in 0..probabilities.len() {
            situation.options.write_path(situation.progress, option, &mut self.paths[option]);
            let onward =
                Onward { path: situation.path, along: situation.along, turn: Some(&self.paths[option]) };
            let reference = self.reference(&onward, observed, situation.mode, grasp);
            self.references.push(reference);
        }
        let step = observed * period;
        let team = &self.team;
        self.intent.expect(self.paths.iter().map(|path| match team {
            Team::Kinematic(_) => path.point_at(step).map_or(Default::default(), |p| p - position),
            Team::Physical(team) => {
                let onward = Onward { path: situation.path, along: situation.along, turn: Some(path) };
                team.hand_step(&onward, step)
            }
        }));
        self.weights.clear();
        let uniform = 1.0 / probabilities.len() as f64;
        let criterion = self.manipulator.control.criterion;
        self.weights.extend(probabilities.iter().enumerate().map(|(option, p)| match criterion {
            PoseCriterion::Expected | PoseCriterion::Manipulability => *p,
            PoseCriterion::Uniform => uniform,
            PoseCriterion::Tracked => f64::from(u8::from(option == tracked)),
        }));
        Some(tracked)
    }

    /// s(1..H) along a way.
    fn reference(&self, onward: &Onward, speed: f64, mode: Mode, grasp: &Pose) -> Reference {
        match &self.team {
            Team::Kinematic(team) => team.reference(onward, speed, &self.walk, grasp),
            Team::Physical(team) => team.reference(onward, speed, mode, &self.walk, grasp),
        }
    }

    /// Moves the team and books what the step cost: ||x - s||_Q^2, ||u||_R^2 and kappa ||q* - q_c||^2 (Sec. V-C). Returns how far along
    /// `path` the team is now, m: on the kinematic plant, where it walked to, `along` at `position`; on the physical one, where the object is.
    pub fn act(
        &mut self,
        mode: Mode,
        path: &Path,
        (from, along, position): (f64, f64, Point),
        tick: &mut RobotTick,
    ) -> f64 {
        let Candidate { configuration, rates } = self.target;
        let moved: Moved = match &mut self.team {
            Team::Kinematic(team) => {
                team.step(&configuration, &self.input, (path, along, position), &self.walk)
            }
            Team::Physical(team) => team.step(&(rates + self.input), mode, (path, from), &self.walk),
        };
        tick.position_error = moved.error.fixed_rows::<3>(0).norm();
        tick.orientation_error = moved.error.fixed_rows::<3>(3).norm();
        tick.tracking_cost = self.manipulator.control.state_weight * moved.error.norm_squared();
        tick.physics = moved.physics;
        moved.along
    }
}
