//! The poses of an episode's frames, and the states of its joints.

use super::frames::{GRASP_GOAL, HAND, HUMAN, OBJECT, ODOM, TORSO, WORLD, link_frame, timestamp, transform};
use super::human::{Stance, upright};
use cocarry::episode::Episode;
use cocarry::geometry::{Pose, direction};
use cocarry::robot::Robot;
use cocarry::scenario::PreparedScenario;
use cocarry::simulation::Observation;
use cocarry_output::bodies::{self, Bodies};
use foxglove::messages::{FrameTransforms, JointState, JointStates};
use nalgebra::Vector3;

/// The poses of all frames, as a tree; empty for a team that is a point.
pub(super) fn transforms(episode: &Episode, prepared: &PreparedScenario, time: u64) -> FrameTransforms {
    let (Some(robot), Some(poses)) = (prepared.robot(), bodies::link_poses(episode, prepared)) else {
        return FrameTransforms::default();
    };
    let mut transforms = vec![transform(WORLD, ODOM, &Pose::identity(), time)];
    let world_from_link = |i: usize| poses[i];
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
    let Some(Bodies { object, hand, torso }) = Bodies::of(episode, prepared) else {
        return FrameTransforms { transforms };
    };
    let width = prepared.world().object.size[1];
    let (tick, summary) = (episode.tick(), episode.summary());
    let facing = torso.rotation * Vector3::x();
    let is_backward = summary.steps > 0 && direction(tick.heading).dot(&facing.xy()) < 0.0;
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
