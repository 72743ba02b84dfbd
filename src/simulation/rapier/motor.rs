//! The motor of an arm joint: a spring and a damper with a limited effort. A joint that mimics another has a
//! gear in its place: a stiff spring to where the other joint is, whose load that joint's motor bears.

use crate::geometry::Pose;
use crate::robot::{ArmJoint, Joint, JointKind, Robot};
use crate::simulation::convert::{to_rapier, to_vector};
use rapier3d::prelude::{
    GenericJoint, GenericJointBuilder, JointAxesMask, JointAxis, MultibodyJointHandle, PhysicsWorld,
};
use serde::{Deserialize, Serialize};

/// Stiffness as a multiple of the effort limit: at full effort a joint yields by the inverse of this, rad or
/// m.
const STIFFNESS_PER_EFFORT: f64 = 300.0;
/// Ratio of stiffness and damping, 1/s.
const STIFFNESS_PER_DAMPING: f64 = 50.0;
/// Effort that sets the stiffness of a motor without a limit, Nm or N.
const UNLIMITED_EFFORT: f64 = 200.0;
/// A value that stands for no limit, Nm or N, because infinity cannot be serialised.
const NO_LIMIT: f64 = 1e9;
/// Stiffness of the spring that stands for a constant effort, Nm/rad or N/m.
const SOFT: f64 = 1e-3;
/// How exactly a motor keeps its limit, as a share of it.
const TOLERANCE: f64 = 1e-6;
/// How far a joint's reference may run ahead of the joint while the motor is too weak, rad or m. The excess
/// is dropped.
const WINDUP_LIMIT: f64 = 0.02;
/// Distance to its limit at which a joint gets a stop, rad or m.
const STOP_DISTANCE: f64 = 0.1;

/// The spring and damper of a motor, or of a gear.
pub(super) struct MotorSpring {
    /// Largest effort, Nm or N; [`NO_LIMIT`] without one.
    pub most: f64,
    /// Stiffness, Nm/rad or N/m, and damping, the same times s.
    pub stiffness: f64,
    pub damping: f64,
}

impl MotorSpring {
    /// Spring and damper of a joint.
    pub fn of(joint: &Joint) -> Self {
        let limit = joint.limits.effort;
        let most = if joint.mimic.is_none() && limit > 0.0 { limit.min(NO_LIMIT) } else { NO_LIMIT };
        let stiffness = STIFFNESS_PER_EFFORT * most.min(UNLIMITED_EFFORT);
        Self { most, stiffness, damping: stiffness / STIFFNESS_PER_DAMPING }
    }

    /// The largest effort, Nm or N; `None` without a limit.
    pub fn limit(&self) -> Option<f64> {
        Some(self.most).filter(|most| *most < NO_LIMIT)
    }
}

/// The motor of a joint.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Motor {
    pub handle: MultibodyJointHandle,
    /// The arm joint that it drives or mimics: its position is `ratio * (that joint's) + offset`.
    pub joint: usize,
    pub ratio: f64,
    pub offset: f64,
    slides: bool,
    /// Whether it drives that joint itself.
    pub is_own: bool,
    /// Largest effort, Nm or N.
    most: f64,
    /// Stiffness, Nm/rad or N/m, and damping, the same times s.
    stiffness: f64,
    pub damping: f64,
    limits: [f64; 2],
    /// Rest position of the spring, as set in the last step.
    pub rest: f64,
    /// The effort that takes the place of spring and damper in the last step, Nm or N: it is at its limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    at_limit: Option<f64>,
}

impl Motor {
    /// The motor of `joint`, which is the robot's arm joint `driver`, or the gear from it to one that mimics
    /// it. It is at rest where that arm joint is at `start`.
    pub fn new(
        handle: MultibodyJointHandle,
        joint: &Joint,
        (driver, start): (usize, f64),
        robot: &Robot,
    ) -> Self {
        let MotorSpring { most, stiffness, damping } = MotorSpring::of(joint);
        let ArmJoint { lower, upper, .. } = robot.joints[driver];
        Self {
            handle,
            joint: driver,
            ratio: joint.coupling.ratio,
            offset: joint.coupling.offset,
            slides: joint.kind == JointKind::Prismatic,
            is_own: joint.mimic.is_none(),
            most,
            stiffness,
            damping,
            limits: [lower.max(-1e9), upper.min(1e9)],
            rest: joint.coupling.ratio * start + joint.coupling.offset,
            at_limit: None,
        }
    }

    /// Sets the motor for a step of `dt` seconds toward the joint's `reference` with its `rate`. Its effort
    /// and the load of its gears, `geared`, stay within its limit together. Pulls back a reference that it
    /// cannot follow. `None` if the bodies no longer exist.
    pub fn drive(
        &mut self,
        world: &mut PhysicsWorld,
        reference: &mut f64,
        rate: f64,
        geared: f64,
        dt: f64,
    ) -> Option<()> {
        let state = self.state(world)?;
        let [lower, upper] = self.limits;
        let within = reference.clamp(state.0 - WINDUP_LIMIT, state.0 + WINDUP_LIMIT);
        *reference = within.clamp(lower, upper);
        self.set_spring([*reference, rate], state, geared, dt);
        // a stop costs a constraint in every step, so add it only near the limit
        let is_near = state.0 < lower + STOP_DISTANCE || state.0 > upper - STOP_DISTANCE;
        self.apply(world, if is_near { self.axis().into() } else { JointAxesMask::empty() })
    }

