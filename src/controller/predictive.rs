//! The paper's controller: pose optimisation (eq. 8), then MPC (eq. 7) from the configuration that it chose.

use super::{Controller, DecisionBasis, Guide, References, Way};
use crate::control::{
    Avoid, BaseInputs, Candidate, ClosedForm, GUIDE_WIDTH_M, Intent, Limits, Manipulator, ModalReference,
    Mpc, Plan, PoseChoice, PoseOptimiser, PoseProblem, SolveOutcome, TURN_PRICE, keep_near, rolled,
    seen_from_base, turn_toward_grasp,
};
use crate::coordination::Mode;
use crate::geometry::{Footprint, PlanarPose, Pose, angle_of, wrap_angle};
use crate::plant::{Command, Preparation, Seen};
use crate::policy::Motion;
use crate::preference::ChoiceDistribution;
use crate::robot::{
    BaseInput, Configuration, InputJacobian, InputVector, JointVector, Kinematics, Robot, pose_difference,
};
use crate::saved::{RestoreError, Saved};
use crate::team::Pace;
use nalgebra::Vector6;

/// DEVIATION (eq. 8): bodies take a new configuration at this share of their rate limits. The motion then
/// stays within the range of eq. (7)'s linear model, and rates are left for the grasp.
const RECONFIGURATION_SHARE: f64 = 0.25;

/// The largest price of a guided omnidirectional base's deviations whose arm alone does not move its grasp
/// freely in the plane.
///
/// DEVIATION (eq. 7): of a base that only follows the path, such an arm is a decimetre off in bends; with this
/// price, eq. (7) lets the base help.
const HELPING_PRICE: f64 = 100.0;

/// Weight of the squared deviation (m/s) of a free base's inputs from those that follow the grasp like a
/// trailer.
const TRAILER_PRICE: f64 = 10.0;

/// Largest correction (m and rad) of the linear model of eq. (7).
const MAX_CORRECTION: f64 = 0.01;

/// The paper's controller. In every control period it sets the references of the grasp, chooses a
/// configuration q* with eq. (8) if it prepares, and finds the inputs u from q* with eq. (7).
#[derive(Clone, Debug)]
pub struct Predictive<'a> {
    manipulator: Manipulator<'a>,
    /// The control period T, s.
    period: f64,
    references: References,
    /// How the base follows the path of the grasp; none where it is free.
    guide: Option<Guide>,
    /// How a free base follows its grasp like a trailer, if it does.
    trailer: Option<Guide>,
    /// The solver of eq. (8).
    poses: PoseOptimiser,
    /// The constraints of eq. (7), set anew for every solution.
    limits: Limits,
    /// The solver of eq. (7).
    mpc: Mpc,
    /// q* of the last command.
    target: Configuration,
}

/// The solution of eq. (7).
struct Tracked {
    plan: Plan,
    /// B = T J, the matrix of the linear model that it was found with.
    input_matrix: InputJacobian,
}

impl<'a> Predictive<'a> {
    /// The controller of a team at the start of a world with this number of options. With a `guide`, the base
    /// follows the path of the grasp.
    pub fn new(mut manipulator: Manipulator<'a>, pace: Pace, options: usize, guide: Option<Guide>) -> Self {
        let Manipulator { robot, posture, control, .. } = &mut manipulator;
        if robot.drive.is_omnidirectional() && !robot.is_arm_free_in_plane(posture) {
            control.guide_price = control.guide_price.min(HELPING_PRICE);
        }
        let concentration = manipulator.control.direction_concentration;
        Self {
            manipulator,
            period: pace.period,
            references: References::new(concentration, pace, options),
            trailer: if guide.is_none() { Guide::of_trailer(&manipulator) } else { None },
            guide,
            poses: PoseOptimiser::default(),
            limits: Limits::new(manipulator.robot),
            mpc: Mpc::default(),
            target: Command::none().target,
        }
    }

    /// q* of eq. (8), with the rates that lead there. `base` has the inputs of a guided base, and is none where
    /// the base is free.
    fn prepare(&mut self, q: &Configuration, at: &Kinematics, base: Option<&BaseInputs>) -> PoseChoice {
        let Manipulator { robot, control, obstacles, .. } = self.manipulator;
        let problem = PoseProblem {
            robot,
            configuration: q,
            kinematics: at,
            references: &self.references.references,
            weights: &self.references.weights,
            obstacles: (control.avoid != Avoid::Nothing).then_some((obstacles, control.avoid)),
            base,
            period: self.period,
            share: if base.is_some() { RECONFIGURATION_SHARE } else { 1.0 },
        };
        self.poses.choose(&problem, &control, &mut self.limits, &mut self.mpc)
    }

    /// The error of eq. (7)'s linear model in the first period of `input`: the grasp by the arm's kinematics
    /// minus the grasp by the model. Its norm is at most [`MAX_CORRECTION`], m and rad.
    fn model_error(
        &self,
        target: &Configuration,
        jacobian: &InputJacobian,
        input: &InputVector,
        grasp: &Pose,
    ) -> Vector6<f64> {
        let robot = self.manipulator.robot;
        let moved: JointVector = robot.joint_rates(input) * self.period;
        let reached = Configuration { base: target.base, joints: target.joints + moved };
        let reached = pose_difference(&robot.grasp_pose(&reached), grasp);
        let model_error = reached - robot.arm_jacobian(jacobian) * moved;
        model_error * (MAX_CORRECTION / model_error.norm()).min(1.0)
    }

