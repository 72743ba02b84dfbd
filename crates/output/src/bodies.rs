//! The bodies of an episode as pictures show them.

use cocarry::episode::Episode;
use cocarry::geometry::{PlanarPose, Pose, direction};
use cocarry::robot::BaseInput;
use cocarry::scenario::PreparedScenario;
use cocarry::simulation::{TORSO_AHEAD, TORSO_HEIGHT};
use nalgebra::{Rotation3, Translation3, Vector3};

/// `world_from_link` of every link of the robot, its wheels turned as far as they have rolled; `None` without a
/// robot.
pub fn link_poses(episode: &Episode, prepared: &PreparedScenario) -> Option<Vec<Pose>> {
    let (robot, mut poses) = (prepared.robot()?, episode.link_poses()?);
    let rolled = episode.observation().map_or(BaseInput::zeros(), |seen| seen.rolled);
    for wheel in &robot.wheels {
        if let Some(joint) = &robot.links[wheel.link].joint {
            poses[wheel.link] *= Rotation3::from_axis_angle(&joint.axis, wheel.of(&rolled));
        }
    }
    Some(poses)
}

/// Object, hand and torso.
#[derive(Clone, Copy, Debug)]
pub struct Bodies {
    /// `world_from_object`: its centre.
    pub object: Pose,
    /// `world_from_hand`.
    pub hand: Pose,
    /// `world_from_torso`: its middle.
    pub torso: Pose,
}

impl Bodies {
    /// The bodies of an episode as they are now; `None` of a team that is a point.
    pub fn of(episode: &Episode, prepared: &PreparedScenario) -> Option<Self> {
        if let Some(seen) = episode.observation() {
            return Some(Self { object: seen.object, hand: seen.hand, torso: seen.torso });
        }
        let robot = prepared.robot()?;
        let goal = episode.human()?.at_height(robot.grasp_height);
        let grasp = episode.link_poses()?[robot.grasp_link];
        Some(Self::around(&grasp, &goal, prepared.world().object.size[0]))
    }

    /// The bodies of a team that has none: at the grasp, and where the human would be around s.
    pub fn around(grasp: &Pose, goal: &Pose, length: f64) -> Self {
        let hand = goal * Translation3::new(length, 0.0, 0.0);
        let object = grasp * Translation3::new(length / 2.0, 0.0, 0.0);
        Self { object, hand, torso: torso_ahead_of(&hand) }
    }
}

/// The torso of a human whose hand is here: upright, ahead of it.
pub fn torso_ahead_of(hand: &Pose) -> Pose {
    let yaw = PlanarPose::from_above(hand).yaw;
    let ahead = direction(yaw) * TORSO_AHEAD;
    let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw);
    let at = hand.translation.vector + Vector3::new(ahead.x, ahead.y, 0.0);
    Pose::from_parts(Translation3::new(at.x, at.y, TORSO_HEIGHT / 2.0), turned)
}
