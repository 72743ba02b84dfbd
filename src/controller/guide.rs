//! The base of a team with bodies follows the path of its grasp; the arm does the rest.

use super::hitch::Hitch;
use crate::control::{BaseInputs, Follower, HORIZON, LOOK_OUT_TOLERANCE_M, Manipulator};
use crate::geometry::{PlanarPose, Point, angle_of};
use crate::plant::Seen;
use crate::robot::{BaseInput, Configuration, Drive};
use crate::team::{PathAhead, TEAM_ACCELERATION, Walk};

/// The share of the rims' largest acceleration that the base plans with.
const RIM_SHARE: f64 = 0.8;
/// Where the base is hitched: at this share of the distance between base and grasp, ahead of the base; the
/// remainder is behind the grasp, on the object's line. Hitched at the grasp itself, the object could not
/// turn far without the wrist out of reach, and the base could not follow a bend narrower than the whole
/// distance.
const HITCH_SHARE: f64 = 0.6;

/// The way ahead and back (m) below which an arm is taken to have no room for what a bend asks of it: TIAGo
/// dual's, of 0.22 m, has not; UR3's, of 0.35 m, has.
const LITTLE_REACH_M: f64 = 0.25;

/// What a base follows.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Follows {
    /// The path of the grasp.
    Path,
    /// The grasp, like a trailer, where that leads to no obstacle, and else its path: a differential base whose
    /// arm moves the grasp to the side only about a hinge, or ahead and back by little.
    GraspWhereClear,
    /// The grasp, like a trailer: a differential base that holds it to its side, and has to go back inside of a
    /// bend.
    Grasp,
}

/// Where the base keeps relative to the grasp's path.
#[derive(Clone, Debug)]
pub struct Guide {
    /// Initial distance of the base behind the grasp, m, which the base keeps.
    distance: f64,
    /// Initial bearing of the grasp from straight ahead of the base, rad; 0 on a differential base.
    bearing: f64,
    follows: Follows,
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
        let offset = robot.kept_offset(&posture);
        let hinge = if is_free { None } else { robot.hinge(&posture) };
        let usual = HITCH_SHARE * distance;
        // at the hinge, such an arm need not move its grasp to the side, but the base cuts corners
        let hitched = hinge.map_or(usual, |hinge| (hinge + usual) / 2.0);
        let rim_acceleration = RIM_SHARE * rim_acceleration;
        Self {
            distance,
            bearing,
            follows: match hinge {
                _ if offset != 0.0 => Follows::Grasp,
                Some(_) => Follows::GraspWhereClear,
                None if !is_free && robot.reach(&posture).length() < LITTLE_REACH_M => {
                    Follows::GraspWhereClear
                }
                None => Follows::Path,
            },
            rim_acceleration,
            hitch: Hitch::new([hitched, offset, bearing], distance - hitched, rim_acceleration),
            way: Vec::with_capacity(64),
        }
    }

    /// The guide of a base that takes any speed at once, if eq. (7) alone would turn it away.
    pub fn of_trailer(manipulator: &Manipulator) -> Option<Self> {
        let turns_away = manipulator.robot.turns_away(&manipulator.posture);
        turns_away.then(|| Self::new(manipulator, f64::INFINITY))
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
    /// (m/s); or the grasp, which goes from `grasp` through `poses`, like a trailer.
    pub fn inputs(
        &mut self,
        seen: &Seen<'_>,
        (walk, ahead): (&dyn Walk, &PathAhead<'_>),
        speed: f64,
        (grasp, poses): (&PlanarPose, &[PlanarPose; HORIZON]),
        manipulator: &Manipulator<'_>,
        period: f64,
    ) -> Option<BaseInputs> {
        let bodies = seen.bodies?;
        let Manipulator { robot, obstacles, .. } = *manipulator;
        if self.follows != Follows::Path {
            let trailing = self.following(seen, (grasp, poses), &robot.drive, period)?;
            let mut at = bodies.configuration.base;
            let mut is_clear = |input: &BaseInput| {
                at = robot.drive.roll(&at, &(input * period));
                obstacles.has_room(&at, &robot.footprint, LOOK_OUT_TOLERANCE_M)
            };
            if self.follows == Follows::Grasp || trailing.iter().all(&mut is_clear) {
                return Some(trailing);
            }
        }
        let speeds = walk.grasp_way(seen, ahead, speed, &mut self.way)?;
        let follower = Follower {
            way: &self.way,
            speeds,
            acceleration: TEAM_ACCELERATION,
            rim_acceleration: self.rim_acceleration,
            distance: self.distance,
            bearing: self.bearing,
            footprint: &robot.footprint,
            obstacles,
        };
        let base = &bodies.configuration.base;
        Some(follower.inputs(&robot.drive, base, bodies.base_rates, period))
    }
}