    /// The Jacobian with the arm's part half-way through the first period of `input`. Where the wrist is
    /// nearly stretched, its axes turn by so much in a period that those at the beginning do not describe the
    /// motion.
    fn jacobian_half_way(
        &self,
        target: &Configuration,
        jacobian: &InputJacobian,
        input: &InputVector,
    ) -> InputJacobian {
        let robot = self.manipulator.robot;
        let moved: JointVector = robot.joint_rates(input) * (0.5 * self.period);
        let half_way = Configuration { base: target.base, joints: target.joints + moved };
        let mut there = robot.kinematics(&half_way).jacobian;
        let base = robot.drive.inputs();
        there.columns_mut(0, base).copy_from(&jacobian.columns(0, base));
        there
    }

    /// Inputs that a free base prefers, and the prices of others; none where it prefers none.
    fn preferred(&self, target: &Configuration, grasp: &Pose) -> Option<(BaseInputs, BaseInput)> {
        let trailing = self.trailing(target, grasp).map(|inputs| (inputs, BaseInput::repeat(TRAILER_PRICE)));
        let turning = || self.turning_free_base(target, grasp);
        trailing.or_else(|| turning().map(|inputs| (inputs, BaseInput::new(0.0, 0.0, TURN_PRICE))))
    }

    /// Inputs with which a free base follows its grasp like a trailer.
    ///
    /// DEVIATION (eq. 7): with the weights of eq. (7) alone, such a base turns away while its grasp goes
    /// straight ahead, until its arm has come to its limits.
    fn trailing(&self, target: &Configuration, grasp: &Pose) -> Option<BaseInputs> {
        let guide = self.trailer.as_ref()?;
        let at = PlanarPose::from_above(grasp);
        let poses = self.references.poses(&at);
        Some(guide.following_at_once(&target.base, (&at, &poses), &self.manipulator.robot.drive, self.period))
    }

    /// Inputs that turn a free omnidirectional base toward its grasp, unless it is a disc.
    fn turning_free_base(&self, target: &Configuration, grasp: &Pose) -> Option<BaseInputs> {
        let robot = self.manipulator.robot;
        if !robot.drive.is_omnidirectional() || matches!(robot.footprint, Footprint::Disc { .. }) {
            return None;
        }
        let held = robot.drive_from_grasp(&self.manipulator.posture).translation.vector.xy();
        let to_grasp = grasp.translation.vector.xy() - target.base.position.coords;
        let off = wrap_angle(angle_of(to_grasp) - angle_of(held) - target.base.yaw);
        Some(turn_toward_grasp(off, self.period))
    }

    /// u of eq. (7) that tracks the reference, from the configuration `from`. `base` has the inputs of a guided
    /// base, and is none where the base is free. The program is solved up to three times, each time linearised
    /// closer to the solution:
    ///
    /// 1. With the half-planes of the obstacles linearised at the solution without limits.
    /// 2. With a free base and active limits: with the half-planes linearised at the first solution. With a
    ///    guided base, while the robot `follows`: with B in the middle of the first period of that solution.
    /// 3. With a guided base: with the reference corrected by the error of the linear model.
    fn track(&mut self, from: &Candidate, base: Option<&BaseInputs>, follows: bool, grasp: &Pose) -> Tracked {
        let Manipulator { robot, control, obstacles, .. } = self.manipulator;
        let period = self.period;
        let Candidate { configuration: target, rates, jacobian } = *from;
        let preferred = if base.is_none() { self.preferred(&target, grasp) } else { None };
        let closed_form = |jacobian: &InputJacobian| {
            let b = jacobian * period;
            let weights = [control.state_weight, control.input_weight];
            let guided = |base, prices| ClosedForm::guided(&b, weights, &robot.drive, base, prices);
            match (base, &preferred) {
                (Some(base), _) => guided(base, &BaseInput::repeat(control.guide_price)),
                (None, Some((inputs, prices))) => guided(inputs, prices),
                (None, None) => ClosedForm::new(&b, weights[0], weights[1]),
            }
        };
        let unlimited = closed_form(&jacobian);
        self.limits.set(robot, &target, &rates, period);
        let mut to_track = *self.references.to_track();
        if let Some(base) = base.filter(|_| control.is_base_given()) {
            to_track += rolled(&robot.drive, &jacobian, base, period);
        }
        if control.avoid != Avoid::Nothing {
            let inputs = unlimited.inputs(&ModalReference::new(&to_track));
            obstacles.half_planes(
                control.avoid,
                robot,
                &target,
                &inputs,
                period,
                base.is_some(),
                &mut self.limits,
            );
        }
        if let Some(base) = base.filter(|_| control.guide_width < GUIDE_WIDTH_M) {
            let inputs = unlimited.inputs(&ModalReference::new(&to_track));
            let width = control.guide_width;
            keep_near(&robot.drive, &target.base, &inputs, (base, width), period, &mut self.limits);
        }
        let mut plan = self.mpc.solve(&unlimited, &self.limits, &to_track);
        let is_limited = matches!(plan.outcome, SolveOutcome::Constrained { active } if active > 0);
        if base.is_none() && control.avoid != Avoid::Nothing && is_limited {
            let inputs = plan.inputs;
            obstacles.half_planes(control.avoid, robot, &target, &inputs, period, false, &mut self.limits);
            plan = self.mpc.solve(&unlimited, &self.limits, &to_track);
        }
        let (mut jacobian, mut unlimited) = (jacobian, unlimited);
        if base.is_some() && follows {
            jacobian = self.jacobian_half_way(&target, &jacobian, &plan.inputs.column(0).into_owned());
            unlimited = closed_form(&jacobian);
            plan = self.mpc.solve(&unlimited, &self.limits, &to_track);
        }
        if base.is_some() {
            let input = plan.inputs.column(0).into_owned();
            let model_error = self.model_error(&target, &jacobian, &input, grasp);
            let mut first = to_track.column_mut(0);
            first -= model_error;
            plan = self.mpc.solve(&unlimited, &self.limits, &to_track);
        }
        Tracked { plan, input_matrix: jacobian * period }
    }
}

