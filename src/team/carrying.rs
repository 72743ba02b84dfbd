//! A team with a robot: what its controller does in each period, eq. (8) and (7), on whichever bodies.

use super::team_path::{Ground, Turned};
use super::tick::{Preparation, RobotTick};
use super::{Situation, Step, Team, Travel, Walk};
use crate::control::{
    self, Avoid, Candidate, ClosedForm, Intent, Limits, Mpc, PoseCriterion, PoseOptimiser, PoseProblem,
    Reference, Rims, RobotObstacles, hold_base_to, reference, rolled, seen_from_base, set_base,
};
use crate::coordination::Mode;
use crate::geometry::{Path, PlanarPose, Point, Pose};
use crate::options::OptionSet;
use crate::policy::Motion;
use crate::robot::{
    Configuration, InputJacobian, InputVector, JointVector, Kinematics, MAX_JOINTS, Robot, pose_difference,
};
use crate::saved::{NotRestored, Saved};
use crate::simulation::Observation;
use nalgebra::Vector6;

/// DEVIATION (eq. 8): bodies take a new configuration at this share of their rate limits, so that what is linear in eq. (7) stays nearly so,
/// and rates are left for the grasp.
const RECONFIGURATION_SHARE: f64 = 0.25;

/// What bodies believe of the arm's half-planes of a step, beside those of the step before: where the base follows its path at given rim
/// speeds, the arm turns by radians within the horizon while it swings round a corner.
const CONFIDENCE: f64 = 0.7;
/// The most (m and rad) that the linear model of eq. (7) is corrected by.
const MOST_MISSED: f64 = 0.01;

/// The confidence in the arm's half-planes.
fn confidence(rims: Option<&Rims>) -> f64 {
    if rims.is_some() { CONFIDENCE } else { 1.0 }
}

/// The robot, its starting posture and its controller.
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
pub struct Considerations<'e> {
    /// s_o(1..H) of every option while the human leads, else of the robot's own way alone; on the physical plant what the base, which
    /// follows its path, leaves of it for the arm.
    pub references: &'e [Reference],
    /// What each counts for in eq. (8): P_o, if nothing else is asked for.
    pub weights: &'e [f64],
    /// q*.
    pub target: &'e Configuration,
    /// What became of the candidates, in a step that has a [`Preparation`].
    pub poses: &'e PoseOptimiser,
}

/// The bodies that a controller acts on: those of the kinematic or of the physical plant.
pub(super) trait Bodies: Clone + std::fmt::Debug + Send + Sync {
    /// The robot's base and joints.
    fn configuration(&self) -> &Configuration;

    /// s: where the grasp should be for the human where they are, as a pose on the floor.
    fn grasp_goal(&self) -> PlanarPose;

    /// Where the human's body is, m.
    fn body(&self) -> Point;

    /// Where the human's hand is, m.
    fn hand(&self) -> Point;

    /// How far the human who leads is ahead of where the object is, m.
    fn lead(&self, path: &Path, along: f64) -> f64;

    /// How fast the human is seen to walk, m/s ahead.
    fn observed_speed(&self, intent: &Intent, travel: Travel, walk: &Walk) -> f64;

    /// `path`, the rest of an option for a point, becomes what the robot expects the human to walk onto it.
    fn expect_path(&mut self, situation: &Situation, path: &mut Path, ground: Ground);

    /// s(1..H) of the grasp along a way at this speed (m/s), relative to the grasp.
    fn reference(&self, onward: &Onward, speed: f64, walk: &Walk, grasp: &Pose) -> Reference;

    /// Rim speeds with which the base follows on the way that the grasp has gone; none where the base is free.
    fn base_on_path(&mut self, onward: &Onward, speed: f64, robot: &Robot, walk: &Walk) -> Option<Rims>;

    /// See [`Team::walkable`].
    fn walkable(&self, path: Path, ground: Ground) -> Path;

    /// See [`Team::turn`].
    fn turn(&mut self, path: &Path, along: f64, next: Path, ground: Ground) -> Option<Turned>;

