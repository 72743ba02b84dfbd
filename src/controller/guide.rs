//! The base of a team with bodies follows the path of its grasp; the arm does the rest.

use super::hitch::Hitch;
use crate::control::{BaseInputs, Follower, HORIZON, Manipulator};
use crate::geometry::{PlanarPose, Point, angle_of};
use crate::plant::Seen;
use crate::robot::{BaseInput, Configuration, Drive};
use crate::team::{PathAhead, TEAM_ACCELERATION, Walk};

/// The share of the rims' largest acceleration that the base plans with.
const RIM_SHARE: f64 = 0.8;
/// The least distance of the grasp from a differential base's axis that counts, m.
const MIN_LATERAL_OFFSET_M: f64 = 1e-3;

/// Where the base keeps relative to the grasp's path.
#[derive(Clone, Debug)]
pub struct Guide {
    /// Initial distance of the base behind the grasp, m, which the base keeps.
    distance: f64,
    /// Initial bearing of the grasp from straight ahead of the base, rad; 0 on a differential base.
    bearing: f64,
    /// Lateral offset of a differential base to the right of the grasp's path, m; constant.
    lateral_offset: f64,
    /// Acceleration of the rims that the base plans with, m/s^2.
    rim_acceleration: f64,
    /// How the base follows a grasp whose reference is not on a path.
    hitch: Hitch,
    /// Buffer: the past path of the grasp.
    way: Vec<Point>,
}

impl Guide {
    /// The guide of a base that starts in the manipulator's posture. `rim_acceleration` is the largest,
    /// m/s^2.
    pub fn new(manipulator: &Manipulator, rim_acceleration: f64) -> Self {
        let Manipulator { robot, posture, .. } = *manipulator;
        let at_origin = PlanarPose { position: Point::origin(), yaw: 0.0 };
        let configuration = Configuration { base: at_origin, joints: posture };
        let held = robot.grasp_pose(&configuration).translation.vector.xy();
        let is_free = robot.drive.is_omnidirectional();
        let (distance, bearing) = if is_free { (held.norm(), angle_of(held)) } else { (held.x, 0.0) };
        let lateral_offset = if is_free || held.y.abs() < MIN_LATERAL_OFFSET_M { 0.0 } else { held.y };
        let rim_acceleration = RIM_SHARE * rim_acceleration;
        Self {
            distance,
            bearing,
            lateral_offset,
            rim_acceleration,
            hitch: Hitch::new([distance, lateral_offset, bearing], rim_acceleration),
            way: Vec::with_capacity(64),
        }
    }

    /// The guide of a base that has no room for its arm to make up for its turning: one that holds the grasp to its
    /// side. `None` for others.
    pub fn of_lateral(manipulator: &Manipulator) -> Option<Self> {
        let guide = Self::new(manipulator, f64::INFINITY);
        (guide.lateral_offset != 0.0).then_some(guide)
    }

    /// Whether the base moves beside the path of its grasp: then it cannot follow that path, since inside of a bend it
    /// has to go back.
    pub fn is_beside(&self) -> bool {
        self.lateral_offset != 0.0
    }

    /// Inputs with which the base follows a grasp that goes from `grasp` through `poses`, one per `period`
    /// (s), wherever the team's path is.
    pub fn following(
        &self,
        seen: &Seen<'_>,
        (grasp, poses): (&PlanarPose, &[PlanarPose; HORIZON]),
        drive: &Drive,
        period: f64,
    ) -> Option<BaseInputs> {
        let bodies = seen.bodies?;
        let base = &bodies.configuration.base;
        Some(self.hitch.inputs(drive, base, bodies.base_rates, (grasp, poses), period))
    }

    /// The same for a base that takes any speed at once.
    pub fn following_at_once(
        &self,
        base: &PlanarPose,
        (grasp, poses): (&PlanarPose, &[PlanarPose; HORIZON]),
        drive: &Drive,
        period: f64,
    ) -> BaseInputs {
        self.hitch.inputs(drive, base, BaseInput::zeros(), (grasp, poses), period)
    }

    /// Inputs with which the base follows the path of the grasp, where the human is seen to walk at `speed`
    /// (m/s).
    pub fn inputs(
        &mut self,
        seen: &Seen<'_>,
        walk: &dyn Walk,
        ahead: &PathAhead<'_>,
        speed: f64,
        manipulator: &Manipulator<'_>,
        period: f64,
    ) -> Option<BaseInputs> {
        let bodies = seen.bodies?;
        let speeds = walk.grasp_way(seen, ahead, speed, &mut self.way)?;
        let follower = Follower {
            way: &self.way,
            speeds,
            acceleration: TEAM_ACCELERATION,
            rim_acceleration: self.rim_acceleration,
            distance: self.distance,
            bearing: self.bearing,
            footprint: &manipulator.robot.footprint,
            obstacles: manipulator.obstacles,
        };
        let base = &bodies.configuration.base;
        Some(follower.inputs(&manipulator.robot.drive, base, bodies.base_rates, period))
    }
}
