//! The limits of the arm's joints: those of the URDF, and what stands in for those that it does not give.

use super::ArmJoint;
use super::arm::joint_place;
use super::link::{Coupling, Joint, JointKind, Limits};
use super::plausible::about_joints;
use super::urdf::Urdf;
use super::warning::RobotWarning;
use crate::error::{Error, Place};

/// Rate limits of joints without any, where the robot file gives none: rad/s and m/s.
const ASSUMED_TURNING: f64 = 1.0;
const ASSUMED_SLIDING: f64 = 0.1;

/// The rate limits that the robot file gives for joints of the arm without any: rad/s and m/s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GivenRates {
    pub turning: Option<f64>,
    pub sliding: Option<f64>,
}

/// Reads the limits of the arm's joints, and keeps the names of those that lack some.
pub(super) struct ArmLimits<'a> {
    urdf: Urdf<'a>,
    given: GivenRates,
    turning: Vec<String>,
    sliding: Vec<String>,
    without_effort: Vec<String>,
    without_range: Vec<String>,
    locked: Vec<String>,
}

impl<'a> ArmLimits<'a> {
    pub fn new(urdf: Urdf<'a>, given: GivenRates) -> Self {
        let none = Vec::new;
        Self {
            urdf,
            given,
            turning: none(),
            sliding: none(),
            without_effort: none(),
            without_range: none(),
            locked: none(),
        }
    }

    /// Whether a joint cannot move, since its limits are both 0. A joint without any limit is a fault.
    pub fn is_locked(&mut self, joint: &Joint) -> bool {
        let Limits { lower, upper, rate, .. } = joint.limits;
        let is_locked = joint.mimic.is_none() && [lower, upper] == [0.0; 2] && rate > 0.0;
        if is_locked {
            self.locked.push(joint.name.clone());
        }
        is_locked
    }

    /// The limits of a joint that moves by itself.
    pub fn of_moving(&mut self, joint: &Joint) -> Result<Limits, Error> {
        let mut limits = checked_limits(self.urdf, joint)?;
        if !has_rate(&limits) {
            let is_slide = joint.kind == JointKind::Prismatic;
            limits.rate = self.rate(is_slide);
            if is_slide { &mut self.sliding } else { &mut self.turning }.push(joint.name.clone());
        }
        if limits.effort.is_infinite() {
            self.without_effort.push(joint.name.clone());
        }
        if joint.kind != JointKind::Continuous && limits.upper.is_infinite() {
            self.without_range.push(joint.name.clone());
        }
        Ok(limits)
    }

    fn rate(&self, is_slide: bool) -> f64 {
        match is_slide {
            true => self.given.sliding.unwrap_or(ASSUMED_SLIDING),
            false => self.given.turning.unwrap_or(ASSUMED_TURNING),
        }
    }

    /// Checks the position of a joint that mimics a fixed one.
    pub fn check_standing(&self, joint: &Joint) -> Result<(), Error> {
        let (limits, position) = (checked_limits(self.urdf, joint)?, joint.coupling.offset);
        if (limits.lower..=limits.upper).contains(&position) {
            return Ok(());
        }
        let expected = format!("from {} to {}", limits.lower, limits.upper);
        let key = "position that it mimics (rad or m)";
        Err(Error::number(joint_place(self.urdf, joint), key, position, &expected))
    }

    /// Narrows an arm joint's limits so that a joint that mimics it stays within its own. A follower without a
    /// rate limit is as fast as it must be.
    pub fn tighten(&self, follower: &Joint, arm_joint: &mut ArmJoint) -> Result<(), Error> {
        let limits = checked_limits(self.urdf, follower)?;
        let Coupling { ratio, offset, .. } = follower.coupling;
        let ends = [limits.lower, limits.upper].map(|limit| (limit - offset) / ratio);
        arm_joint.lower = arm_joint.lower.max(ends[0].min(ends[1]));
        arm_joint.upper = arm_joint.upper.min(ends[0].max(ends[1]));
        if has_rate(&limits) {
            arm_joint.rate_limit = arm_joint.rate_limit.min(limits.rate / ratio.abs());
        }
        if arm_joint.lower >= arm_joint.upper {
            let item = format!("joint `{}`, which `{}` mimics,", arm_joint.name, follower.name);
            return Err(bad_limits(self.urdf.place(item), arm_joint.lower, arm_joint.upper));
        }
        Ok(())
    }

    /// What stands in for limits that are missing.
    pub fn warnings(&self) -> Vec<RobotWarning> {
        let rate = |is_slide: bool| {
            let (key, unit) = if is_slide { ("m_s", "m/s") } else { ("rad_s", "rad/s") };
            format!(
                "have no limit velocity in the URDF and move at {} {unit} at most (arm_rate_limit_{key} in the robot file)",
                self.rate(is_slide)
            )
        };
        let said = [
            (&self.turning, rate(false)),
            (&self.sliding, rate(true)),
            (&self.without_effort, "have no limit effort in the URDF, or 0, and none is assumed".to_owned()),
            (&self.without_range, "have no lower and upper limit, and move freely".to_owned()),
            (&self.locked, "have limits of 0, and stay there".to_owned()),
        ];
        let unused = [
            (self.given.turning, &self.turning, "arm_rate_limit_rad_s"),
            (self.given.sliding, &self.sliding, "arm_rate_limit_m_s"),
        ];
        let unused = unused.into_iter().filter(|(given, names, _)| given.is_some() && names.is_empty());
        let unused = unused.map(|(_, _, key)| {
            RobotWarning::new(format!(
                "{key} changes nothing: the URDF gives every such joint a limit velocity"
            ))
        });
        let about = said.iter().filter_map(|(names, what)| {
            about_joints(&names.iter().map(String::as_str).collect::<Vec<_>>(), what)
        });
        about.chain(unused).collect()
    }
}

fn has_rate(limits: &Limits) -> bool {
    limits.rate > 0.0 && limits.rate.is_finite()
}

/// The error of a lower limit that is not below the upper one.
pub(super) fn bad_limits(place: Place, lower: f64, upper: f64) -> Error {
    Error::at(place, format_args!("invalid limits: lower {lower} must be below upper {upper}"))
}

/// Limits of a joint between the base and the grasp, where limits are required.
pub(super) fn checked_limits(urdf: Urdf, joint: &Joint) -> Result<Limits, Error> {
    let limits = joint.limits;
    if [limits.lower, limits.upper, limits.rate] == [0.0; 3] {
        let needed =
            format!("<limit> with lower, upper and velocity; a {} joint needs it", joint.kind.name());
        return Err(Error::missing(joint_place(urdf, joint), needed));
    }
    if limits.lower >= limits.upper {
        return Err(bad_limits(joint_place(urdf, joint), limits.lower, limits.upper));
    }
    Ok(limits)
}