    /// See [`Team::place_to_turn`].
    fn place_to_turn(
        &self,
        path: &Path,
        range: [f64; 2],
        next: &dyn Fn(Point) -> Path,
        ground: Ground,
    ) -> Option<f64>;

    /// Moves everybody by one period.
    fn step(&mut self, target: &Candidate, input: &InputVector, step: &Step, walk: &Walk) -> Moved;

    /// `world_from_link` of every link.
    fn link_poses(&self) -> Vec<Pose>;

    /// See [`Team::observation`].
    fn observation(&self) -> Option<&Observation> {
        None
    }

    /// See [`Team::human`].
    fn human(&self) -> Option<&PlanarPose> {
        None
    }

    /// What later steps depend on.
    fn save(&self) -> Saved;

    /// Takes over what was saved.
    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored>;
}

/// Where a way leads on from where the team is.
#[derive(Clone, Copy)]
pub(super) struct Onward<'s> {
    pub mode: Mode,
    pub travel: Travel,
    /// The path under way, and how far along it the team is, m.
    pub path: &'s Path,
    pub along: f64,
    /// How far ahead of that the hand is, m ([`Bodies::lead`]).
    pub lead: f64,
    /// The path to turn onto; none to go on. On the physical plant, it begins where the human's body is.
    pub turn: Option<&'s Path>,
}

/// What a step came to.
pub(super) struct Moved {
    /// How far along the path under way the team is now, m.
    pub along: f64,
    /// s - x after the step: what separates the grasp from where it should be, m and rad.
    pub error: nalgebra::Vector6<f64>,
    pub physics: Option<super::PhysicsTick>,
}

/// A team of bodies with the robot's controller.
#[derive(Clone, Debug)]
pub(super) struct Carrying<'a, B> {
    manipulator: Manipulator<'a>,
    walk: Walk,
    bodies: B,
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

impl<'a, B: Bodies> Carrying<'a, B> {
    /// A team at the start of a world with so many options.
    pub fn new(manipulator: Manipulator<'a>, walk: Walk, options: usize, bodies: B) -> Self {
        let configuration = *bodies.configuration();
        Self {
            manipulator,
            walk,
            bodies,
            intent: Intent::new(manipulator.control.direction_concentration),
            poses: PoseOptimiser::default(),
            limits: Limits::new(manipulator.robot),
            mpc: Mpc::default(),
            // longer than the paths that worlds have: what is left of an option may grow when the team turns away from it
            paths: (0..options).map(|_| Path::with_capacity(64)).collect(),
            references: Vec::with_capacity(options),
            weights: Vec::with_capacity(options),
            target: Candidate { configuration, rates: InputVector::zeros() },
            input: InputVector::zeros(),
        }
    }

