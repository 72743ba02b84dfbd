//! A manipulator that holds its end of the object: what it does in each step of the loop.

use super::team::{
    ACCELERATION, Gait, KinematicTeam, Moved, Onward, PhysicalTeam, Walk, object_on_floor, on_floor,
};
use super::tick::{Preparation, RobotTick};
use super::way::{Ground, Turned};
use crate::control::{
    self, Avoid, Candidate, ClosedForm, Follower, Intent, Limits, Mpc, PoseCriterion, PoseOptimiser,
    PoseProblem, Reference, Rims, RobotObstacles, hold_base_to, rolled, seen_from_base, set_base,
};
use crate::coordination::Mode;
use crate::geometry::{Path, PlanarPose, Point, Pose, Widening, direction};
use crate::options::{OptionSet, Progress};
use crate::preference::ChoiceDistribution;
use crate::robot::{Configuration, InputVector, JointVector, Robot};
use crate::simulation::{KinematicPlant, Observation};
use serde::{Deserialize, Serialize};

/// DEVIATION (eq. 8): bodies take a new configuration at this share of their rate limits, so that what is linear in eq. (7) stays nearly so, and
/// rates are left for the grasp.
const UNHURRIED: f64 = 0.25;

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

/// What the robot decided a step from: all of eq. (8) that others need to check it.
#[derive(Clone, Copy, Debug)]
pub struct Decision<'e> {
    /// s_o(1..H) of every option while the human leads, else of the robot's own way alone; on the physical plant what the base, which
    /// follows its way, leaves of it for the arm.
    pub references: &'e [Reference],
    /// What each counts for in eq. (8): P_o, if nothing else is asked for.
    pub weights: &'e [f64],
    /// q*.
    pub target: &'e Configuration,
    /// What became of the candidates, in a step that has a [`Preparation`].
    pub poses: &'e PoseOptimiser,
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
    /// An option's path as the team walks it, and the way that the grasp has gone.
    onto: Path,
    widening: Widening,
    way: Vec<Point>,
    /// How far the base was behind the grasp at the start, m: as far it follows.
    distance: f64,
    /// What the step decided: q* with the rates that lead there, and u.
    target: Candidate,
    input: InputVector,
}

#[derive(Clone, Debug)]
enum Team<'a> {
    Kinematic(KinematicTeam<'a>),
    Physical(Box<PhysicalTeam>),
}

/// All of a carrier that later steps depend on, but for what it was made with.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct CarrierState {
    intent: Intent,
    team: TeamState,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
enum TeamState {
    Kinematic { human: PlanarPose, configuration: Configuration },
    Physical(Box<PhysicalTeam>),
}

impl CarrierState {
    /// Whether it is one of the physical plant.
    pub fn is_physical(&self) -> bool {
        matches!(self.team, TeamState::Physical(_))
    }
}

