//! A team with a robot, and its controller: eq. (8) and (7) in each period, on the kinematic or the physical
//! plant.

use super::bodies::{Bodies, Manipulator, PathAhead};
use super::team_path::{FreeSpace, Turned};
use super::tick::{Preparation, RobotTick};
use super::{Situation, Step, Team, Walk};
use crate::control::{
    Avoid, BaseInputs, Candidate, ClosedForm, GUIDE_PRICE, Intent, Limits, ModalReference, Mpc,
    PoseCriterion, PoseOptimiser, PoseProblem, Reference, SolveOutcome, TURN_PRICE, reference, rolled,
    seen_from_base, turn_toward_grasp,
};
use crate::coordination::Mode;
use crate::geometry::{Footprint, Path, PlanarPose, Point, Pose, angle_of, wrap_angle};
use crate::options::OptionSet;
use crate::policy::Motion;
use crate::robot::{
    BaseInput, Configuration, InputJacobian, InputVector, JointVector, Kinematics, pose_difference,
};
use crate::saved::{NotRestored, Saved};
use crate::simulation::Observation;
use nalgebra::Vector6;

/// DEVIATION (eq. 8): bodies take a new configuration at this share of their rate limits. The motion then
/// stays within the range of eq. (7)'s linear model, and rates are left for the grasp.
const RECONFIGURATION_SHARE: f64 = 0.25;

/// Largest correction (m and rad) of the linear model of eq. (7).
const LARGEST_CORRECTION: f64 = 0.01;

/// The basis of the robot's decision in a step: the data of eq. (8) that others need to check it.
#[derive(Clone, Copy, Debug)]
pub struct Considerations<'e> {
    /// s_o(1..H) of every option while the human leads, else of the robot's own path only. On the physical
    /// plant, the part that the path-following base leaves for the arm.
    pub references: &'e [Reference],
    /// The weight of each in eq. (8); by default P_o.
    pub weights: &'e [f64],
    /// q*.
    pub target: &'e Configuration,
    /// The candidates with their objectives, in a step that has a [`Preparation`].
    pub poses: &'e PoseOptimiser,
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
    /// The decision of the step: q* with the rates that lead there, and u.
    target: Candidate,
    input: InputVector,
    /// Memory for the poses of the robot's bodies.
    body_poses: Vec<Pose>,
}