    /// Sets the gear for a step of `dt` seconds, to where the joint that it follows goes from its position
    /// and rate.
    pub fn follow(&mut self, world: &mut PhysicsWorld, [at, rate]: [f64; 2], dt: f64) -> Option<()> {
        let state = self.state(world)?;
        self.set_spring([self.ratio * (at + dt * rate) + self.offset, self.ratio * rate], state, 0.0, dt);
        self.apply(world, JointAxesMask::empty())
    }

    /// Gives spring, damper and stop to rapier.
    pub fn apply(&self, world: &mut PhysicsWorld, stop: JointAxesMask) -> Option<()> {
        self.set(world)?;
        let (body, id) = world.multibody_joints.get_mut(self.handle)?;
        body.link_mut(id)?.joint.data.limit_axes = stop;
        Some(())
    }

    /// The stop that the joint has in a world.
    pub fn stop(&self, world: &PhysicsWorld) -> Option<JointAxesMask> {
        let (body, id) = world.multibody_joints.get(self.handle)?;
        Some(body.link(id)?.joint().data.limit_axes)
    }

    /// Gives spring and damper, or the constant effort in their place, to rapier.
    pub fn set(&self, world: &mut PhysicsWorld) -> Option<()> {
        let (body, id) = world.multibody_joints.get_mut(self.handle)?;
        let link = body.link_mut(id)?;
        let at = link.joint().coords()[self.coordinate()];
        let (stiffness, rest, damping) = match self.at_limit {
            None => (self.stiffness, self.rest, self.damping),
            // a spring so soft that its effort hardly changes within a step
            Some(effort) => (SOFT, at + effort / SOFT, 0.0),
        };
        link.joint.set_spring(self.coordinate(), stiffness, rest);
        let first = link.assembly_id();
        *body.damping_mut().get_mut(first)? = damping;
        Some(())
    }

    /// Whether the step that has been made has to be made again, since the motor exceeded its limit or was
    /// held at it needlessly: then its effort is the limit, or the spring's again. `geared` is the load of its
    /// gears.
    pub fn limit(&mut self, (position, rate): (f64, f64), geared: f64) -> bool {
        let wanted = self.spring_effort(position, rate) + geared;
        let now = self.at_limit.map(|effort| effort + geared);
        let within = wanted.clamp(-self.most, self.most);
        let is_same = match now {
            None => wanted.abs() <= self.most * (1.0 + TOLERANCE),
            Some(effort) => (within - effort).abs() <= TOLERANCE * self.most,
        };
        self.at_limit = if within == wanted { None } else { Some(within - geared) };
        !is_same
    }

    /// Position and rate of the joint.
    pub fn state(&self, world: &PhysicsWorld) -> Option<(f64, f64)> {
        let (body, id) = world.multibody_joints.get(self.handle)?;
        let link = body.link(id)?;
        Some((link.joint().coords()[self.coordinate()], *body.joint_velocity(link).get(0)?))
    }

    /// The effort in the last step, which ended with this position and rate. The spring is implicit, so this
    /// is exact.
    pub fn effort(&self, position: f64, rate: f64) -> f64 {
        self.at_limit.unwrap_or_else(|| self.spring_effort(position, rate))
    }

    fn spring_effort(&self, position: f64, rate: f64) -> f64 {
        self.stiffness * (self.rest - position) - self.damping * rate
    }

    /// An effort as a share of its limit; 0 without a limit.
    pub fn share(&self, effort: f64) -> f64 {
        if self.most < NO_LIMIT { effort.abs() / self.most } else { 0.0 }
    }

    /// Sets the spring for a step of `dt` seconds toward a position and a rate. The implicit effort and
    /// `geared` are clamped to its limit for a joint that keeps its rate; a change of rate during the step
    /// adds to it.
    fn set_spring(&mut self, [target, rate]: [f64; 2], (position, moving): (f64, f64), geared: f64, dt: f64) {
        let Self { stiffness, damping, most, .. } = *self;
        let rest = target + damping / stiffness * rate;
        let without = position + dt * moving + damping / stiffness * moving;
        let [least, most] = [-most, most].map(|limit| (limit - geared) / stiffness);
        self.rest = without + (rest - without).clamp(least, most);
        self.at_limit = None;
    }

    fn axis(&self) -> JointAxis {
        if self.slides { JointAxis::LinX } else { JointAxis::AngX }
    }

    /// The index of the joint's position in rapier's coordinates.
    fn coordinate(&self) -> usize {
        if self.slides { 0 } else { 3 }
    }
}

/// The stops of a joint, rad or m; `None` where it has none: it mimics another, or turns without end.
pub(super) fn stops(joint: &Joint, driver: &ArmJoint) -> Option<[f64; 2]> {
    let has_stops = joint.mimic.is_none() && driver.lower.is_finite() && driver.upper.is_finite();
    has_stops.then_some([driver.lower, driver.upper])
}

/// The joint between two clusters, with limits.
pub(super) fn joint_data(joint: &Joint, driver: &ArmJoint, frame: Pose) -> GenericJoint {
    let slides = joint.kind == JointKind::Prismatic;
    let (locked, axis) = if slides {
        (JointAxesMask::LOCKED_PRISMATIC_AXES, JointAxis::LinX)
    } else {
        (JointAxesMask::LOCKED_REVOLUTE_AXES, JointAxis::AngX)
    };
    // rapier's joints move about or along x, so both sides use the same basis
    let basis = rapier3d::math::Pose::from_rotation(GenericJoint::complete_ang_frame(to_vector(&joint.axis)));
    let mut data = GenericJointBuilder::new(locked)
        .contacts_enabled(false)
        .local_frame1(to_rapier(&frame) * basis)
        .local_frame2(basis);
    if let Some(stops) = stops(joint, driver) {
        data = data.limits(axis, stops);
    }
    data.build()
}
