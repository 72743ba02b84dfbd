//! The arms of a URDF: ends of its tree that are neither wheels, legs, heads nor fingers, and the link at each
//! that holds an object.

use super::draft_legs::LEGS;
use super::draft_tree::{
    carrier, independent, is_within, joint_name, link_says, moving, names, path, says, upward,
};
use super::link::{JointKind, Link};
use crate::geometry::Pose;
use std::cmp::Reverse;

/// An arm.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Arm {
    /// The link that holds an object.
    pub tool: usize,
    /// The links that independent joints move, from the base outward.
    pub joints: Vec<usize>,
    /// Those of them that no other arm has.
    pub own: Vec<usize>,
    /// How much the name and shape of its end are a tool's; less is likelier.
    rank: usize,
}

/// Parts of the names of tools, the likeliest first.
const TOOLS: [&str; 16] = [
    "grasping_frame",
    "grasp",
    "tcp",
    "tool",
    "end_effector",
    "ee_link",
    "gripper_link",
    "gripper",
    "palm",
    "hand",
    "endeffector",
    "eoat",
    "ee",
    "suction",
    "flange",
    "wrist",
];
/// The number of those that nothing else is named by.
const SURE_TOOLS: usize = 6;
/// The rank of an end with fingers whose name says nothing: that of a hand.
const HAND: usize = 9;
/// Words in the names of links at an arm's end that do not hold an object.
const NO_TOOLS: [&str; 38] = [
    "finger",
    "fingers",
    "fingertip",
    "thumb",
    "index",
    "middle",
    "ring",
    "little",
    "pinky",
    "jaw",
    "knuckle",
    "camera",
    "optical",
    "sensor",
    "safety",
    "ft",
    "laser",
    "imu",
    "head",
    "screw",
    "led",
    "touch",
    "caster",
    "castor",
    "wheel",
    "bumper",
    "sonar",
    "lidar",
    "kinect",
    "realsense",
    "aruco",
    "tag",
    "marker",
    "microphone",
    "speaker",
    "inertial",
    "battery",
    "tablet",
];
/// Words in the names of moving links that end no arm: of heads, wheels and casters, and of sensors that turn.
const NO_ARMS: [&str; 15] = [
    "head",
    "neck",
    "camera",
    "caster",
    "castor",
    "wheel",
    "lidar",
    "laser",
    "kinect",
    "realsense",
    "bumper",
    "door",
    "drawer",
    "brush",
    "propeller",
];
/// Words in the names of fingers.
const FINGERS: [&str; 14] = [
    "finger",
    "fingers",
    "fingertip",
    "thumb",
    "jaw",
    "knuckle",
    "claw",
    "index",
    "middle",
    "pinky",
    "proximal",
    "distal",
    "phalanx",
    "tendon",
];
/// Words in the names of joints that open a gripper, and of those that turn one.
const GRIPPERS: [&str; 4] = ["gripper", "grip", "grasp", "clamp"];
const WRISTS: [&str; 7] = ["roll", "yaw", "pitch", "rotate", "rotation", "wrist", "flex"];
/// The most prismatic joints of an arm: a lift, and a telescope of four.
const MAX_SLIDES: usize = 5;
/// The least number of joints above fingers.
const MIN_ABOVE_FINGERS: usize = 2;
/// The farthest that a finger extends from its first joint, m.
const MAX_FINGER_M: f64 = 0.25;
/// A frame is at another place if it is this far away, m.
const APART_M: f64 = 0.02;
/// Joints that place a grasp anywhere.
const ENOUGH_JOINTS: usize = 6;
/// The least number of own joints of an arm that is worth mentioning besides another: a head has two.
const MIN_OWN: usize = 3;

/// Whether a name says that its link does not hold an object.
pub(super) fn is_no_tool(name: &str) -> bool {
    says(name, &NO_TOOLS)
}

/// How much a link's name is a tool's; less is likelier.
fn tool_rank(link: &Link) -> usize {
    let name = link.name.to_lowercase();
    let is_named = |part: &str| if part.len() > 3 { name.contains(part) } else { says(&name, &[part]) };
    TOOLS.iter().position(|part| is_named(part)).unwrap_or(TOOLS.len())
}