impl<'a, B: Bodies> Carrying<'a, B> {
    /// A team at the start of a world with this number of options.
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
            // longer than the paths of worlds: the remainder of an option may grow when the team turns away
            // from it
            paths: (0..options).map(|_| Path::with_capacity(64)).collect(),
            references: Vec::with_capacity(options),
            weights: Vec::with_capacity(options),
            target: Candidate::at_rest(&configuration, &manipulator.robot.kinematics(&configuration)),
            input: InputVector::zeros(),
            body_poses: Vec::with_capacity(manipulator.robot.links.len()),
        }
    }

    fn free_space<'g>(&self, options: &'g OptionSet) -> FreeSpace<'g>
    where
        'a: 'g,
    {
        FreeSpace { obstacles: self.manipulator.obstacles, options }
    }

    /// Sets the references of eq. (8) with their weights, and returns the one to track. While the human
    /// leads, those of all options.
    fn set_references(
        &mut self,
        situation: &Situation,
        path_ahead: &PathAhead,
        grasp: &Pose,
    ) -> Option<usize> {
        if let Motion::Reference(poses) = situation.motion {
            self.set_reference(reference(poses.iter().copied(), grasp, self.manipulator.robot.grasp_height));
            return None;
        }
        if situation.mode == Mode::HumanLed {
            return Some(self.anticipate(situation, path_ahead, grasp));
        }
        // the robot knows its own path
        self.set_reference(self.bodies.reference(path_ahead, self.walk.speed, &self.walk, grasp));
        None
    }

    fn set_reference(&mut self, reference: Reference) {
        self.references.clear();
        self.references.push(reference);
        self.weights.clear();
        self.weights.push(1.0);
    }

    /// Sets s_o(1..H) of every option from the human's position, and returns the one to track.
    fn anticipate(&mut self, situation: &Situation, path_ahead: &PathAhead, grasp: &Pose) -> usize {
        let Walk { period, .. } = self.walk;
        let probabilities = situation.choice.probabilities();
        let body = self.bodies.body();
        let tracked = self.intent.observe(body, probabilities);
        self.intent.see_hand(self.bodies.hand(), period);
        let observed = self.bodies.observed_speed(&self.intent, situation.travel, &self.walk);
        self.references.clear();
        let free_space = self.free_space(situation.options);
        for (option, path) in self.paths.iter_mut().enumerate().take(probabilities.len()) {
            situation.options.write_path(situation.progress, option, path);
            self.bodies.expect_path(situation, path, free_space);
            let path_ahead = PathAhead { turn: Some(path), ..*path_ahead };
            self.references.push(self.bodies.reference(&path_ahead, observed, &self.walk, grasp));
        }
        let step = observed * period;
        let ahead = path_ahead.lead.max(0.0);
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
        base: Option<&BaseInputs>,
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
            base,
            period: self.walk.period,
            share: if base.is_some() { RECONFIGURATION_SHARE } else { 1.0 },
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

    /// The error of eq. (7)'s linear model in the first period of `input`: the grasp by the arm's kinematics
    /// minus the grasp by the model. Its norm is at most [`LARGEST_CORRECTION`], m and rad.
    fn model_error(&self, jacobian: &InputJacobian, input: &InputVector, grasp: &Pose) -> Vector6<f64> {
        let Candidate { configuration: target, .. } = self.target;
        let robot = self.manipulator.robot;
        let moved: JointVector = robot.joint_rates(input) * self.walk.period;
        let reached = Configuration { base: target.base, joints: target.joints + moved };
        let reached = pose_difference(&robot.grasp_pose(&reached), grasp);
        let model_error = reached - robot.arm_jacobian(jacobian) * moved;
        model_error * (LARGEST_CORRECTION / model_error.norm()).min(1.0)
    }

    /// The Jacobian with the arm's part half-way through the first period of `input`. Where the wrist is nearly
    /// stretched, its axes turn by so much in a period that those at the beginning do not describe the motion.
    fn jacobian_half_way(&self, jacobian: &InputJacobian, input: &InputVector) -> InputJacobian {
        let Candidate { configuration: target, .. } = self.target;
        let robot = self.manipulator.robot;
        let moved: JointVector = robot.joint_rates(input) * (0.5 * self.walk.period);
        let half_way = Configuration { base: target.base, joints: target.joints + moved };
        let mut there = robot.kinematics(&half_way).jacobian;
        let base = robot.drive.inputs();
        there.columns_mut(0, base).copy_from(&jacobian.columns(0, base));
        there
    }

    /// Inputs that turn a free omnidirectional base toward its grasp, unless it is a disc.
    fn turning_free_base(&self, grasp: &Pose) -> Option<BaseInputs> {
        let robot = self.manipulator.robot;
        if !robot.drive.is_omnidirectional() || matches!(robot.footprint, Footprint::Disc { .. }) {
            return None;
        }
        let held = robot.drive_from_grasp(&self.manipulator.posture).translation.vector.xy();
        let base = self.target.configuration.base;
        let to_grasp = grasp.translation.vector.xy() - base.position.coords;
        let off = wrap_angle(angle_of(to_grasp) - angle_of(held) - base.yaw);
        Some(turn_toward_grasp(off, self.walk.period))
    }

    /// u of eq. (7) that tracks one of the references. Where limits are active, it is solved again with the
    /// obstacles' half-planes about the first solution. For bodies it is solved twice, the second time with
    /// the error of the linear model; where the robot `follows`, with B half-way in between.
    fn track(
        &mut self,
        reference: usize,
        base: Option<&BaseInputs>,
        follows: bool,
        grasp: &Pose,
        tick: &mut RobotTick,
    ) {
        let Manipulator { robot, control, obstacles, .. } = self.manipulator;
        let period = self.walk.period;
        let Candidate { configuration: target, rates, jacobian } = self.target;
        let turning = if base.is_none() { self.turning_free_base(grasp) } else { None };
        let form = |jacobian: &InputJacobian| {
            let b = jacobian * period;
            let weights = [control.state_weight, control.input_weight];
            let guided = |base, prices| ClosedForm::guided(&b, weights, &robot.drive, base, prices);
            match (base, &turning) {
                (Some(base), _) => guided(base, &BaseInput::repeat(GUIDE_PRICE)),
                (None, Some(turning)) => guided(turning, &BaseInput::new(0.0, 0.0, TURN_PRICE)),
                (None, None) => ClosedForm::new(&b, weights[0], weights[1]),
            }
        };
        let free = form(&jacobian);
        self.limits.set(robot, &target, &rates, period);
        let mut to_track = self.references[reference];
        if let Some(base) = base {
            to_track += rolled(&robot.drive, &jacobian, base, period);
        }
        if control.avoid != Avoid::Nothing {
            let about = free.inputs(&ModalReference::new(&to_track));
            obstacles.half_planes(
                control.avoid,
                robot,
                &target,
                &about,
                period,
                base.is_some(),
                &mut self.limits,
            );
        }
        let mut plan = self.mpc.solve(&free, &self.limits, &to_track);
        let is_limited = matches!(plan.outcome, SolveOutcome::Constrained { active } if active > 0);
        if base.is_none() && control.avoid != Avoid::Nothing && is_limited {
            let about = plan.inputs;
            obstacles.half_planes(control.avoid, robot, &target, &about, period, false, &mut self.limits);
            plan = self.mpc.solve(&free, &self.limits, &to_track);
        }
        let (mut jacobian, mut free) = (jacobian, free);
        if base.is_some() && follows {
            jacobian = self.jacobian_half_way(&jacobian, &plan.inputs.column(0).into_owned());
            free = form(&jacobian);
            plan = self.mpc.solve(&free, &self.limits, &to_track);
        }
        if base.is_some() {
            let model_error = self.model_error(&jacobian, &plan.inputs.column(0).into_owned(), grasp);
            let mut first = to_track.column_mut(0);
            first -= model_error;
            plan = self.mpc.solve(&free, &self.limits, &to_track);
        }
        self.input = plan.inputs.column(0).into_owned();
        tick.outcome = plan.outcome;
        tick.input_matrix = jacobian * period;
    }
}

