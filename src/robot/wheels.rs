//! The differential drive, found from its two wheel joints.

use super::Drive;
use super::error::RobotError;
use super::fault::WheelFault;
use super::link::{Geometry, JointKind, Link, Shape};
use super::note::RobotNote;
use super::urdf::Urdf;
use crate::geometry::Pose;
use crate::located::Place;
use crate::math;
use nalgebra::{Point3, Rotation3, Vector3};
use std::collections::BTreeMap;

/// Largest difference between two lengths that must agree, m.
const SAME_LENGTH_M: f64 = 1e-3;
/// Largest share by which a calibrated radius or track may differ from the URDF's.
const CALIBRATION: f64 = 0.1;
/// Largest difference between two directions that must agree, rad.
const SAME_DIRECTION_RAD: f64 = 1e-3;

/// A wheel in the base's frame.
struct Wheel {
    /// Centre in the base's frame, m.
    middle: Point3<f64>,
    radius: f64,
    /// The radius measured, where the robot file gives another.
    replaced: Option<f64>,
    /// Rate limit, rad/s.
    rate: f64,
}

/// The wheels that the robot file names: indices of their links, left first, and the places of their names.
pub(super) struct Wheels<'a> {
    pub base: usize,
    pub grasp: usize,
    pub links: [usize; 2],
    /// The radius given in the robot file, m.
    pub radius: Option<f64>,
    /// The distance between the wheels given in the robot file, m.
    pub track: Option<f64>,
    /// The rate limit given in the robot file, rad/s.
    pub rate: Option<f64>,
    pub base_radius: f64,
    /// Positions of held joints by name, rad or m, such as of a suspension.
    pub held: BTreeMap<&'a str, f64>,
}