/// The arms that descend from a base, the likeliest first; `wheels` and what they carry are none.
pub(super) fn arms(links: &[Link], poses: &[Pose], base: usize, wheels: &[usize]) -> Vec<Arm> {
    let tree = Tree::new(links, poses, base, wheels);
    let is_arm = |&i: &usize| tree.is_end(i) && !link_says(links, i, &LEGS);
    let ends: Vec<usize> = (0..links.len()).filter(is_arm).collect();
    let paths: Vec<Vec<usize>> = ends.iter().map(|&end| path(links, base, end).unwrap_or_default()).collect();
    let arm = |(n, path): (usize, &Vec<usize>)| {
        let joints: Vec<usize> = path.iter().copied().filter(|&i| independent(links, i).is_some()).collect();
        let of_another = |i: &usize| paths.iter().enumerate().any(|(m, other)| m != n && other.contains(i));
        let own = joints.iter().copied().filter(|i| !of_another(i)).collect();
        let (tool, rank) = tree.tool(ends[n]);
        is_possible(links, path).then_some(Arm { tool, joints, own, rank })
    };
    let mut arms: Vec<Arm> = paths.iter().enumerate().filter_map(arm).collect();
    arms.retain(|arm| !arm.joints.is_empty());
    arms.sort_by_key(|arm| {
        let own = arm.own.len().min(ENOUGH_JOINTS);
        (Reverse(own), arm.rank, Reverse(arm.joints.len()), arm.tool)
    });
    arms
}

impl Arm {
    /// Whether it could carry in place of another one.
    pub fn is_another(&self) -> bool {
        self.own.len() >= MIN_OWN
    }

    /// Whether it carries a link.
    pub fn carries(&self, links: &[Link], link: usize) -> bool {
        self.own.first().is_some_and(|&top| is_within(links, link, top))
    }
}

/// Whether the program can move an arm of these links.
fn is_possible(links: &[Link], path: &[usize]) -> bool {
    let joints = || path.iter().filter_map(|&at| links[at].joint.as_ref());
    let slides = joints().filter(|joint| joint.kind == JointKind::Prismatic).count();
    let is_known = |kind| !matches!(kind, JointKind::Floating | JointKind::Planar | JointKind::Spherical);
    slides <= MAX_SLIDES && joints().all(|joint| is_known(joint.kind))
}

/// The links below a base, with those that are part of no arm.
struct Tree<'a> {
    links: &'a [Link],
    poses: &'a [Pose],
    base: usize,
    /// Whether a link is part of no arm.
    is_out: Vec<bool>,
}

impl<'a> Tree<'a> {
    fn new(links: &'a [Link], poses: &'a [Pose], base: usize, wheels: &[usize]) -> Self {
        let mut tree = Self { links, poses, base, is_out: vec![false; links.len()] };
        for i in 0..links.len() {
            let is_above_out = links[i].parent.is_some_and(|parent| tree.is_out[parent]);
            tree.is_out[i] =
                i != base && is_within(links, i, base) && (is_above_out || tree.is_no_arm(i, wheels));
        }
        let fingers: Vec<usize> = (0..links.len()).filter(|&i| tree.is_finger(i)).collect();
        for i in 0..links.len() {
            tree.is_out[i] |= upward(links, i).any(|above| fingers.contains(&above));
        }
        tree
    }

    /// Whether a link is a wheel, carries one, or is the first one of a head, by its names.
    fn is_no_arm(&self, i: usize, wheels: &[usize]) -> bool {
        let links = self.links;
        let carries = || wheels.iter().any(|&wheel| is_within(links, wheel, i));
        let is_named =
            || link_says(links, i, &NO_ARMS) || names(&links[i]).iter().any(|name| says(name, &["wheel"]));
        wheels.contains(&i) || moving(links, i).is_some() && (carries() || is_named())
    }

