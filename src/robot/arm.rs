//! The arm from the base to the grasp: its joints, its kinematic chain, and the coupling of every joint.

use super::arm_limits::{ArmLimits, GivenRates, checked_limits};
use super::link::{Coupling, Joint, JointKind, Limits, Link};
use super::urdf::Urdf;
use super::warning::RobotWarning;
use super::{ArmJoint, ChainLink, MAX_JOINTS, MAX_LISTED, Motion};
use crate::error::{Error, Place};
use crate::geometry::Pose;
use crate::suggestion::listed;
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::collections::BTreeMap;

/// A joint under `[hold]`.
pub(super) struct Hold<'a> {
    pub joint: &'a str,
    pub angle_deg: Option<f64>,
    pub position_m: Option<f64>,
    pub place: Place,
}

/// The arm's joints and kinematic chain.
pub(super) struct Arm {
    pub joints: Vec<ArmJoint>,
    pub chain: Vec<ChainLink>,
    pub last_from_grasp: Pose,
    pub warnings: Vec<RobotWarning>,
}

/// The two ends of the arm: indices of links, and the place in the robot file that names the grasp; and the
/// rates that it gives to joints without any.
pub(super) struct Ends {
    pub base: usize,
    pub grasp: usize,
    pub drive_from_base: Pose,
    pub place: Place,
    pub rates: GivenRates,
}

impl Arm {
    /// Finds the arm and sets the coupling of every joint.
    pub fn new(
        urdf: Urdf,
        links: &mut [Link],
        ends: &Ends,
        held: &BTreeMap<usize, f64>,
    ) -> Result<Self, Error> {
        let fault = |why: String| Error::at(ends.place.clone(), why);
        let path = path(links, ends).map_err(fault)?;
        let mut limits = ArmLimits::new(urdf, ends.rates);
        let moving: Vec<usize> = movable(urdf, links, &path)?
            .into_iter()
            .filter(|&i| !joint(links, i).is_some_and(|joint| limits.is_locked(joint)))
            .collect();
        let driven: Vec<usize> = moving
            .iter()
            .copied()
            .filter(|&i| !held.contains_key(&i) && joint(links, i).is_some_and(|j| j.mimic.is_none()))
            .collect();
        couple(urdf, links, &driven, held)?;

        let base = &links[ends.base].name;
        if driven.is_empty() {
            return Err(fault(format!("no joint between it and `{base}` moves independently")));
        }
        if driven.len() > MAX_JOINTS {
            let joints =
                listed(driven.iter().filter_map(|&i| joint(links, i)).map(|j| j.name.as_str()), MAX_LISTED);
            return Err(fault(format!(
                "{} joints move independently between it and `{base}`, more than {MAX_JOINTS}; fix some of them under [hold]: {joints}",
                driven.len()
            )));
        }
        let mut joints = Vec::with_capacity(driven.len());
        for joint in driven.iter().filter_map(|&i| joint(links, i)) {
            let Limits { lower, upper, rate, effort } = limits.of_moving(joint)?;
            let (name, motion) = (joint.name.clone(), motion(joint.kind));
            joints.push(ArmJoint { name, motion, lower, upper, rate_limit: rate, effort_limit: effort });
        }
        let mut chain = Vec::new();
        let mut before = ends.drive_from_base;
        for joint in path.iter().filter_map(|&i| joint(links, i)) {
            let Coupling { joint: follows, ratio, offset } = joint.coupling;
            let Some(follows) = follows else {
                if joint.mimic.is_some() && moves(joint.kind) {
                    limits.check_standing(joint)?;
                }
                before *= joint.parent_from_link(offset);
                continue;
            };
            if joint.mimic.is_some() {
                limits.tighten(joint, &mut joints[follows])?;
            }
            let joint_from_axis = frame_about(&joint.axis);
            chain.push(ChainLink {
                before_from_joint: before * joint.parent_from_joint * joint_from_axis,
                motion: motion(joint.kind),
                joint: follows,
                ratio,
                offset,
            });
            before = Pose::from_parts(Default::default(), joint_from_axis.inverse());
        }
        let (count, most) = (chain.len(), 2 * MAX_JOINTS);
        if count > most {
            return Err(fault(format!(
                "{count} joints move between it and `{base}`, mimicking joints included, more than {most}"
            )));
        }
        Ok(Self { joints, chain, last_from_grasp: before, warnings: limits.warnings() })
    }
}

/// A rotation that takes z to `axis`; exact for an axis along a coordinate.
fn frame_about(axis: &Vector3<f64>) -> Rotation3<f64> {
    let mut across = Vector3::zeros();
    across[axis.iamin()] = 1.0;
    let y = axis.cross(&across).normalize();
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[y.cross(axis), y, *axis]))
}

fn joint(links: &[Link], i: usize) -> Option<&Joint> {
    links.get(i).and_then(|l| l.joint.as_ref())
}

pub(super) fn joint_place(urdf: Urdf, joint: &Joint) -> Place {
    urdf.place(format!("joint `{}`", joint.name))
}

fn motion(kind: JointKind) -> Motion {
    if kind == JointKind::Prismatic { Motion::Prismatic } else { Motion::Revolute }
}

fn moves(kind: JointKind) -> bool {
    matches!(kind, JointKind::Revolute | JointKind::Continuous | JointKind::Prismatic)
}

/// The links from behind the base to the grasp.
fn path(links: &[Link], ends: &Ends) -> Result<Vec<usize>, String> {
    if ends.base == ends.grasp {
        return Err("is the base link itself; name the link at the end of the arm".to_owned());
    }
    let mut path = vec![];
    let mut at = ends.grasp;
    while at != ends.base {
        path.push(at);
        let (base, root) = (&links[ends.base].name, &links[at].name);
        let elsewhere = || format!("does not descend from `{base}`: its root is `{root}`");
        at = links[at].parent.ok_or_else(elsewhere)?;
    }
    path.reverse();
    Ok(path)
}