impl Wheels<'_> {
    /// The drive, `drive_from_base`, and notes; the drive's frame is on the floor, midway between the wheels'
    /// centres. The error is the first fault of each wheel, or of the two together.
    pub fn measure(
        &self,
        urdf: Urdf,
        links: &[Link],
    ) -> Result<(Drive, Pose, Vec<RobotNote>), Vec<RobotError>> {
        let name = |i: usize| links[i].joint.as_ref().map_or("", |j| j.name.as_str());
        let place = |i: usize| -> Place { urdf.place(format!("joint `{}`", name(i))) };
        let [left, right] = [0, 1].map(|side| {
            let fault = |why| RobotError::NotAWheel { place: place(self.links[side]), why };
            self.wheel(links, self.links[side]).map_err(fault)
        });
        let (left, right) = match (left, right) {
            (Ok(left), Ok(right)) => (left, right),
            (left, right) => return Err([left.err(), right.err()].into_iter().flatten().collect()),
        };
        let sides = [(left.middle.y, "left", "positive"), (-right.middle.y, "right", "negative")];
        for (i, (y, side, sign)) in self.links.into_iter().zip(sides) {
            if y <= 0.0 {
                let y = if side == "left" { y } else { -y };
                let why = WheelFault::Side { y, side, sign };
                return Err(vec![RobotError::NotAWheel { place: place(i), why }]);
            }
        }
        for (what, left, right, tolerance, rule) in [
            ("x in the base (m)", left.middle.x, right.middle.x, SAME_LENGTH_M, "they must be the same"),
            (
                "distance from the middle of the base (m)",
                left.middle.y,
                -right.middle.y,
                SAME_LENGTH_M,
                "they must be the same",
            ),
            ("z in the base (m)", left.middle.z, right.middle.z, SAME_LENGTH_M, "they must be the same"),
            ("radius (m)", left.radius, right.radius, 1e-6, "they must be the same"),
            ("limit velocity (rad/s)", left.rate, right.rate, 1e-6, "they must be the same"),
        ] {
            if (left - right).abs() > tolerance {
                let left_joint = name(self.links[0]).to_owned();
                let why = WheelFault::Unlike { what, left_joint, left, right, rule };
                return Err(vec![RobotError::NotAWheel { place: place(self.links[1]), why }]);
            }
        }
        let middle = nalgebra::center(&left.middle, &right.middle);
        let measured = left.middle.y - right.middle.y;
        let mut notes = Vec::new();
        if let Some(measured) = left.replaced {
            notes.push(RobotNote::Calibrated { key: "wheel_radius_m", given: left.radius, measured });
        }
        if let Some(given) = self.track.filter(|&given| given != measured) {
            if (given - measured).abs() > CALIBRATION * measured {
                let why = WheelFault::Track { measured, given };
                return Err(vec![RobotError::NotAWheel { place: place(self.links[0]), why }]);
            }
            notes.push(RobotNote::Calibrated { key: "wheel_separation_m", given, measured });
        }
        let drive = Drive {
            track: self.track.unwrap_or(measured),
            wheel_radius: left.radius,
            rim_speed_limit: left.rate * left.radius,
            base_radius: self.base_radius,
        };
        let floor = Vector3::new(middle.x, middle.y, middle.z - left.radius);
        Ok((drive, Pose::from_parts((-floor).into(), Rotation3::identity()), notes))
    }

    fn wheel(&self, links: &[Link], i: usize) -> Result<Wheel, WheelFault> {
        let base = || links[self.base].name.clone();
        let elsewhere = |root: &Link| WheelFault::Elsewhere { base: base(), root: root.name.clone() };
        let Some(joint) = &links[i].joint else { return Err(elsewhere(&links[i])) };
        if joint.kind != JointKind::Continuous {
            return Err(WheelFault::Kind { kind: joint.kind.name() });
        }
        if let Some(mimic) = &joint.mimic {
            return Err(WheelFault::Mimics { joint: mimic.joint.clone() });
        }
        let mut arm = std::iter::successors(Some(self.grasp), |&at| links[at].parent);
        if arm.any(|at| at == i) {
            return Err(WheelFault::CarriesArm { grasp: links[self.grasp].name.clone() });
        }
        let mut base_from_wheel = joint.parent_from_joint;
        let mut at = links[i].parent.unwrap_or(i);
        while at != self.base {
            let (Some(parent), Some(between)) = (links[at].parent, &links[at].joint) else {
                return Err(elsewhere(&links[at]));
            };
            let held = self.held.get(between.name.as_str()).copied();
            if between.kind != JointKind::Fixed && held.is_none() {
                let (joint, kind) = (between.name.clone(), between.kind.name());
                return Err(WheelFault::Loose { base: base(), joint, kind });
            }
            base_from_wheel = between.parent_from_link(held.unwrap_or(0.0)) * base_from_wheel;
            at = parent;
        }
        let axis = base_from_wheel.rotation * joint.axis.into_inner();
        if math::hypot(axis.x, axis.z) > SAME_DIRECTION_RAD {
            return Err(WheelFault::Axis { x: axis.x, y: axis.y, z: axis.z });
        }
        let rate = self.rate.unwrap_or(joint.limits.rate);
        if !(rate > 0.0 && rate.is_finite()) {
            return Err(WheelFault::Rate { rate });
        }
        let found = rolling(&links[i].collisions).or_else(|| rolling(&links[i].visuals));
        let (radius, replaced, middle) = match (found, self.radius) {
            (None, None) => return Err(WheelFault::NoRadius),
            (None, Some(given)) => (given, None, Vector3::zeros()),
            (Some((shape, measured)), given) => {
                let middle = along_axis(shape, &joint.axis)?;
                if let Some(given) = given.filter(|g| (g - measured).abs() > CALIBRATION * measured) {
                    return Err(WheelFault::Radius { measured, given });
                }
                (given.unwrap_or(measured), given.map(|_| measured), middle)
            }
        };
        Ok(Wheel { middle: base_from_wheel * Point3::from(middle), radius, replaced, rate })
    }
}

/// The cylinder or sphere of the largest radius, and that radius.
fn rolling(shapes: &[Geometry]) -> Option<(&Geometry, f64)> {
    let round = shapes.iter().filter_map(|g| match g.shape {
        Shape::Cylinder { radius, .. } | Shape::Sphere { radius } => Some((g, radius)),
        _ => None,
    });
    round.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The centre of a wheel's shape in the wheel's frame. The shape must be centred on the joint's axis.
fn along_axis(geometry: &Geometry, axis: &Vector3<f64>) -> Result<Vector3<f64>, WheelFault> {
    let middle = geometry.link_from_shape.translation.vector;
    let by_m = axis.cross(&middle).norm();
    let (shape, sine) = match geometry.shape {
        Shape::Sphere { .. } => ("sphere", 0.0),
        _ => ("cylinder", (geometry.link_from_shape.rotation * Vector3::z()).cross(axis).norm()),
    };
    if by_m > SAME_LENGTH_M || sine > SAME_DIRECTION_RAD {
        return Err(WheelFault::Eccentric { shape, by_m, by_deg: math::asin(sine.min(1.0)).to_degrees() });
    }
    Ok(axis * axis.dot(&middle))
}
