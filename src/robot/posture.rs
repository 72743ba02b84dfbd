//! Starting postures, closed so that they hold the object level at its height.

use super::arm::other_unit;
use super::file::PostureEntry;
use super::level::{FULL, HEIGHT_TOLERANCE_M, TURN_TOLERANCE_RAD};
use super::{Configuration, JointVector, MAX_LISTED, Motion, Posture, Robot};
use crate::error::Error;
use crate::geometry::{PlanarPose, Point, Pose};
use crate::located::Source;
use crate::math;
use nalgebra::{Rotation3, Vector3};
use toml::Spanned;

/// Largest deviation of the grasp from its pose, m and rad.
const TOLERANCE: f64 = 1e-12;
/// How far a revolute joint may move to close a posture, rad.
const MAX_TURN_RAD: f64 = 0.2;
/// How far a prismatic joint may move to close a posture, m.
const MAX_SLIDE_M: f64 = 0.05;

/// Reads a posture and closes it. x and y of the grasp stay as the given angles place them; height and
/// orientation become what the object needs. An arm that cannot place its grasp in any pose comes as near to
/// these as it can ([`Robot::level`]), and x and y are free.
pub(super) fn read(source: Source, spanned: &Spanned<PostureEntry>, robot: &Robot) -> Result<Posture, Error> {
    let entry = spanned.get_ref();
    let place = source.place(spanned, format!("posture `{}`", entry.name));
    let given = angles(source, spanned, robot)?;
    let base = PlanarPose { position: Point::origin(), yaw: 0.0 };
    let start = Configuration { base, joints: given };
    let grasp = robot.grasp_pose(&start);
    let at = grasp.translation.vector;
    let level = Vector3::new(at.x, at.y, robot.grasp_height);
    let level = Pose::from_parts(level.into(), Rotation3::identity());
    let fault = |why: String| {
        let [up, ahead] = [Vector3::z(), Vector3::x()].map(|axis| grasp.rotation * axis);
        Error::at(
            place.clone(),
            format_args!(
                "the given angles hold the grasp {:.4} m above the floor, tilted by {:.2} deg and turned by {:.2} deg from straight ahead; it must be level, straight ahead, at grasp_height_m = {} m: {why}",
                at.z,
                math::acos(up.z.clamp(-1.0, 1.0)).to_degrees(),
                math::atan2(ahead.y, ahead.x).to_degrees(),
                robot.grasp_height
            ),
        )
    };
    let closed = match robot.freedom() {
        free @ 0..FULL => {
            robot.level(given, robot.grasp_height, &Rotation3::identity()).ok_or_else(|| {
                fault(format!(
                    "the arm moves its grasp in {free} of 6 directions, and does not come within {HEIGHT_TOLERANCE_M} m and {TURN_TOLERANCE_RAD} rad of that; give closer angles or another grasp_height_m"
                ))
            })?
        }
        _ => {
            let closed = robot.close(&start, &level, TOLERANCE);
            closed.ok_or_else(|| fault("no angles near the given ones achieve that".to_owned()))?.0.joints
        }
    };
    for (i, joint) in robot.joints.iter().enumerate() {
        let position = closed[i];
        let by = (position - given[i]).abs();
        let most = if joint.motion == Motion::Prismatic { MAX_SLIDE_M } else { MAX_TURN_RAD };
        if by > most {
            return Err(fault(format!(
                "`{}` would have to move by {by:.4}, more than {most} (rad or m); give closer angles",
                joint.name
            )));
        }
        let (lower, upper) = (joint.lower, joint.upper);
        if !(lower..=upper).contains(&position) {
            return Err(fault(format!(
                "`{}` would have to be at {position:.6}, beyond its limits from {lower} to {upper} (rad or m)",
                joint.name
            )));
        }
    }
    if let Some(why) = robot.immovable(&closed) {
        return Err(Error::at(place, format_args!("the robot cannot carry from here. {why}")));
    }
    Ok(Posture { name: entry.name.clone(), joints: closed })
}

/// The given positions, one for every arm joint, rad or m.
fn angles(source: Source, spanned: &Spanned<PostureEntry>, robot: &Robot) -> Result<JointVector, Error> {
    let entry = spanned.get_ref();
    let item = format!("posture `{}`", entry.name);
    let mut joints = JointVector::zeros();
    let mut is_given = vec![false; robot.joint_count()];
    let angles = entry.angles_deg.iter().map(|given| (given, Motion::Revolute));
    let positions = entry.positions_m.iter().map(|given| (given, Motion::Prismatic));
    for ((name, value), motion) in angles.chain(positions) {
        let place = source.place(value, item.clone());
        let Some(i) = robot.joints.iter().position(|j| j.name == *name) else {
            let known = robot.joints.iter().map(|j| j.name.as_str());
            return Err(Error::unknown(place, "independent joint of the arm", name, known, MAX_LISTED));
        };
        if robot.joints[i].motion != motion {
            let (kind, key) = match robot.joints[i].motion {
                Motion::Revolute => ("revolute", "angles_deg"),
                Motion::Prismatic => ("prismatic", "positions_m"),
            };
            return Err(other_unit(place, name, kind, key));
        }
        let (number, largest, expected) = match motion {
            Motion::Revolute => {
                (value.get_ref().to_radians(), 3600.0, "an angle from -3600 to 3600 (degrees)")
            }
            Motion::Prismatic => (*value.get_ref(), 100.0, "a position from -100 to 100 (metres)"),
        };
        if value.get_ref().abs() > largest || !number.is_finite() {
            return Err(Error::number(place, name, *value.get_ref(), expected));
        }
        joints[i] = number;
        is_given[i] = true;
    }
    match is_given.iter().position(|given| !given) {
        None => Ok(joints),
        Some(i) => {
            let joint = &robot.joints[i];
            let key = if joint.motion == Motion::Revolute { "angles_deg" } else { "positions_m" };
            let needed = format!("`{}` under {key}; every independent joint needs a position", joint.name);
            Err(Error::missing(source.place(spanned, item), needed))
        }
    }
}