/// The links of the path that a joint moves.
fn movable(urdf: Urdf, links: &[Link], path: &[usize]) -> Result<Vec<usize>, Error> {
    let mut moving = Vec::new();
    for &i in path {
        let Some(joint) = joint(links, i) else { continue };
        if moves(joint.kind) {
            moving.push(i);
        } else if joint.kind != JointKind::Fixed {
            return Err(Error::at(
                joint_place(urdf, joint),
                format_args!(
                    "is {}; between the base and the grasp a joint must be revolute, continuous, prismatic or fixed",
                    joint.kind.name()
                ),
            ));
        }
    }
    Ok(moving)
}

/// The positions (rad or m) of the held joints, by link: of any joint that moves but the wheels.
pub(super) fn held(
    urdf: Urdf,
    links: &[Link],
    wheels: &[usize],
    holds: &[Hold],
) -> Result<BTreeMap<usize, f64>, Vec<Error>> {
    let (mut held, mut faults) = (BTreeMap::new(), Vec::new());
    for hold in holds {
        match held_position(urdf, links, wheels, hold) {
            Ok((link, position)) => drop(held.insert(link, position)),
            Err(fault) => faults.push(fault),
        }
    }
    if faults.is_empty() { Ok(held) } else { Err(faults) }
}

/// The link of a held joint and its position, rad or m.
fn held_position(urdf: Urdf, links: &[Link], wheels: &[usize], hold: &Hold) -> Result<(usize, f64), Error> {
    let moving = (0..links.len()).filter(|i| !wheels.contains(i));
    let moving = moving.filter_map(|i| joint(links, i).map(|j| (i, j)));
    let named = moving.filter(|(_, j)| moves(j.kind));
    let Some((i, joint)) = named.clone().find(|(_, j)| j.name == hold.joint) else {
        let known = named.filter(|(_, j)| j.mimic.is_none()).map(|(_, j)| j.name.as_str());
        return Err(Error::unknown(hold.place.clone(), "moving joint", hold.joint, known, MAX_LISTED));
    };
    if let Some(mimic) = &joint.mimic {
        let needed = format!("an independent joint; it mimics `{}`, which may be held instead", mimic.joint);
        return Err(Error::missing(hold.place.clone(), needed));
    }
    let (key, scale, given, other) = match joint.kind {
        JointKind::Prismatic => ("position_m", 1.0, hold.position_m, hold.angle_deg),
        _ => ("angle_deg", 1f64.to_radians(), hold.angle_deg, hold.position_m),
    };
    let (Some(value), None) = (given, other) else {
        return Err(other_unit(hold.place.clone(), &joint.name, joint.kind.name(), key));
    };
    let limits = checked_limits(urdf, joint)?;
    let position = value * scale;
    if !position.is_finite() || position < limits.lower || position > limits.upper {
        let expected = format!("from {} to {}", limits.lower / scale, limits.upper / scale);
        return Err(Error::number(hold.place.clone(), key, value, &expected));
    }
    Ok((i, position))
}

/// The error of a position that is given under the key for the other kind of joint.
pub(super) fn other_unit(place: Place, joint: &str, kind: &str, key: &str) -> Error {
    Error::at(place, format_args!("`{joint}` is {kind}; give its position as {key}"))
}

/// Sets the coupling of every joint. A joint may mimic one that is neither driven nor held, such as one
/// outside the arm; it then stays at the position that follows from that joint's position 0.
fn couple(
    urdf: Urdf,
    links: &mut [Link],
    driven: &[usize],
    held: &BTreeMap<usize, f64>,
) -> Result<(), Error> {
    for i in 0..links.len() {
        let (master, ratio, offset) = followed(urdf, links, i)?;
        let driver = driven.iter().position(|&d| d == master).filter(|_| ratio != 0.0);
        let rest = held.get(&master).copied().unwrap_or(0.0);
        let coupling = match driver {
            Some(joint) => Coupling { joint: Some(joint), ratio, offset },
            None => Coupling { joint: None, ratio, offset: ratio * rest + offset },
        };
        if let Some(joint) = &mut links[i].joint {
            joint.coupling = coupling;
        }
    }
    Ok(())
}

/// The link whose joint drives the joint of link `i` through all mimics, with ratio and offset; `i` itself, 1
/// and 0 if the joint mimics none.
fn followed(urdf: Urdf, links: &[Link], i: usize) -> Result<(usize, f64, f64), Error> {
    let (mut at, mut ratio, mut offset) = (i, 1.0, 0.0);
    let mut seen = vec![i];
    while let Some((follower, mimic)) = joint(links, at).and_then(|j| Some((j, j.mimic.as_ref()?))) {
        let named = |l: &Link| l.joint.as_ref().is_some_and(|j| j.name == mimic.joint);
        at = links.iter().position(named).ok_or_else(|| {
            let known = links.iter().filter_map(|l| Some(l.joint.as_ref()?.name.as_str()));
            Error::unknown(joint_place(urdf, follower), "joint to mimic", &mimic.joint, known, MAX_LISTED)
        })?;
        offset += ratio * mimic.offset;
        ratio *= mimic.ratio;
        seen.push(at);
        if seen[..seen.len() - 1].contains(&at) {
            let names = seen.iter().filter_map(|&s| joint(links, s)).map(|j| format!("`{}`", j.name));
            let circle = names.collect::<Vec<_>>().join(" follows ");
            return Err(Error::at(
                joint_place(urdf, follower),
                format_args!("mimics itself: {circle}; a joint must follow one that moves independently"),
            ));
        }
    }
    Ok((at, ratio, offset))
}