impl<B: Bodies> Team for Carrying<'_, B> {
    fn walkable(&self, path: Path, options: &OptionSet) -> Path {
        self.bodies.walkable(path, self.free_space(options))
    }

    fn turn(&mut self, path: &Path, along: f64, next: Path, options: &OptionSet) -> Option<Turned> {
        let free_space = self.free_space(options);
        self.bodies.turn(path, along, next, free_space)
    }

    fn place_to_turn(
        &self,
        path: &Path,
        range: [f64; 2],
        next: &dyn Fn(Point) -> Path,
        options: &OptionSet,
    ) -> Option<f64> {
        self.bodies.place_to_turn(path, range, next, self.free_space(options))
    }

    fn anticipates(&self) -> bool {
        true
    }

    fn control(&mut self, situation: &Situation<'_>) -> Option<RobotTick> {
        let Manipulator { robot, control, obstacles, .. } = self.manipulator;
        let q = *self.bodies.configuration();
        let mut tick = RobotTick::at(&q, self.bodies.grasp_goal());
        let at = robot.kinematics(&q);
        self.target = Candidate::at_rest(&q, &at);
        if let Motion::Inputs(input) = situation.motion {
            self.input = *input;
        } else {
            let Situation { mode, travel, path, along, .. } = *situation;
            let lead = match mode {
                Mode::RobotLed => 0.0,
                Mode::HumanLed => self.bodies.lead(path, along),
            };
            let path_ahead = PathAhead { mode, travel, path, along, lead, turn: None };
            let tracked = self.set_references(situation, &path_ahead, &at.grasp);
            // on the physical plant, the base follows the path of the grasp, and the arm does the rest
            let speed = self.bodies.observed_speed(&self.intent, travel, &self.walk);
            let base = self.bodies.base_on_path(&path_ahead, speed, &self.manipulator, &self.walk);
            if let Some(base) = &base {
                for reference in &mut self.references {
                    let period = self.walk.period;
                    *reference = seen_from_base(reference, &at.grasp, &q.base, &robot.drive, base, period);
                }
            }
            if tracked.is_some() || control.prepare_while_leading {
                self.prepare(&at, base.as_ref(), tracked, &mut tick);
            }
            self.track(tracked.unwrap_or(0), base.as_ref(), tracked.is_some(), &at.grasp, &mut tick);
        }
        tick.input = self.input;
        tick.effort_cost = control.input_weight * self.input.norm_squared();
        tick.base_clearance = obstacles.clearance(&q.base, &robot.footprint);
        Some(tick)
    }

    /// Adds ||x - s||_Q^2 to the tick; ||u||_R^2 and kappa ||q* - q_c||^2 are already in it (Sec. V-C).
    fn walk(&mut self, step: &Step<'_>, tick: Option<&mut RobotTick>) -> f64 {
        let moved = self.bodies.step(&self.target, &self.input, step, &self.walk);
        if let Some(tick) = tick {
            tick.position_error = moved.error.fixed_rows::<3>(0).norm();
            tick.orientation_error = moved.error.fixed_rows::<3>(3).norm();
            tick.tracking_cost = self.manipulator.control.state_weight * moved.error.norm_squared();
            tick.physics = moved.physics;
            let joints = &self.bodies.configuration().joints;
            tick.self_contact = self.manipulator.robot.self_contact(joints, &mut self.body_poses);
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