/// `input` with a residual added, so that neither it nor the residual takes its sum with `rates` beyond the limits
/// that it kept. A residual of 0 changes no bit.
fn with_residual(
    robot: &Robot,
    rates: &InputVector,
    mut input: InputVector,
    residual: &InputVector,
) -> InputVector {
    let limits = robot.input_limits();
    for (i, added) in residual.iter().enumerate().filter(|(_, added)| **added != 0.0) {
        let total = rates[i] + input[i];
        let bounded = (total + added).clamp(total.min(-limits[i]), total.max(limits[i]));
        input[i] = bounded - rates[i];
    }
    input
}

impl Controller for Predictive<'_> {
    fn command(&mut self, seen: &Seen<'_>, way: &Way<'_>, belief: &ChoiceDistribution) -> Command {
        let Some(q) = seen.configuration else { return Command::none() };
        if let Motion::Inputs(input) = way.motion {
            self.target = *q;
            return Command::inputs(q, *input);
        }
        let Manipulator { robot, control, .. } = self.manipulator;
        let at = robot.kinematics(q);
        let ahead = self.references.set(seen, way, belief, &at.grasp, &self.manipulator);
        let speed = way.walk.observed_speed(seen, &self.references.intent, way.travel);
        let (manipulator, period) = (&self.manipulator, self.period);
        let guide = self.guide.as_mut();
        let grasp = PlanarPose::from_above(&at.grasp);
        let base = guide.and_then(|guide| match &self.references.given {
            // a policy's reference need not be on the path
            Some(poses) => guide.following(seen, (&grasp, poses), &robot.drive, period),
            None => {
                let poses = self.references.poses(&grasp);
                guide.inputs(seen, (way.walk, &ahead), speed, (&grasp, &poses), manipulator, period)
            }
        });
        if let Some(base) = &base {
            for reference in &mut self.references.references {
                *reference = seen_from_base(reference, &at.grasp, &q.base, &robot.drive, base, period);
                if !control.is_base_given() {
                    *reference += rolled(&robot.drive, &at.jacobian, base, period);
                }
            }
        }
        let tracked = self.references.tracked;
        // a robot that follows a reference of its policy prepares for that
        let follows_given = base.is_some() && self.references.given.is_some() && way.mode == Mode::HumanLed;
        let follows = tracked.is_some() || follows_given;
        let choice = (follows || control.prepare_while_leading).then(|| self.prepare(q, &at, base.as_ref()));
        let from = choice.map_or_else(|| Candidate::at_rest(q, &at), |choice| choice.candidate);
        let Tracked { plan, input_matrix } = self.track(&from, base.as_ref(), follows, &at.grasp);
        self.target = from.configuration;
        let input = plan.inputs.column(0).into_owned();
        Command {
            target: from.configuration,
            rates: from.rates,
            input: match way.motion {
                Motion::Residual(residual) => with_residual(robot, &from.rates, input, residual),
                _ => input,
            },
            outcome: plan.outcome,
            input_matrix,
            preparation: choice.map(|choice| Preparation {
                tracked,
                candidate: choice.index,
                candidates: choice.candidates,
                constrained: choice.solved,
            }),
            pose_cost: choice.map_or(0.0, |choice| choice.motion_cost),
        }
    }

    fn decision_basis(&self) -> Option<DecisionBasis<'_>> {
        let References { references, weights, .. } = &self.references;
        Some(DecisionBasis { references, weights, target: &self.target, poses: &self.poses })
    }

    fn save(&self) -> Saved {
        Saved::of(&self.references.intent)
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        let intent: Intent = saved.read("controller")?;
        self.references.intent = intent;
        Ok(())
    }
}
