//! The poses of an episode's frames, and the states of its joints.

use super::frames::{GRASP_GOAL, HAND, HUMAN, OBJECT, ODOM, TORSO, WORLD, link_frame, timestamp, transform};
use super::human::{Stance, upright};
use cocarry::episode::Episode;
use cocarry::geometry::{PlanarPose, Pose, direction};
use cocarry::robot::{BaseInput, Robot};
use cocarry::scenario::PreparedScenario;
use cocarry::simulation::{Observation, TORSO_AHEAD, TORSO_HEIGHT};
use foxglove::messages::{FrameTransforms, JointState, JointStates};
use nalgebra::{Rotation3, Translation3, Vector3};

/// Object, hand and torso.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bodies {
    pub object: Pose,
    pub hand: Pose,
    pub torso: Pose,
}

impl Bodies {
    /// The bodies of a team that has none: at the grasp, and where the human would be around s.
    pub fn around(grasp: &Pose, goal: &Pose, length: f64) -> Self {
        let hand = goal * Translation3::new(length, 0.0, 0.0);
        let object = grasp * Translation3::new(length / 2.0, 0.0, 0.0);
        Self { object, hand, torso: torso_ahead_of(&hand) }
    }
}

/// The torso of a human whose hand is here: upright, ahead of it.
pub(super) fn torso_ahead_of(hand: &Pose) -> Pose {
    let yaw = PlanarPose::from_above(hand).yaw;
    let ahead = direction(yaw) * TORSO_AHEAD;
    let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw);
    let at = hand.translation.vector + Vector3::new(ahead.x, ahead.y, 0.0);
    Pose::from_parts(Translation3::new(at.x, at.y, TORSO_HEIGHT / 2.0), turned)
}

/// The poses of all frames, as a tree; empty for a team that is a point.
pub(super) fn transforms(episode: &Episode, prepared: &PreparedScenario, time: u64) -> FrameTransforms {
    let (Some(robot), Some(poses)) = (prepared.robot(), episode.link_poses()) else {
        return FrameTransforms::default();
    };
    let seen = episode.observation();
    let mut transforms = vec![transform(WORLD, ODOM, &Pose::identity(), time)];
    let rolled = seen.map_or(BaseInput::zeros(), |seen| seen.rolled);
    let world_from_link = |i: usize| {
        let wheel = robot.wheels.iter().find(|wheel| wheel.link == i);
        match (wheel, &robot.links[i].joint) {
            (Some(wheel), Some(joint)) => {
                poses[i] * Rotation3::from_axis_angle(&joint.axis, wheel.of(&rolled))
            }
            _ => poses[i],
        }
    };
    for (i, link) in robot.links.iter().enumerate() {
        let frame = link_frame(&link.name);
        transforms.push(match link.parent {
            Some(parent) => {
                let pose = world_from_link(parent).inverse() * world_from_link(i);
                transform(&link_frame(&robot.links[parent].name), &frame, &pose, time)
            }
            None => transform(ODOM, &frame, &world_from_link(i), time),
        });
    }
    let goal = episode.human().map(|goal| goal.at_height(robot.grasp_height));
    if let Some(goal) = &goal {
        transforms.push(transform(WORLD, GRASP_GOAL, goal, time));
    }
    let [length, width, _] = prepared.world().object.size;
    let bodies = match (seen, goal) {
        (Some(seen), _) => Bodies { object: seen.object, hand: seen.hand, torso: seen.torso },
        (None, Some(goal)) => Bodies::around(&poses[robot.grasp_link], &goal, length),
        (None, None) => return FrameTransforms { transforms },
    };
    let (tick, summary) = (episode.tick(), episode.summary());
    let facing = bodies.torso.rotation * Vector3::x();
    let is_backward = summary.steps > 0 && direction(tick.heading).dot(&facing.xy()) < 0.0;
    let Bodies { object, hand, torso } = bodies;
    let stance = Stance { torso, hand, width, walked: summary.walked, is_backward };
    transforms.push(transform(WORLD, OBJECT, &object, time));
    let figure = stance.transforms(time);
    let human_from_world = upright(&torso).inverse();
    transforms.extend(figure);
    transforms.push(transform(HUMAN, HAND, &(human_from_world * hand), time));
    transforms.push(transform(HUMAN, TORSO, &(human_from_world * torso), time));
    FrameTransforms { transforms }
}

/// The joints in the order of the robot's, then the wheels. On the kinematic plant, rates are the last
/// commanded ones.
pub(super) fn joints(episode: &Episode, robot: &Robot, time: u64) -> JointStates {
    let seen = episode.observation();
    let positions = episode.configuration().map(|q| q.joints);
    let commanded = episode.tick().robot.map(|tick| tick.input);
    let arm = robot.joints.iter().enumerate().map(|(j, joint)| JointState {
        name: joint.name.clone(),
        position: positions.map(|p| p[j]),
        velocity: seen.map(|s| s.joint_rates[j]).or(commanded.map(|u| robot.joint_rates(&u)[j])),
        acceleration: None,
        // there are no efforts before the first step
        effort: seen.filter(|s| s.time > 0.0).map(|s| s.joint_efforts[j]),
    });
    let wheels = robot.wheels.iter().map(|wheel| JointState {
        name: robot.links[wheel.link].joint.as_ref().map_or(String::new(), |j| j.name.clone()),
        position: seen.map(|s: &Observation| wheel.of(&s.rolled)),
        velocity: (seen.map(|s| s.base_rates).or(commanded.map(|u| robot.base_input(&u))))
            .map(|rates| wheel.of(&robot.drive.rolling(&rates))),
        acceleration: None,
        effort: None,
    });
    JointStates { timestamp: timestamp(time), joints: arm.chain(wheels).collect() }
}