/// What the loop knows when the robot is to act.
pub(super) struct Situation<'s> {
    pub mode: Mode,
    pub gait: Gait,
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

    /// As it was when [`Carrier::state`] was asked for.
    pub fn resumed(manipulator: Manipulator<'a>, walk: Walk, options: usize, state: CarrierState) -> Self {
        let robot = manipulator.robot;
        let team = match state.team {
            TeamState::Kinematic { human, configuration } => {
                let plant = KinematicPlant::at(robot, configuration);
                Team::Kinematic(KinematicTeam { robot, plant, human })
            }
            TeamState::Physical(team) => Team::Physical(team),
        };
        Self { intent: state.intent, ..Self::new(manipulator, walk, options, team) }
    }

    /// What it has come to.
    pub fn state(&self) -> CarrierState {
        #[rustfmt::skip]
        let Self {
            intent, team,
            // given
            manipulator: _, walk: _, distance: _,
            // memory, and what every step decides anew
            poses: _, limits: _, mpc: _, paths: _, references: _, weights: _, onto: _, widening: _, way: _, target: _, input: _,
        } = self;
        let team = match team {
            Team::Kinematic(KinematicTeam { robot: _, plant, human }) => {
                TeamState::Kinematic { human: *human, configuration: *plant.configuration() }
            }
            Team::Physical(team) => TeamState::Physical(team.clone()),
        };
        CarrierState { intent: intent.clone(), team }
    }

    fn new(manipulator: Manipulator<'a>, walk: Walk, options: usize, team: Team<'a>) -> Self {
        let at_origin = PlanarPose { position: Point::origin(), yaw: 0.0 };
        let configuration = Configuration { base: at_origin, joints: manipulator.posture };
        let distance = manipulator.robot.grasp_pose(&configuration).translation.vector.x;
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
            onto: Path::with_capacity(64),
            widening: Widening::default(),
            way: Vec::with_capacity(64),
            distance,
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

    /// `path`, made for a point, as the team walks it.
    pub fn wide(&self, path: Path, options: &OptionSet) -> Path {
        match &self.team {
            Team::Kinematic(_) => path,
            Team::Physical(team) => team.wide(&path, self.ground(options)),
        }
    }

    /// The path under way is left `along` (m) on it for `next`, which begins there. Returns what the team walks then; `None` if there is
    /// no room to turn.
    pub fn turn(&mut self, path: &Path, along: f64, next: Path, options: &OptionSet) -> Option<Turned> {
        let ground = self.ground(options);
        match &mut self.team {
            Team::Kinematic(_) => Some(Turned { path: next, until: 0.0 }),
            Team::Physical(team) => team.turn(path, along, &next, ground),
        }
    }

    /// Where along `path` (m) the team, `along` it and with no room to turn here, had better step back to: no farther than `least`, and `None` if
    /// going on is as good. `next` is the path to turn onto, from where it is told that the team is.
    pub fn place_behind(
        &self,
        path: &Path,
        [least, along]: [f64; 2],
        next: impl Fn(Point) -> Path,
        options: &OptionSet,
    ) -> Option<f64> {
        match &self.team {
            Team::Kinematic(_) => None,
            Team::Physical(team) => team.place_behind(path, [least, along], next, self.ground(options)),
        }
    }

    fn ground<'g>(&self, options: &'g OptionSet) -> Ground<'g>
    where
        'a: 'g,
    {
        Ground { obstacles: self.manipulator.obstacles, options }
    }

    /// Decides q* (eq. 8, while the human leads) and u (eq. 7).
    pub fn decide(&mut self, situation: &Situation) -> RobotTick {
        let Manipulator { robot, control, obstacles, .. } = self.manipulator;
        let period = self.walk.period;
        let q = *self.configuration();
        let at = robot.kinematics(&q);
        let lead = self.lead(situation);
        let tracked = self.anticipate(situation, lead, &at.grasp);
        let near = (control.avoid != Avoid::Nothing).then_some((obstacles, control.avoid));
        let human = match &self.team {
            Team::Kinematic(team) => team.human,
            Team::Physical(team) => team.human(),
        };
        let mut tick = RobotTick::at(&q, human);
        if tracked.is_none() {
            // the robot knows its own way
            let onward = Onward { path: situation.path, along: situation.along, lead, turn: None };
            let led = (situation.mode, situation.gait);
            let way = self.reference(&onward, self.walk.speed, led, &at.grasp);
            self.references.clear();
            self.references.push(way);
            self.weights.clear();
            self.weights.push(1.0);
        }
        // on the physical plant, the base follows the way that the grasp has gone, and the arm does the rest
        let rims = self.base_on_way(situation, lead);
        if let Some(rims) = &rims {
            for reference in &mut self.references {
                *reference = seen_from_base(reference, &at.grasp, &q.base, &robot.drive, rims, period);
            }
        }
        self.target = Candidate { configuration: q, rates: InputVector::zeros() };
        if tracked.is_some() || control.prepare_while_leading {
            let problem = PoseProblem {
                robot,
                configuration: &q,
                kinematics: &at,
                references: &self.references,
                weights: &self.weights,
                obstacles: near,
                rims: rims.as_ref(),
                period,
                share: if rims.is_some() { UNHURRIED } else { 1.0 },
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
        let jacobian = robot.kinematics(&target).jacobian;
        let free = ClosedForm::new(&(jacobian * period), control.state_weight, control.input_weight);
        self.limits.set(robot, &target, &rates, period);
        let mut to_track = self.references[tracked.unwrap_or(0)];
        if let Some(rims) = &rims {
            to_track += rolled(&jacobian, rims, period);
        }
        if let Some((obstacles, avoid)) = near {
            let mut about = free.inputs(&to_track);
            if let Some(rims) = &rims {
                set_base(&mut about, rims);
            }
            obstacles.half_planes(avoid, robot, &target, &about, period, &mut self.limits);
        }
        if let Some(rims) = &rims {
            hold_base_to(rims, &mut self.limits);
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

    /// What the last step decided from.
    pub fn decision(&self) -> Decision<'_> {
        Decision {
            references: &self.references,
            weights: &self.weights,
            target: &self.target.configuration,
            poses: &self.poses,
        }
    }

    /// How far the human who leads is ahead of where the object is, m.
    fn lead(&self, situation: &Situation) -> f64 {
        match (&self.team, situation.mode) {
            (Team::Physical(team), Mode::HumanLed) => team.lead(situation.path, situation.along),
            _ => 0.0,
        }
    }

    /// Rim speeds with which the base follows on the way; `None` on the kinematic plant, which has no obstacles to get caught at.
    fn base_on_way(&mut self, situation: &Situation, lead: f64) -> Option<Rims> {
        let Team::Physical(team) = &self.team else { return None };
        let seen = self.seen_speed(team, situation.gait);
        let (pace, speed) = team.pace(situation.mode, situation.along + lead, seen);
        team.write_way_walked(situation.path, pace, &mut self.way);
        let Configuration { base, .. } = team.seen.configuration;
        let follower = Follower {
            way: &self.way,
            speeds: [speed.min(self.walk.speed), situation.gait.speed(&self.walk)],
            acceleration: ACCELERATION,
            distance: self.distance,
        };
        Some(follower.rims(&self.manipulator.robot.drive, &base, team.seen.rim_speeds, self.walk.period))
    }

    /// While the human leads: s_o(1..H) of every option, from where the human is, and which of them to track.
    fn anticipate(&mut self, situation: &Situation, lead: f64, grasp: &Pose) -> Option<usize> {
        if situation.mode == Mode::RobotLed {
            return None;
        }
        let Walk { period, speed, .. } = self.walk;
        let probabilities = situation.choice.probabilities();
        let (body, hand) = match &self.team {
            Team::Kinematic(team) => (team.human.position, team.human.position),
            Team::Physical(team) => (on_floor(&team.seen.torso), on_floor(&team.seen.hand)),
        };
        let tracked = self.intent.observe(body, probabilities);
        self.intent.see_hand(hand, period);
        let observed = match &self.team {
            Team::Kinematic(_) => self.intent.speed().unwrap_or(speed),
            Team::Physical(team) => self.seen_speed(team, situation.gait),
        };
        self.references.clear();
        let ground = self.ground(situation.options);
        for option in 0..probabilities.len() {
            situation.options.write_path(situation.progress, option, &mut self.paths[option]);
            if let Team::Physical(team) = &self.team {
                team.write_wide(&self.paths[option], &mut self.widening, &mut self.onto);
                team.write_way_onto(
                    situation.path,
                    situation.along,
                    &self.onto,
                    ground,
                    &mut self.paths[option],
                );
            }
            let turn = Some(&self.paths[option]);
            let onward = Onward { path: situation.path, along: situation.along, lead, turn };
            let led = (situation.mode, situation.gait);
            let reference = self.reference(&onward, observed, led, grasp);
            self.references.push(reference);
        }
        let step = observed * period;
        let ahead = lead.max(0.0);
        self.intent.expect(self.paths.iter().map(|path| {
            let [from, to] = [ahead, ahead + step].map(|walked| path.point_at(walked).unwrap_or(body));
            to - from
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

    /// How fast the hand is seen to go ahead, m/s; before it was seen to move, the team goes as the robot led it.
    fn seen_speed(&self, team: &PhysicalTeam, gait: Gait) -> f64 {
        let Some(speed) = self.intent.speed() else { return team.hurry };
        let ahead = direction(object_on_floor(&team.seen.object).yaw);
        match gait {
            Gait::Forward => speed.copysign(self.intent.moved().dot(&ahead)),
            // who is to step back brakes first
            Gait::Backward => {
                let moves = self.intent.moves_soon();
                (moves.norm() / self.walk.period).copysign(moves.dot(&ahead))
            }
        }
    }

    /// s(1..H) along a way.
    fn reference(&self, onward: &Onward, speed: f64, led: (Mode, Gait), grasp: &Pose) -> Reference {
        match &self.team {
            Team::Kinematic(team) => team.reference(onward, speed, &self.walk, grasp),
            Team::Physical(team) => team.reference(onward, speed, led, &self.walk, grasp),
        }
    }

    /// Moves the team and books what the step cost: ||x - s||_Q^2, ||u||_R^2 and kappa ||q* - q_c||^2 (Sec. V-C). Returns how far along
    /// `path` the team is now, m: on the kinematic plant, where it walked to, `along` at `position`; on the physical one, where the object is.
    pub fn act(
        &mut self,
        led: (Mode, Gait),
        path: &Path,
        (from, along, position): (f64, f64, Point),
        tick: &mut RobotTick,
    ) -> f64 {
        let Candidate { configuration, rates } = self.target;
        let moved: Moved = match &mut self.team {
            Team::Kinematic(team) => {
                team.step(&configuration, &self.input, (path, along, position), &self.walk)
            }
            Team::Physical(team) => team.step(&(rates + self.input), led, (path, from), &self.walk),
        };
        tick.position_error = moved.error.fixed_rows::<3>(0).norm();
        tick.orientation_error = moved.error.fixed_rows::<3>(3).norm();
        tick.tracking_cost = self.manipulator.control.state_weight * moved.error.norm_squared();
        tick.physics = moved.physics;
        moved.along
    }
}