    fn ground<'g>(&self, options: &'g OptionSet) -> Ground<'g>
    where
        'a: 'g,
    {
        Ground { obstacles: self.manipulator.obstacles, options }
    }

    /// The references to be ready for, with a weight for each, and which one to track. While the human leads, those of all options.
    fn set_references(&mut self, situation: &Situation, onward: &Onward, grasp: &Pose) -> Option<usize> {
        if let Motion::Reference(poses) = situation.motion {
            self.set_reference(reference(poses.iter().copied(), grasp, self.manipulator.robot.grasp_height));
            return None;
        }
        if situation.mode == Mode::HumanLed {
            return Some(self.anticipate(situation, onward, grasp));
        }
        // the robot knows its own way
        self.set_reference(self.bodies.reference(onward, self.walk.speed, &self.walk, grasp));
        None
    }

    fn set_reference(&mut self, reference: Reference) {
        self.references.clear();
        self.references.push(reference);
        self.weights.clear();
        self.weights.push(1.0);
    }

    /// s_o(1..H) of every option, from where the human is, and which of them to track.
    fn anticipate(&mut self, situation: &Situation, onward: &Onward, grasp: &Pose) -> usize {
        let Walk { period, .. } = self.walk;
        let probabilities = situation.choice.probabilities();
        let body = self.bodies.body();
        let tracked = self.intent.observe(body, probabilities);
        self.intent.see_hand(self.bodies.hand(), period);
        let observed = self.bodies.observed_speed(&self.intent, situation.travel, &self.walk);
        self.references.clear();
        let ground = self.ground(situation.options);
        for (option, path) in self.paths.iter_mut().enumerate().take(probabilities.len()) {
            situation.options.write_path(situation.progress, option, path);
            self.bodies.expect_path(situation, path, ground);
            let onward = Onward { turn: Some(path), ..*onward };
            self.references.push(self.bodies.reference(&onward, observed, &self.walk, grasp));
        }
        let step = observed * period;
        let ahead = onward.lead.max(0.0);
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
        tracked
    }

    /// q* of eq. (8), with the rates that lead there.
    fn prepare(
        &mut self,
        at: &Kinematics,
        rims: Option<&Rims>,
        tracked: Option<usize>,
        tick: &mut RobotTick,
    ) {
        let Manipulator { robot, control, obstacles, .. } = self.manipulator;
        let configuration = *self.bodies.configuration();
        let problem = PoseProblem {
            robot,
            configuration: &configuration,
            kinematics: at,
            references: &self.references,
            weights: &self.weights,
            obstacles: (control.avoid != Avoid::Nothing).then_some((obstacles, control.avoid)),
            rims,
            period: self.walk.period,
            share: if rims.is_some() { RECONFIGURATION_SHARE } else { 1.0 },
            confidence: confidence(rims),
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

    /// What eq. (7)'s linear model misses of the first period of `input`: the grasp as the arm's kinematics have it, minus as the model does; no
    /// more than [`MOST_MISSED`] in norm, m and rad.
    fn missed(&self, jacobian: &InputJacobian, input: &InputVector, grasp: &Pose) -> Vector6<f64> {
        let Candidate { configuration: target, .. } = self.target;
        let moved: JointVector = input.fixed_rows::<MAX_JOINTS>(2) * self.walk.period;
        let reached = Configuration { base: target.base, joints: target.joints + moved };
        let reached = pose_difference(&self.manipulator.robot.grasp_pose(&reached), grasp);
        let missed = reached - jacobian.fixed_columns::<MAX_JOINTS>(2) * moved;
        missed * (MOST_MISSED / missed.norm()).min(1.0)
    }

    /// u of eq. (7), tracking one of the references. Bodies have it solved twice, the second time knowing what the linear model misses.
    fn track(&mut self, reference: usize, rims: Option<&Rims>, grasp: &Pose, tick: &mut RobotTick) {
        let Manipulator { robot, control, obstacles, .. } = self.manipulator;
        let period = self.walk.period;
        let Candidate { configuration: target, rates } = self.target;
        let jacobian = robot.kinematics(&target).jacobian;
        let free = ClosedForm::new(&(jacobian * period), control.state_weight, control.input_weight);
        self.limits.set(robot, &target, &rates, period);
        let mut to_track = self.references[reference];
        if let Some(rims) = rims {
            to_track += rolled(&jacobian, rims, period);
        }
        if control.avoid != Avoid::Nothing {
            let mut about = free.inputs(&to_track);
            if let Some(rims) = rims {
                set_base(&mut about, rims);
            }
            let confidence = confidence(rims);
            obstacles.half_planes(
                control.avoid,
                robot,
                &target,
                &about,
                period,
                confidence,
                &mut self.limits,
            );
        }
        if let Some(rims) = rims {
            hold_base_to(rims, &mut self.limits);
        }
        let mut plan = self.mpc.solve(&free, &self.limits, &to_track);
        if rims.is_some() {
            let missed = self.missed(&jacobian, &plan.inputs.column(0).into_owned(), grasp);
            let mut first = to_track.column_mut(0);
            first -= missed;
            plan = self.mpc.solve(&free, &self.limits, &to_track);
        }
        self.input = plan.inputs.column(0).into_owned();
        tick.outcome = plan.outcome;
        tick.least_singular_value = free.least_singular_value();
    }
}

impl<B: Bodies> Team for Carrying<'_, B> {
    fn walkable(&self, path: Path, options: &OptionSet) -> Path {
        self.bodies.walkable(path, self.ground(options))
    }

    fn turn(&mut self, path: &Path, along: f64, next: Path, options: &OptionSet) -> Option<Turned> {
        let ground = self.ground(options);
        self.bodies.turn(path, along, next, ground)
    }

    fn place_to_turn(
        &self,
        path: &Path,
        range: [f64; 2],
        next: &dyn Fn(Point) -> Path,
        options: &OptionSet,
    ) -> Option<f64> {
        self.bodies.place_to_turn(path, range, next, self.ground(options))
    }

    fn anticipates(&self) -> bool {
        true
    }

    fn control(&mut self, situation: &Situation<'_>) -> Option<RobotTick> {
        let Manipulator { robot, control, obstacles, .. } = self.manipulator;
        let q = *self.bodies.configuration();
        let mut tick = RobotTick::at(&q, self.bodies.grasp_goal());
        self.target = Candidate { configuration: q, rates: InputVector::zeros() };
        if let Motion::Inputs(input) = situation.motion {
            self.input = *input;
        } else {
            let at = robot.kinematics(&q);
            let Situation { mode, travel, path, along, .. } = *situation;
            let lead = match mode {
                Mode::RobotLed => 0.0,
                Mode::HumanLed => self.bodies.lead(path, along),
            };
            let onward = Onward { mode, travel, path, along, lead, turn: None };
            let tracked = self.set_references(situation, &onward, &at.grasp);
            // on the physical plant, the base follows the way that the grasp has gone, and the arm does the rest
            let speed = self.bodies.observed_speed(&self.intent, travel, &self.walk);
            let rims = self.bodies.base_on_path(&onward, speed, robot, &self.walk);
            if let Some(rims) = &rims {
                for reference in &mut self.references {
                    let period = self.walk.period;
                    *reference = seen_from_base(reference, &at.grasp, &q.base, &robot.drive, rims, period);
                }
            }
            if tracked.is_some() || control.prepare_while_leading {
                self.prepare(&at, rims.as_ref(), tracked, &mut tick);
            }
            self.track(tracked.unwrap_or(0), rims.as_ref(), &at.grasp, &mut tick);
        }
        tick.input = self.input;
        tick.control_effort = control.input_weight * self.input.norm_squared();
        tick.base_clearance = obstacles.clearance(q.base.position, robot.drive.base_radius);
        Some(tick)
    }

    /// Books ||x - s||_Q^2; ||u||_R^2 and kappa ||q* - q_c||^2 are in the tick already (Sec. V-C).
    fn walk(&mut self, step: &Step<'_>, tick: Option<&mut RobotTick>) -> f64 {
        let moved = self.bodies.step(&self.target, &self.input, step, &self.walk);
        if let Some(tick) = tick {
            tick.position_error = moved.error.fixed_rows::<3>(0).norm();
            tick.orientation_error = moved.error.fixed_rows::<3>(3).norm();
            tick.tracking_cost = self.manipulator.control.state_weight * moved.error.norm_squared();
            tick.physics = moved.physics;
        }
        moved.along
    }

    fn considerations(&self) -> Option<Considerations<'_>> {
        Some(Considerations {
            references: &self.references,
            weights: &self.weights,
            target: &self.target.configuration,
            poses: &self.poses,
        })
    }

    fn configuration(&self) -> Option<&Configuration> {
        Some(self.bodies.configuration())
    }

    fn grasp(&self) -> Option<Pose> {
        Some(self.manipulator.robot.grasp_pose(self.bodies.configuration()))
    }

    fn link_poses(&self) -> Option<Vec<Pose>> {
        Some(self.bodies.link_poses())
    }

    fn observation(&self) -> Option<&Observation> {
        self.bodies.observation()
    }

    fn human(&self) -> Option<&PlanarPose> {
        self.bodies.human()
    }

    fn save(&self) -> Saved {
        Saved::of(&(&self.intent, self.bodies.save()))
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored> {
        let (intent, bodies): (Intent, Saved) = saved.read("plant")?;
        self.bodies.restore(&bodies)?;
        self.intent = intent;
        Ok(())
    }
}