    /// Whether a joint moves a link below the base, and none below it moves.
    fn is_end(&self, i: usize) -> bool {
        let moves = |i: usize| !self.is_out[i] && moving(self.links, i).is_some();
        let is_below = i != self.base && is_within(self.links, i, self.base);
        is_below && moves(i) && !(i + 1..self.links.len()).any(|j| moves(j) && is_within(self.links, j, i))
    }

    /// Whether a link is the first one of a finger, or of another moving part of a hand.
    fn is_finger(&self, i: usize) -> bool {
        let Some(joint) = moving(self.links, i).filter(|_| !self.is_out[i]) else { return false };
        let above = upward(self.links, i).skip(1).take_while(|&at| at != self.base);
        let above = above.filter(|&at| independent(self.links, at).is_some()).count();
        if above < MIN_ABOVE_FINGERS || !self.is_short(i) {
            return false;
        }
        let opens = says(&joint.name, &GRIPPERS) && !says(&joint.name, &WRISTS);
        // a part that mimics a joint above it keeps a wrist level, unless the tool is beside it
        let is_above = |name: &str| upward(self.links, i).any(|at| joint_name(self.links, at) == name);
        let is_part = |name: &str| !is_above(name) || self.is_beside_tool(i);
        let mimics = joint.mimic.as_ref().is_some_and(|mimic| is_part(&mimic.joint));
        if link_says(self.links, i, &FINGERS) || opens || mimics {
            return true;
        }
        // several short parts side by side are a hand
        let hand = carrier(self.links, self.base, self.links[i].parent.unwrap_or(i));
        let is_beside = |j: usize| {
            let is_part = !self.is_out[j] && moving(self.links, j).is_some();
            is_part && self.links[j].parent.is_some_and(|p| carrier(self.links, self.base, p) == hand)
        };
        let parts: Vec<usize> = (0..self.links.len()).filter(|&j| is_beside(j)).collect();
        above > MIN_ABOVE_FINGERS && parts.len() >= 2 && parts.iter().all(|&j| self.is_short(j))
    }

    /// Whether a link that is a tool by its name is rigid with the link that carries this one.
    fn is_beside_tool(&self, i: usize) -> bool {
        let links = self.links;
        let hand = carrier(links, self.base, links[i].parent.unwrap_or(i));
        let is_rigid = |j: usize| j != hand && carrier(links, self.base, j) == hand;
        (0..links.len()).any(|j| is_rigid(j) && tool_rank(&links[j]) < SURE_TOOLS)
    }

    /// Whether all frames that a link carries are near its joint.
    fn is_short(&self, i: usize) -> bool {
        let at = |i: usize| self.poses[i].translation.vector;
        let carried = (i..self.links.len()).filter(|&j| is_within(self.links, j, i));
        carried.into_iter().all(|j| (at(j) - at(i)).norm() <= MAX_FINGER_M)
    }

    /// The link of an arm's end that holds an object, and its rank: by its name, then the end of the tree.
    fn tool(&self, end: usize) -> (usize, usize) {
        let links = self.links;
        let is_rigid = |i: usize| !self.is_out[i] && carrier(links, self.base, i) == end;
        let is_hand =
            (end + 1..links.len()).any(|i| self.is_out[i] && is_within(links, i, end) && self.is_part(i));
        let rank = |i: usize| tool_rank(&links[i]);
        let parts = (end..links.len()).filter(|&i| is_rigid(i) && (i == end || !is_no_tool(&links[i].name)));
        let best = parts.clone().min_by_key(|&i| (rank(i), i)).unwrap_or(end);
        if rank(best) < TOOLS.len() {
            return (best, rank(best));
        }
        let away = |i: usize| (self.poses[i].translation.vector - self.poses[end].translation.vector).norm();
        let farthest = parts.filter(|&i| away(i) > APART_M).max_by(|&a, &b| away(a).total_cmp(&away(b)));
        (farthest.unwrap_or(end), if is_hand { HAND } else { TOOLS.len() })
    }

    /// Whether a link that is part of no arm is part of a hand: a finger and no camera.
    fn is_part(&self, i: usize) -> bool {
        moving(self.links, i).is_some() && !says(joint_name(self.links, i), &NO_ARMS)
    }
}
